// SPDX-License-Identifier: GPL-3.0-or-later
// What happens to pairs and manifolds as worlds change under them.
#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <optional>
#include <set>

#include "tests/bullet/CubeOnSlab.h"
#include "tests/bullet/ManifoldState.h"
#include "tests/bullet/NumberHash.h"

namespace clod::test
{
namespace
{
std::uint64_t poseHash(const btRigidBody& body, std::uint64_t hash)
{
	const btTransform& pose = body.getWorldTransform();
	for (int i = 0; i < 3; ++i)
		for (const btScalar value : {pose.getOrigin()[i], pose.getBasis()[i][0], pose.getBasis()[i][1]})
			hash = mixed(hash, double(value));
	return hash;
}

int gEnded = 0, gStarted = 0, gDestroyed = 0;
}  // namespace

TEST(Lifecycle, RemovalLeavesNoManifold)
{
	CubeOnSlab scene;
	scene.step(10);
	EXPECT_GT(scene.dispatcher.getNumManifolds(), 0);
	EXPECT_EQ(scene.context.lastStep().pairs, 1u);
	scene.world.removeRigidBody(&scene.body);
	EXPECT_EQ(scene.dispatcher.getNumManifolds(), 0);
	EXPECT_EQ(scene.context.lastStep().pairs, 0u);
}

TEST(Lifecycle, PointsPersistAndKeepTheirImpulses)
{
	CubeOnSlab scene;
	scene.step(240);
	btManifoldArray manifolds;
	scene.world.getPairCache()->getOverlappingPairArray()[0].m_algorithm->getAllContactManifolds(manifolds);
	ASSERT_GT(manifolds.size(), 0);
	double impulse = 0;
	int oldest = 0;
	for (int i = 0; i < manifolds.size(); ++i)
		for (int k = 0; k < manifolds[i]->getNumContacts(); ++k)
		{
			impulse += double(manifolds[i]->getContactPoint(k).m_appliedImpulse);
			oldest = std::max(oldest, manifolds[i]->getContactPoint(k).getLifeTime());
		}
	EXPECT_NEAR(impulse, 9.81 / 240, 1e-3 * 9.81 / 240);
	EXPECT_GT(oldest, 100);
}

namespace
{
int gProcessed = 0, gAdded = 0;

// What Bullet does with the points of a held pair, step by step.
struct Ageing
{
	std::vector<int> lifeTimes, processed;
	int points = 0;
	double impulse = 0;   // of all points at the end
	int newFriction = 0;  // points that have it a step after it was set
	std::vector<int> added;
};
Ageing age(CubeOnSlab& scene)
{
	const SetCallback<ContactProcessedCallback> count(gContactProcessedCallback,
													  [](btManifoldPoint&, void*, void*) { return ++gProcessed > 0; });
	Ageing ageing;
	scene.world.getSolverInfo().m_splitImpulse = false;  // overlap makes impulses, which a held body does not follow
	scene.body.getWorldTransform().setOrigin(btVector3(0, btScalar(0.4995), 0));
	hold(scene.body, true);
	scene.step(10);
	for (int i = 0; i < 5; ++i)
	{
		gProcessed = 0;
		scene.step();
		ageing.processed.push_back(gProcessed);
		ageing.lifeTimes.push_back(manifoldsOf(scene).at(0)->getContactPoint(0).getLifeTime());
	}
	ageing.points = scene.contacts();
	scene.body.setFriction(btScalar(0.25));
	scene.step();
	ageing.impulse = impulseOf(scene);
	for (btPersistentManifold* manifold : manifoldsOf(scene))
		for (int k = 0; k < manifold->getNumContacts(); ++k)
			ageing.newFriction += manifold->getContactPoint(k).m_combinedFriction == btScalar(0.6) * btScalar(0.25);
	const SetCallback<ContactAddedCallback> countAdded(
		gContactAddedCallback, [](btManifoldPoint&, const btCollisionObjectWrapper*, int, int,
								  const btCollisionObjectWrapper*, int, int) { return ++gAdded > 0; });
	for (const bool wanted : {false, true})
	{
		if (wanted)
			scene.body.setCollisionFlags(scene.body.getCollisionFlags() |
										 btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
		gAdded = 0;
		scene.step();
		ageing.added.push_back(gAdded);
	}
	return ageing;
}
}  // namespace

TEST(Lifecycle, UnchangedPointsAgeAndAreCalledLikeThoseOfBulletsHulls)
{
	CubeOnSlab ours, hulls;
	const auto hull = [&hulls](const btVector3& half) -> btConvexHullShape&
	{
		auto& shape = hulls.add(std::make_unique<btConvexHullShape>());
		for (int corner = 0; corner < 8; ++corner)
			shape.addPoint(half * btVector3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1));
		shape.setMargin(0);
		return shape;
	};
	hulls.ground.setCollisionShape(&hull(btVector3(5, btScalar(0.5), 5)));
	hulls.body.setCollisionShape(&hull(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5))));
	const Ageing mine = age(ours), theirs = age(hulls);
	EXPECT_EQ(mine.lifeTimes, theirs.lifeTimes);  // one more a step
	EXPECT_EQ(mine.processed, std::vector<int>(5, mine.points));
	EXPECT_EQ(theirs.processed, std::vector<int>(5, theirs.points));
	EXPECT_GT(theirs.points, 0);
	EXPECT_GT(mine.impulse, 0);
	EXPECT_GT(theirs.impulse, 0);
	EXPECT_EQ(mine.newFriction, mine.points);
	EXPECT_GT(theirs.newFriction, 0);
	// Added anew in every dispatch, as far as the bodies want to be told.
	EXPECT_EQ(mine.added, (std::vector<int>{0, mine.points}));
	EXPECT_EQ(theirs.added[0], 0);
	EXPECT_GT(theirs.added[1], 0);
}

