// SPDX-License-Identifier: GPL-3.0-or-later
// btClodDispatcher on several threads: the same bits as on one, whatever meets whatever; nothing is shared that should not
// be (ThreadSanitizer: nightly_threads_sanitized).
#include <gtest/gtest.h>

#include <BulletCollision/CollisionDispatch/btSimulationIslandManager.h>
#include <sys/resource.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <set>
#include <stdexcept>
#include <thread>

#include "clod/bullet/btClodDynamicsWorld.h"
#include "clod/schedule/ThreadPool.h"
#include "tests/bullet/NumberHash.h"
#include "tests/bullet/PatchHierarchy.h"
#include "tests/bullet/Toruses.h"

namespace clod::test
{
namespace
{
// Bodies of all kinds of partners: ours, a plane, an engine's mesh, one whose triangles only one thread may read, a
// compound's child, and one of another scale.
class Mixed
{
public:
	// passes, parts: of a step at most. Of boxes, or of another body, at a radius of 1 then.
	explicit Mixed(unsigned threads, int passes = 1, int parts = 1, const std::shared_ptr<const Hierarchy>& body = nullptr,
				   Context* shared = nullptr)
		: context(shared ? *shared : m_own),
		  m_hierarchy(body ? body : patchHierarchy(boxMesh({1, 0.5, 0.7}, {4, 2, 3}, 2)))
	{
		const btScalar scale = body ? btScalar(1 / double(body->asset().radius)) : 1;
		m_box.setLocalScaling(btVector3(scale, scale, scale));
		m_dispatcher.setThreads(threads);
		m_world.setMostPasses(passes);
		m_world.setMostParts(parts);
		EXPECT_TRUE(btClodCollisionAlgorithm::registerAlgorithm(&m_dispatcher, &context));
		if (!shared) context.warn = [this](const std::string& message) { said.push_back(message); };
		m_world.setGravity(btVector3(0, btScalar(-9.81), 0));
		m_larger.setLocalScaling(btScalar(1.3) * m_box.getLocalScaling());
		m_compound.addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(0.1), 0)), &m_box);
		m_mesh.addTriangle(btVector3(-9, 0, -9), btVector3(9, 0, -9), btVector3(0, 0, 9));
		m_bvh = std::make_unique<btBvhTriangleMeshShape>(&m_mesh, true);
		add(m_plane, 0, btVector3(0, -2, 0));
		add(*m_bvh, 0, btVector3(btScalar(0.5), 0, 0));
		btCollisionShape* const shapes[] = {&m_box, &m_box, &m_larger, &m_compound};
		for (int i = 0; i < 24; ++i)
			add(*shapes[i % 4], 1,
				btScalar(body ? 2.5 : 1) *
					btVector3(btScalar(i % 3) - 1, btScalar(0.8 + 0.7 * (i / 3)), btScalar(0.2 * (i % 5))));
	}
	~Mixed()
	{
		for (const auto& body : m_bodies) m_world.removeRigidBody(body.get());
	}
	std::uint64_t run(int steps)
	{
		std::uint64_t hash = 0;
		for (int i = 0; i < steps; ++i)
		{
			m_world.stepSimulation(btScalar(1.0 / 120), 0);
			for (const auto& body : m_bodies)
				for (int k = 0; k < 3; ++k) hash = mixed(hash, double(body->getWorldTransform().getOrigin()[k]));
		}
		return hash;
	}
	btClodDynamicsWorld& world() { return m_world; }
	btClodDispatcher& dispatcher() { return m_dispatcher; }
	const btRigidBody& last() const { return *m_bodies.back(); }
	btRigidBody& first() { return *m_bodies[2]; }
	// What a program saves besides contacts.
	struct Place
	{
		btTransform pose, interpolation;
		btVector3 linear, angular;
	};
	std::vector<Place> places() const
	{
		std::vector<Place> all;
		for (const auto& body : m_bodies)
			all.push_back({body->getWorldTransform(), body->getInterpolationWorldTransform(), body->getLinearVelocity(),
						   body->getAngularVelocity()});
		return all;
	}
	void putBack(const std::vector<Place>& places)
	{
		for (std::size_t i = 0; i < places.size(); ++i)
		{
			btRigidBody& body = *m_bodies[i];
			body.setWorldTransform(places[i].pose);
			body.setInterpolationWorldTransform(places[i].interpolation);
			body.setLinearVelocity(places[i].linear);
			body.setAngularVelocity(places[i].angular);
			body.updateInertiaTensor();
		}
	}

	Context& context;
	std::vector<std::string> said;

