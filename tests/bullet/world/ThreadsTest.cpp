// SPDX-License-Identifier: GPL-3.0-or-later
// btClodDispatcher on several threads: the same bits as on one, whatever meets whatever; nothing is shared that should not
// be (ThreadSanitizer: nightly_threads_sanitized).
#include <gtest/gtest.h>

#include <sys/resource.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <set>
#include <stdexcept>
#include <thread>

#include "clod/schedule/ThreadPool.h"
#include "tests/bullet/Toruses.h"
#include "tests/bullet/world/MixedWorld.h"

namespace clod::test
{
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
	MixedWorld one(1);
	const std::uint64_t expected = one.run(200);
	EXPECT_GT(one.context.lastStep().points, 40u);
	for (const unsigned threads : {2U, 4U})
	{
		MixedWorld several(threads);
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

// Bodies that fall askew onto a floor of tiles, and on each other: what a pair finds goes by what others of a tile, of a
// compound's children and of a body that is shoved have told, in whatever order they are asked.
class TiledFloor
{
public:
	enum class Fall
	{
		kBoxes,
		kTwins,
		kNestedTwins
	};
	TiledFloor(unsigned threads, Fall fall)
	{
		m_context.warn = {};
		m_dispatcher.setThreads(threads);
		EXPECT_TRUE(btClodCollisionAlgorithm::registerAlgorithm(&m_dispatcher, &m_context));
		m_world.setGravity(btVector3(0, btScalar(-9.81), 0));
		for (const double side : {-0.9, 0.9})
			m_twin.addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(side), 0, 0)), &m_box);
		m_nested.addChildShape(btTransform::getIdentity(), &m_twin);
		for (int x = -4; x <= 4; ++x)
			for (int z = -4; z <= 4; ++z) add(m_box, 0, btVector3(btScalar(x), btScalar(-0.25), btScalar(0.7 * z)));
		btCollisionShape* const shapes[] = {&m_box, &m_twin, &m_nested};
		std::mt19937 random(0);
		std::uniform_real_distribution<double> offset(-1, 1);
		for (int i = 0; i < 24; ++i)
		{
			const auto vector = [&](double x, double y, double z)
			{
				const double along = x * offset(random), across = z * offset(random);
				return btVector3(btScalar(along), btScalar(y), btScalar(across));
			};
			const btVector3 at = vector(2, 0.6 + 0.7 * (i / 3), 1.5), spin = vector(1, offset(random), 1);
			add(*shapes[int(fall)], 1, at).setAngularVelocity(spin);
		}
	}
	~TiledFloor()
	{
		for (const auto& body : m_bodies) m_world.removeRigidBody(body.get());
	}
	std::uint64_t run(int steps) { return hashOfWay(m_world, m_bodies, btScalar(1.0 / 120), steps); }

private:
	btRigidBody& add(btCollisionShape& shape, double mass, const btVector3& at)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape.calculateLocalInertia(btScalar(mass), inertia);
		btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, &shape, inertia);
		info.m_startWorldTransform.setOrigin(at);
		m_bodies.push_back(std::make_unique<btRigidBody>(info));
		m_world.addRigidBody(m_bodies.back().get());
		return *m_bodies.back();
	}
	Context m_context;
	btClodShape m_box{patchHierarchy(boxMesh({1, 0.5, 0.7}, {4, 2, 3}, 2))};
	btCompoundShape m_twin, m_nested;
	btDefaultCollisionConfiguration m_configuration;
	btClodDispatcher m_dispatcher{&m_configuration, &m_context};
	btDbvtBroadphase m_broadphase;
	btSequentialImpulseConstraintSolver m_solver;
	btDiscreteDynamicsWorld m_world{&m_dispatcher, &m_broadphase, &m_solver, &m_configuration};
	std::vector<std::unique_ptr<btRigidBody>> m_bodies;
};

TEST(Threads, TellPairsTheSameOfOthers)
{
	using Fall = TiledFloor::Fall;
	for (const Fall fall : {Fall::kBoxes, Fall::kTwins, Fall::kNestedTwins})
		EXPECT_EQ(TiledFloor(3, fall).run(120), TiledFloor(1, fall).run(120)) << int(fall);
}

// What is outlined first is asked later, of planes and meshes, too.
TEST(Threads, AndAFullBudgetGiveTheTrajectoryOfNone)
{
	const std::uint64_t none = MixedWorld(1).run(200);
	for (const unsigned threads : {1U, 3U})
		for (const bool inTests : {true, false})
		{
			MixedWorld full(threads);
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
		MixedWorld scene(threads, 3, 4, body);
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
	MixedWorld one(1), changing(1);
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
		MixedWorld scene(threads);
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
		MixedWorld scene(threads);
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
		MixedWorld scene(1, 3, 4, nullptr, context);
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
		MixedWorld scene(threads);
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
}  // namespace clod::test