TEST(Lifecycle, SetCollisionShapeAtRunTimeIsNoticed)
{
	CubeOnSlab scene;
	scene.step(60);
	btClodShape& taller = scene.addShape(patchHierarchy(boxMesh({1, 2, 1}, {2, 4, 2}, 1)));
	scene.body.setCollisionShape(&taller);
	scene.body.getWorldTransform().setOrigin(btVector3(0, btScalar(1.01), 0));
	scene.step(120);
	EXPECT_NEAR(heightOf(scene.body), 1.0, 0.005);
	scene.bodyShape.setLocalScaling(btVector3(1, 1, 1));
	taller.setLocalScaling(btVector3(2, 2, 2));  // now a pair of different scales
	scene.body.getWorldTransform().setOrigin(btVector3(0, btScalar(2.02), 0));
	scene.body.setLinearVelocity(btVector3(0, 0, 0));
	scene.step(120);
	EXPECT_NEAR(heightOf(scene.body), 2.0, 0.01);
}

// By others of any kind: the pair outlives them, and Bullet asks the algorithm that it was made with.
TEST(Lifecycle, OursGiveWayToShapesOfOtherAlgorithms)
{
	CubeOnSlab scene;
	auto& compound = scene.add(std::make_unique<btCompoundShape>());
	compound.addChildShape(btTransform::getIdentity(), &scene.bodyShape);
	auto& box = scene.add(std::make_unique<btBoxShape>(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5))));
	auto& ground = scene.add(std::make_unique<btBoxShape>(btVector3(5, btScalar(0.5), 5)));
	using Shapes = std::pair<btCollisionShape*, btCollisionShape*>;
	const Shapes pairs[] = {
		{&scene.groundShape, &compound}, {&ground, &compound}, {&ground, &box}, {&scene.groundShape, &scene.bodyShape}};
	for (const auto& [below, above] : pairs)
	{
		scene.step(10);
		scene.ground.setCollisionShape(below);
		scene.body.setCollisionShape(above);
		scene.step(120);
		EXPECT_NEAR(heightOf(scene.body), 0.5, 0.01) << below->getName() << above->getName();
		btManifoldArray manifolds;
		scene.world.getPairCache()->getOverlappingPairArray()[0].m_algorithm->getAllContactManifolds(manifolds);
		EXPECT_EQ(manifolds.size(), scene.dispatcher.getNumManifolds());
	}
	scene.world.removeRigidBody(&scene.body);
	EXPECT_EQ(scene.dispatcher.getNumManifolds(), 0);
}

// A shape of a pool: another one in its place has its address and its revision, here even the same surface.
TEST(Lifecycle, AnotherHierarchyInTheSamePlaceIsNoticed)
{
	const auto fine = patchHierarchy(boxMesh({1, 1, 1}, {4, 4, 4}, 1)),
			   coarse = patchHierarchy(boxMesh({1, 1, 1}, {4, 4, 4}, 4));
	std::optional<btClodShape> place(fine);
	BulletWorld scene;
	scene.addBody(*place, 0, {});
	scene.addBody(*place, 1, {0.013, 0.9995, 0.027});
	std::size_t largest = 0, nodes = 0;
	const auto dispatch = [&]
	{
		scene.world.performDiscreteCollisionDetection();
		largest = 0;
		scene.context.forEachPair(
			[&](const PairReport& pair)
			{
				nodes = pair.hierarchyA->nodes().size;
				for (const HeldPoint& held : pair.clusters->points())
					largest = std::max({largest, std::size_t(held.point.nodeA), std::size_t(held.point.nodeB)});
			});
		EXPECT_GT(scene.contacts(), 0);
		EXPECT_LT(largest, nodes);
		return scene.context.lastStep().keptPairs;
	};
	EXPECT_EQ(dispatch(), 0u);
	EXPECT_EQ(dispatch(), 1u);
	ASSERT_GE(largest, coarse->nodes().size);  // an old answer would show
	place.emplace(coarse);
	EXPECT_EQ(dispatch(), 0u);
	EXPECT_EQ(dispatch(), 1u);
}