private:
	void add(btCollisionShape& shape, btScalar mass, const btVector3& at)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) m_box.calculateLocalInertia(mass, inertia);
		btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &shape, inertia);
		info.m_startWorldTransform.setOrigin(at);
		m_bodies.push_back(std::make_unique<btRigidBody>(info));
		m_bodies.back()->setActivationState(DISABLE_DEACTIVATION);
		m_world.addRigidBody(m_bodies.back().get());
	}

	Context m_own;
	std::shared_ptr<const Hierarchy> m_hierarchy;
	btClodShape m_box{m_hierarchy}, m_larger{m_hierarchy};
	btCompoundShape m_compound;
	btTriangleMesh m_mesh;
	std::unique_ptr<btBvhTriangleMeshShape> m_bvh;
	btStaticPlaneShape m_plane{btVector3(0, 1, 0), 0};
	btDefaultCollisionConfiguration m_configuration;
	btClodDispatcher m_dispatcher{&m_configuration, &context};
	btDbvtBroadphase m_broadphase;
	btSequentialImpulseConstraintSolver m_solver;
	btClodDynamicsWorld m_world{&m_dispatcher, &m_broadphase, &m_solver, &m_configuration, &context};
	std::vector<std::unique_ptr<btRigidBody>> m_bodies;
};
}  // namespace

TEST(ThreadPool, DoesEveryPartOnceAndIsUsedAgain)
{
	for (const unsigned threads : {1U, 2U, 5U})
	{
		ThreadPool pool(threads);
		EXPECT_EQ(pool.threads(), threads);
		for (const std::uint32_t count : {0U, 1U, 3U, 1000U})
			for (int round = 0; round < 20; ++round)
			{
				std::vector<std::atomic<int>> done(count);
				pool.run(count, [&](std::uint32_t i) { ++done[i]; });
				for (const auto& each : done) ASSERT_EQ(each, 1);
			}
	}
	EXPECT_LE(ThreadPool(unsigned(-1)).threads(), ThreadPool::kMostThreads);
}

#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
// A machine may give fewer threads than are asked for, as where their number is limited. (In a process of its own, where there
// is room for few stacks.)
TEST(ThreadPool, MakesDoWithTheThreadsThatThereAre)
{
	const auto work = []
	{
		const rlimit few{rlim_t(1) << 30, rlim_t(1) << 30};
		setrlimit(RLIMIT_AS, &few);
		ThreadPool pool(1000);
		std::atomic<int> done{0};
		pool.run(1000, [&done](std::uint32_t) { ++done; });
		std::_Exit(done == 1000 && pool.threads() > 1 && pool.threads() < 1000 ? 0 : 1);
	};
	EXPECT_EXIT(work(), testing::ExitedWithCode(0), "");
}
#endif

TEST(ThreadPool, UsesItsThreadsAndThrowsOn)
{
	ThreadPool pool(3);
	std::mutex mutex;
	std::set<std::thread::id> ids;
	std::atomic<int> arrived{0};
	pool.run(3,
			 [&](std::uint32_t)
			 {
				 ++arrived;
				 while (arrived < 3) std::this_thread::yield();
				 const std::lock_guard<std::mutex> lock(mutex);
				 ids.insert(std::this_thread::get_id());
			 });
	EXPECT_EQ(ids.size(), 3u);
	EXPECT_THROW(pool.run(9, [](std::uint32_t i) { if (i == 5) throw std::runtime_error("five"); }), std::runtime_error);
	std::atomic<int> done{0};
	pool.run(9, [&](std::uint32_t) { ++done; });
	EXPECT_EQ(done, 9);
}

TEST(Threads, GiveTheSameTrajectoryHoweverMany)
{
	Mixed one(1);
	const std::uint64_t expected = one.run(200);
	EXPECT_GT(one.context.lastStep().points, 40u);
	for (const unsigned threads : {2U, 4U})
	{
		Mixed several(threads);
		EXPECT_EQ(several.dispatcher().threads(), threads);
		EXPECT_EQ(several.run(200), expected) << threads;
		EXPECT_EQ(several.said, one.said);
	}
	Toruses alone(true);
	const std::uint64_t whole = alone.run(120, kOff), later = alone.run(30, kOff), counted = Toruses(true).run(120, 500);
	for (const unsigned threads : {2U, 4U})
	{
		Toruses shared(true), budgeted(true);
		shared.setThreads(threads);
		budgeted.setThreads(threads);
		EXPECT_EQ(shared.run(120, kOff), whole) << threads;
		EXPECT_EQ(shared.run(30, kOff, 1e12), later) << threads;
		EXPECT_EQ(budgeted.run(120, 500), counted) << threads;
	}
}

