// SPDX-License-Identifier: GPL-3.0-or-later
// What happens to pairs and manifolds as worlds change under them, and the context's view of it.
#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>

#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"

namespace clod::test
{
namespace
{
std::shared_ptr<const Hierarchy> cube()
{
	return patchHierarchy(boxMesh({1, 1, 1}, {2, 2, 2}, 1));
}
std::shared_ptr<const Hierarchy> slab()
{
	return patchHierarchy(boxMesh({10, 1, 10}, {20, 1, 20}, 2));
}

struct Resting : BulletWorld
{
	btClodShape& groundShape = addShape(slab());
	btClodShape& bodyShape = addShape(cube());
	btRigidBody& ground = addBody(groundShape, 0, {0, -0.5, 0});
	btRigidBody& body = addBody(bodyShape, 1, {0.013, 0.501, 0.027});
};

std::uint64_t poseHash(const btRigidBody& body, std::uint64_t hash)
{
	const btTransform& pose = body.getWorldTransform();
	for (int i = 0; i < 3; ++i)
		for (const btScalar value : {pose.getOrigin()[i], pose.getBasis()[i][0], pose.getBasis()[i][1]})
		{
			const double exact = double(value);
			std::uint64_t bits = 0;
			std::memcpy(&bits, &exact, sizeof bits);
			hash = (hash ^ bits) * 0x100000001B3u;
		}
	return hash;
}

int gEnded = 0, gStarted = 0, gDestroyed = 0;
}  // namespace

TEST(Lifecycle, RemovalLeavesNoManifold)
{
	Resting scene;
	scene.step(10);
	EXPECT_GT(scene.dispatcher.getNumManifolds(), 0);
	EXPECT_EQ(scene.context.lastStep().pairs, 1u);
	scene.world.removeRigidBody(&scene.body);
	EXPECT_EQ(scene.dispatcher.getNumManifolds(), 0);
	EXPECT_EQ(scene.context.lastStep().pairs, 0u);
}

TEST(Lifecycle, PointsPersistAndKeepTheirImpulses)
{
	Resting scene;
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
	EXPECT_NEAR(impulse, 9.81 / 240, 0.1 * 9.81 / 240);
	EXPECT_GT(oldest, 100);
}

namespace
{
// Where a world's manifold points are, and their friction, in Bullet's order.
std::vector<double> pointsOf(const BulletWorld& scene)
{
	std::vector<double> values;
	for (int i = 0; i < scene.dispatcher.getNumManifolds(); ++i)
	{
		const btPersistentManifold& manifold =
			*const_cast<btCollisionDispatcher&>(scene.dispatcher).getManifoldByIndexInternal(i);
		for (int k = 0; k < manifold.getNumContacts(); ++k)
		{
			const btManifoldPoint& p = manifold.getContactPoint(k);
			for (const btVector3& v : {p.m_localPointA, p.m_localPointB, p.m_positionWorldOnB, p.m_normalWorldOnB})
				values.insert(values.end(), {double(v.x()), double(v.y()), double(v.z())});
			values.insert(values.end(), {double(p.m_distance1), double(p.m_combinedFriction)});
		}
	}
	return values;
}

double queryTime(const BulletWorld& scene)
{
	double time = 0;
	scene.context.forEachPair([&](const PairReport& report) { time = report.queryMicroseconds; });
	return time;
}
}  // namespace

TEST(Lifecycle, APairIsAskedAnewOnlyWhenItsQuestionChanges)
{
	Resting scene;
	scene.world.getDispatchInfo().m_timeStep = btScalar(scene.timeStep);
	btClodShape& otherShape = scene.addShape(cube());
	const std::pair<const char*, std::function<void()>> changes[] = {
		{"moved", [&] { scene.body.getWorldTransform().getOrigin().setX(btScalar(0.0625)); }},
		{"speed", [&] { scene.body.setLinearVelocity(btVector3(0, 0, btScalar(0.3))); }},
		{"force", [&] { scene.body.applyCentralForce(btVector3(0, 0, btScalar(5))); }},
		{"margin", [&] { scene.bodyShape.setMargin(btScalar(0.004)); }},
		{"metric", [&] { scene.context.worldMetric = ContactMetric::exactly(); }},
		{"shape", [&] { scene.body.setCollisionShape(&otherShape); }},
		{"both moved by as much", [&]
		 {
			 for (btRigidBody* body : {&scene.ground, &scene.body})
				 body->getWorldTransform().getOrigin() += btVector3(btScalar(0.0625), 0, 0);
		 }}};
	scene.world.performDiscreteCollisionDetection();
	for (const auto& [name, change] : changes)
	{
		change();
		scene.world.performDiscreteCollisionDetection();
		EXPECT_EQ(queryTime(scene) == 0, std::string("both moved by as much") == name) << name;
		const std::vector<double> points = pointsOf(scene);
		ASSERT_FALSE(points.empty()) << name;
		for (int again = 0; again < 3; ++again)
		{
			scene.world.performDiscreteCollisionDetection();
			EXPECT_EQ(queryTime(scene), 0) << name;
			EXPECT_EQ(pointsOf(scene), points) << name;
		}
	}
	// Impulses stay with their points.
	const auto point = [&](int k) -> btManifoldPoint&
	{ return scene.dispatcher.getManifoldByIndexInternal(k / 4)->getContactPoint(k % 4); };
	for (int k = 0; k < 2; ++k) point(k).m_appliedImpulse = btScalar(3 + k);
	scene.world.performDiscreteCollisionDetection();
	for (int k = 0; k < 2; ++k) EXPECT_EQ(point(k).m_appliedImpulse, btScalar(3 + k));
	// What is Bullet's stays Bullet's: a point's friction is that of now.
	const std::vector<double> rough = pointsOf(scene);
	scene.body.setFriction(btScalar(0.1));
	scene.world.performDiscreteCollisionDetection();
	EXPECT_EQ(queryTime(scene), 0);
	EXPECT_NE(pointsOf(scene), rough);
}

TEST(Lifecycle, SetCollisionShapeAtRunTimeIsNoticed)
{
	Resting scene;
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

TEST(Lifecycle, ARestingPairSleepsAndWakes)
{
	Resting scene;
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
	Resting scene;
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
		Resting scene;
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
}

TEST(Lifecycle, ANotFinitePoseIsIgnored)
{
	Resting scene;
	scene.step(10);
	const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
	btCollisionObject& lost = scene.body;
	lost.getWorldTransform().setOrigin(btVector3(nan, nan, nan));
	btManifoldResult result;
	scene.world.performDiscreteCollisionDetection();
	SUCCEED();
}

TEST(Context, PairCallbackThenShapesThenWorld)
{
	Resting scene;
	Metric used;
	const auto look = [&]
	{
		scene.step();
		scene.context.forEachPair([&](const PairReport& pair) { used = pair.metric; });
		return used;
	};
	const double radius = double(scene.bodyShape.hierarchy().asset().radius);
	EXPECT_NEAR(look().maxError, 0.005 * radius, 1e-12);  // the default, of the smaller radius
	scene.context.worldMetric = ContactMetric::deviationShare(0.035);
	EXPECT_NEAR(look().weightedDeviation, 0.035 * radius, 1e-12);
	scene.groundShape.setMetric(ContactMetric::errorShare(0.02));
	EXPECT_NEAR(look().maxError, 0.02 * radius, 1e-12);
	scene.bodyShape.setMetric(ContactMetric::errorShare(0.01));
	EXPECT_NEAR(look().maxError, 0.01 * radius, 1e-12);  // the stricter of the two
	scene.context.pairMetric = [](const btCollisionObject&, const btCollisionObject&, ContactMetric& metric)
	{
		metric = ContactMetric::exactly();
		return true;
	};
	EXPECT_TRUE(look().exact);
	scene.context.pairMetric = [](const btCollisionObject&, const btCollisionObject&, ContactMetric&) { return false; };
	EXPECT_FALSE(look().exact);
}

TEST(Context, AStepFasterThanTheWallIsSaidOnce)
{
	BulletWorld scene;
	scene.addBody(scene.addShape(patchHierarchy(boxMesh({10, 0.05, 10}, {20, 1, 20}, 2))), 0, {});
	btRigidBody& body = scene.addBody(scene.addShape(cube()), 1, {0, 0.6, 0});
	body.setLinearVelocity(btVector3(0, -20, 0));
	scene.step(1);
	EXPECT_EQ(scene.context.lastStep().fastPairs, 1u);
	EXPECT_EQ(scene.warnings.size(), 1u);
	EXPECT_FALSE(scene.context.lastStep().warnings.empty());
	scene.step(1);
	EXPECT_EQ(scene.warnings.size(), 1u);
}
}  // namespace clod::test