TEST(Lifecycle, ARestingPairSleepsAndWakes)
{
	CubeOnSlab scene;
	scene.body.forceActivationState(ACTIVE_TAG);
	scene.step(240 * 4);
	EXPECT_FALSE(scene.body.isActive());
	scene.body.activate(true);
	scene.body.setLinearVelocity(btVector3(1, 0, 0));
	scene.step(30);
	EXPECT_GT(double(scene.body.getWorldTransform().getOrigin().x()), 0.02);
	EXPECT_NEAR(heightOf(scene.body), 0.5, 0.01);
}

TEST(Lifecycle, GhostsSeeContactsWithoutResponse)
{
	BulletWorld scene;
	btClodShape& shape = scene.addShape(cube());
	btGhostPairCallback callback;
	scene.broadphase.getOverlappingPairCache()->setInternalGhostPairCallback(&callback);
	btPairCachingGhostObject ghost;
	ghost.setCollisionShape(&scene.addShape(slab()));
	ghost.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(-0.5), 0)));
	ghost.setCollisionFlags(ghost.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
	scene.world.addCollisionObject(&ghost);
	const btRigidBody& body = scene.addBody(shape, 1, {0, 0.49, 0});
	scene.step(24);
	EXPECT_EQ(ghost.getNumOverlappingObjects(), 1);
	EXPECT_GT(scene.contacts(), 0);
	EXPECT_NEAR(heightOf(body), 0.49 - 0.5 * 9.81 * 0.01, 0.01);  // falls freely
	scene.world.removeCollisionObject(&ghost);
}

TEST(Lifecycle, KinematicBodiesCarryOthers)
{
	CubeOnSlab scene;
	scene.ground.setCollisionFlags(scene.ground.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
	for (int i = 0; i < 240; ++i)
	{
		scene.ground.getWorldTransform().setOrigin(btVector3(0, btScalar(-0.5 + 0.002 * i), 0));
		scene.step();
	}
	EXPECT_NEAR(heightOf(scene.body), 0.5 + 0.002 * 239, 0.02);
	scene.body.setCollisionFlags(scene.body.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
	scene.step(10);  // two kinematic bodies: nothing to do, nothing to break
}

TEST(Lifecycle, CallbacksOfBulletFireOnce)
{
	gStarted = gEnded = gDestroyed = 0;
	gContactStartedCallback = [](btPersistentManifold* const&) { ++gStarted; };
	gContactEndedCallback = [](btPersistentManifold* const&) { ++gEnded; };
	gContactDestroyedCallback = [](void*) { return ++gDestroyed > 0; };
	gContactAddedCallback =
		[](btManifoldPoint& point, const btCollisionObjectWrapper*, int, int, const btCollisionObjectWrapper*, int, int)
	{
		if (!point.m_userPersistentData) point.m_userPersistentData = &gStarted;
		return false;
	};
	{
		CubeOnSlab scene;
		scene.body.setCollisionFlags(scene.body.getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
		scene.step(120);
		const int manifolds = scene.dispatcher.getNumManifolds();
		EXPECT_GT(gStarted, 0);
		EXPECT_LE(gStarted, manifolds + gEnded);
		scene.body.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 2, 0)));
		scene.step(1);
		EXPECT_EQ(gEnded, gStarted);
		EXPECT_GT(gDestroyed, 0);
	}
	gContactStartedCallback = nullptr;
	gContactEndedCallback = nullptr;
	gContactDestroyedCallback = nullptr;
	gContactAddedCallback = nullptr;
}

// What gContactAddedCallback has put at a point it finds there in the next step, as at Bullet's own points, and each is
// handed back once.
TEST(Lifecycle, DataThatACallbackPutsAtPointsStayThere)
{
	static std::set<void*> alive;
	static int made = 0, known = 0;
	const SetCallback<ContactDestroyedCallback> handBack(gContactDestroyedCallback, [](void* data)
														 { return alive.erase(data) > 0 && (delete static_cast<int*>(data), true); });
	const SetCallback<ContactAddedCallback> put(
		gContactAddedCallback,
		[](btManifoldPoint& point, const btCollisionObjectWrapper*, int, int, const btCollisionObjectWrapper*, int, int)
		{
			known += point.m_userPersistentData != nullptr;
			if (!point.m_userPersistentData) alive.insert(point.m_userPersistentData = new int(++made));
			return true;
		});
	for (const int flag : {0, int(btCollisionObject::CF_HAS_FRICTION_ANCHOR)})
	{
		CubeOnSlab scene;
		scene.body.setCollisionFlags(scene.body.getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK | flag);
		scene.body.setLinearVelocity(btVector3(1, 0, btScalar(0.3)));
		scene.step(60);
		EXPECT_EQ(alive.size(), std::size_t(scene.contacts()));
		scene.world.removeRigidBody(&scene.body);
		EXPECT_TRUE(alive.empty());
	}
	EXPECT_GT(known, 10 * made);
}