// What is outlined first is asked later, of planes and meshes, too.
TEST(Threads, AndAFullBudgetGiveTheTrajectoryOfNone)
{
	const std::uint64_t none = Mixed(1).run(200);
	for (const unsigned threads : {1U, 3U})
		for (const bool inTests : {true, false})
		{
			Mixed full(threads);
			(inTests ? full.context.budget.tests : full.context.budget.microseconds) = 1e12;
			EXPECT_EQ(full.run(200), none) << threads << inTests;
		}
}

// Pairs that are asked again within a step, and in parts of it; and those that keep their points as they hardly move.
TEST(Threads, GiveTheSamePassesAndKeptPoints)
{
	struct Counts
	{
		std::uint64_t hash;
		int askedAgain = 0, parts = 0, kept = 0;
		bool operator==(const Counts& other) const
		{
			return hash == other.hash && askedAgain == other.askedAgain && parts == other.parts && kept == other.kept;
		}
	};
	const auto run = [](unsigned threads, int steps, const std::shared_ptr<const Hierarchy>& body = nullptr)
	{
		Mixed scene(threads, 3, 4, body);
		Counts counts{0};
		for (int i = 0; i < steps; ++i)
		{
			counts.hash = mixed(scene.run(1), double(counts.hash >> 11));
			counts.askedAgain += scene.world().pairsAskedAgain();
			counts.parts += scene.world().parts() - 1;
			counts.kept += int(scene.context.lastStep().keptPairs);
		}
		return counts;
	};
	const Counts boxes = run(1, 400);
	EXPECT_GT(boxes.askedAgain, 100);
	EXPECT_GT(boxes.parts, 10);
	EXPECT_GT(boxes.kept, 10);
	const Counts digits = run(1, 80, test::body("number8", 600).hierarchy);
	EXPECT_GT(digits.askedAgain, 10);
	for (const unsigned threads : {2U, 3U}) EXPECT_TRUE(run(threads, 400) == boxes) << threads;
	EXPECT_TRUE(run(3, 80, test::body("number8", 600).hierarchy) == digits);
}

// From step to step.
TEST(Threads, MayChangeInNumber)
{
	Mixed one(1), changing(1);
	for (int i = 0; i < 12; ++i)
	{
		changing.dispatcher().setThreads(unsigned(i % 4));  // 0: all cores
		EXPECT_GE(changing.dispatcher().threads(), 1u);
		ASSERT_EQ(changing.run(10), one.run(10)) << i;
	}
}

// A program's own near callback decides which pairs meet, one after the other.
TEST(Threads, LeaveTheNearCallbackItsSay)
{
	const auto run = [](unsigned threads)
	{
		Mixed scene(threads);
		std::uint64_t hash = 0;
		for (int i = 0; i < 60; ++i)
		{
			scene.dispatcher().setNearCallback(
				i % 3 == 1 ? [](btBroadphasePair&, btCollisionDispatcher&, const btDispatcherInfo&) {}
						   : &btCollisionDispatcher::defaultNearCallback);
			hash = 31 * hash + scene.run(1);
		}
		return hash;
	};
	EXPECT_EQ(run(3), run(1));
}

// Some pairs once more within a step, in any order: the others keep what they have.
TEST(Threads, PairsCanBeDispatchedAgain)
{
	const auto run = [](unsigned threads)
	{
		Mixed scene(threads);
		std::uint64_t hash = 0;
		for (int i = 0; i < 60; ++i)
		{
			hash = 31 * hash + scene.run(1);
			btBroadphasePairArray& all = scene.world().getPairCache()->getOverlappingPairArray();
			std::vector<btBroadphasePair*> some;
			for (int k = all.size() - 1; k >= 0; k -= 2) some.push_back(&all[k]);
			scene.first().translate(btVector3(0, btScalar(1e-3), 0));
			scene.dispatcher().dispatchPairs(some, scene.world().getDispatchInfo());
		}
		return hash;
	};
	EXPECT_EQ(run(4), run(1));
}

// Neither world notices the other, nor those that come and go beside them.
TEST(Threads, OfTheirOwnMayStepWorldsOfACommonContext)
{
	const auto run = [](Context* context, int steps, int& passes)
	{
		Mixed scene(1, 3, 4, nullptr, context);
		std::uint64_t hash = 0;
		for (int i = 0; i < steps; ++i)
		{
			hash = mixed(hash, double(scene.run(1)));
			passes += scene.world().passes() + scene.world().parts() - 2;
		}
		return hash;
	};
	int passes = 0;
	const std::uint64_t alone = run(nullptr, 150, passes);
	EXPECT_GT(passes, 50);
	Context common;
	common.warn = {};  // set once, as others run
	std::atomic<int> running{2};
	std::array<std::uint64_t, 2> hashes{};
	std::vector<std::thread> threads;
	for (std::uint64_t& hash : hashes)
		threads.emplace_back(
			[&]
			{
				int ignored = 0;
				hash = run(&common, 150, ignored);
				--running;
			});
	int others = 0;
	while (running > 0) run(&common, 3, others);
	for (std::thread& thread : threads) thread.join();
	for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, alone);
}

TEST(Threads, CallTheProgramsFunctionsFromWhereverTheyAre)
{
	std::atomic<int> calls{0};
	const auto run = [&calls](unsigned threads)
	{
		Mixed scene(threads);
		scene.context.pairMetric = [&calls](const btCollisionObject&, const btCollisionObject&, ContactMetric& metric)
		{
			++calls;
			metric = ContactMetric::deviationShare(0.05);
			return true;
		};
		return scene.run(60);
	};
	const std::uint64_t one = run(1);
	const int callsOfOne = calls.exchange(0);
	EXPECT_EQ(run(4), one);
	EXPECT_EQ(calls, callsOfOne);
}

// From a fall, where pairs have come since, and from rest; wherever Bullet has ended no pair since. Islands that are split
// are made of boxes that have a history: from one start in ten they went another way.
TEST(SavedContacts, PutBackWithTheBodiesAWorldGoesAsItDid)
{
	std::uint32_t kept = 0;
	int whole = 0;
	for (const auto& [start, steps] : {std::pair{40, 8}, {50, 8}, {60, 8}, {520, 40}, {640, 40}, {680, 40}, {740, 40}})
		for (const int passes : {1, 3})
		{
			Mixed scene(2, passes, passes);
			scene.world().getDispatchInfo().m_deterministicOverlappingPairs = true;
			scene.world().getSimulationIslandManager()->setSplitIslands(false);
			const auto save = [&] { return scene.context.saveContacts(scene.dispatcher()); };
			scene.run(start);
			const auto places = scene.places();
			const auto contacts = save();
			const int parts = scene.world().expectedParts();
			std::size_t gone = 0;
			std::vector<std::uint64_t> ways[2];
			for (auto& way : ways)
			{
				for (int i = 0; i < steps; ++i)
				{
					way.push_back(scene.run(1));
					way.push_back(hashOf(*save()));
					kept += scene.context.lastStep().keptPairs;
				}
				EXPECT_NE(way.back(), hashOf(*contacts));
				gone += scene.context.restoreContacts(scene.dispatcher(), *contacts);
				EXPECT_TRUE(gone > 0 || hashOf(*save()) == hashOf(*contacts)) << start;
				scene.putBack(places);
				scene.world().expectParts(parts);
			}
			if (gone > 0) continue;
			++whole;
			const auto first = std::mismatch(ways[0].begin(), ways[0].end(), ways[1].begin()).first;
			EXPECT_EQ(first - ways[0].begin(), 2 * steps) << start << ", " << passes;
		}
	EXPECT_GE(whole, 9) << whole;
	EXPECT_GT(kept, 100U);
}

// Whose boxes have parted begin anew.
TEST(SavedContacts, OfPairsThatAreNoLongerThereAreToldOf)
{
	Mixed scene(1);
	scene.run(240);
	const auto contacts = scene.context.saveContacts(scene.dispatcher());
	const auto places = scene.places();
	auto apart = places;
	for (std::size_t i = 0; i < apart.size(); ++i) apart[i].pose.getOrigin() += btVector3(0, btScalar(50 * i), 0);
	scene.putBack(apart);
	scene.run(30);
	EXPECT_GT(scene.context.restoreContacts(scene.dispatcher(), *contacts), 0U);
	EXPECT_NE(hashOf(*scene.context.saveContacts(scene.dispatcher())), hashOf(*contacts));
	scene.putBack(places);
	scene.run(240);
	EXPECT_GT(scene.context.lastStep().points, 40U);
}

TEST(SavedContacts, AreTheSameHoweverManyThreadsThereWere)
{
	const auto run = [](unsigned threads, int steps)
	{
		Mixed scene(threads);
		scene.run(steps);
		return hashOf(*scene.context.saveContacts(scene.dispatcher()));
	};
	const std::uint64_t one = run(1, 200);
	EXPECT_EQ(run(3, 200), one);
	EXPECT_NE(run(1, 199), one);
}
}  // namespace clod::test