TEST(Lifecycle, TwoRunsGiveTheSameBitsInEitherOrderOfCreation)
{
	std::uint64_t hashes[3] = {};
	for (int run = 0; run < 3; ++run)
	{
		BulletWorld scene;
		btClodShape& ground = scene.addShape(slab());
		btClodShape& shape = scene.addShape(cube());
		btRigidBody* first = run < 2 ? &scene.addBody(ground, 0, {0, -0.5, 0}) : nullptr;
		btRigidBody& body =
			scene.addBody(shape, 1, {0.013, 1.2, 0.027}, btQuaternion(btVector3(1, 2, 3).normalized(), 1));
		if (!first) scene.addBody(ground, 0, {0, -0.5, 0});
		for (int i = 0; i < 300; ++i)
		{
			scene.step();
			hashes[run] = poseHash(body, hashes[run]);
		}
		EXPECT_LT(heightOf(body), 1);
	}
	EXPECT_EQ(hashes[0], hashes[1]);
	EXPECT_EQ(hashes[0], hashes[2]);
}

TEST(Lifecycle, WhatIsNotFiniteIsSaidAndHasNoContacts)
{
	const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
	const btScalar infinity = std::numeric_limits<btScalar>::infinity();
	struct Case
	{
		const char* what;
		std::function<void(btRigidBody&)> make, mend;
	};
	const Case cases[] = {{"velocity", [&](btRigidBody& b) { b.setAngularVelocity(btVector3(nan, 0, 0)); },
						   [](btRigidBody& b) { b.setAngularVelocity(btVector3(0, 0, 0)); }},
						  {"velocity", [&](btRigidBody& b) { b.setLinearVelocity(btVector3(0, infinity, 0)); },
						   [](btRigidBody& b) { b.setLinearVelocity(btVector3(0, 0, 0)); }},
						  {"force", [&](btRigidBody& b) { b.applyCentralForce(btVector3(0, 0, nan)); },
						   [](btRigidBody& b) { b.clearForces(); }},
						  {"pose", [&](btRigidBody& b) { b.getWorldTransform().getOrigin().setX(nan); },
						   [](btRigidBody& b) { b.getWorldTransform().getOrigin().setX(0); }},
						  {"pose", [&](btRigidBody& b) { b.getWorldTransform().setOrigin(btVector3(nan, nan, nan)); },
						   [](btRigidBody& b) { b.getWorldTransform().setOrigin(btVector3(0, btScalar(0.4995), 0)); }},
						  {"pose", [&](btRigidBody& b) { b.getWorldTransform().getBasis()[0][0] = nan; },
						   [](btRigidBody& b) { b.getWorldTransform().getBasis().setIdentity(); }}};
	for (const Case& each : cases)
	{
		CubeOnSlab scene;
		scene.body.setUserIndex(7);
		scene.world.getDispatchInfo().m_timeStep = btScalar(scene.timeStep);
		scene.body.getWorldTransform().setOrigin(btVector3(0, btScalar(0.4995), 0));
		scene.world.performDiscreteCollisionDetection();
		const StepReport before = scene.context.lastStep();
		EXPECT_GT(before.points, 0u);
		for (int again = 0; again < 2; ++again)
		{
			each.make(scene.body);
			scene.world.performDiscreteCollisionDetection();
			const StepReport sums = scene.context.lastStep();
			EXPECT_EQ(scene.contacts(), 0) << each.what;
			EXPECT_EQ(sums.pairs, 1u);
			EXPECT_EQ(sums.points + sums.candidates + sums.clusters + sums.nodePairs + sums.hullTests, 0u) << each.what;
			ASSERT_EQ(sums.warnings().size(), 1u) << each.what;
			for (const std::string& text : {sums.warnings()[0], scene.warnings.at(0)})
			{
				EXPECT_NE(text.find(each.what), std::string::npos) << text;
				EXPECT_NE(text.find("world index 1 (user index 7)"), std::string::npos) << text;
			}
		}
		EXPECT_EQ(scene.warnings.size(), 1u);  // said once
		each.mend(scene.body);
		scene.world.performDiscreteCollisionDetection();
		EXPECT_EQ(scene.context.lastStep().points, before.points) << each.what;
		EXPECT_TRUE(scene.context.lastStep().warnings().empty()) << each.what;
	}
}
}  // namespace clod::test
