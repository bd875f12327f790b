// SPDX-License-Identifier: GPL-3.0-or-later
// What Bullet offers besides bodies that touch: each facility does with a shape of ours what it does with the shape that a
// user would have taken otherwise.
#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <BulletDynamics/Character/btKinematicCharacterController.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/Vehicle/btRaycastVehicle.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
btVector3 vector(double x, double y, double z)
{
	return btVector3(btScalar(x), btScalar(y), btScalar(z));
}
btTransform at(double x, double y, double z)
{
	return btTransform(btQuaternion::getIdentity(), vector(x, y, z));
}
btTransform randomPose(Random& random, double far)
{
	const Mat3 turn = randomRotation(random);
	btMatrix3x3 basis;
	for (int i = 0; i < 3; ++i) basis[i] = toBullet(turn.row[i]);
	return btTransform(basis, toBullet(randomVector(random, 0, far)));
}

std::shared_ptr<const Hierarchy> landscape()
{
	return patchHierarchy(boxMesh({20, 1, 20}, {20, 1, 20}, 2));
}

struct Touches : btCollisionWorld::ContactResultCallback
{
	int points = 0;
	double deepest = std::numeric_limits<double>::infinity();
	btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
							 const btCollisionObjectWrapper*, int, int) override
	{
		++points;
		deepest = std::min(deepest, double(point.getDistance()));
		return 0;
	}
};
}  // namespace

TEST(Facilities, AGhostMeetsAndHoldsNothing)
{
	BulletWorld scene;
	btGhostPairCallback callback;
	scene.broadphase.getOverlappingPairCache()->setInternalGhostPairCallback(&callback);
	btPairCachingGhostObject ghost;
	ghost.setCollisionShape(&scene.addShape(slab()));
	ghost.setCollisionFlags(ghost.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
	scene.world.addCollisionObject(&ghost, btBroadphaseProxy::SensorTrigger, btBroadphaseProxy::AllFilter);
	auto& box = scene.add(std::make_unique<btBoxShape>(vector(0.5, 0.5, 0.5)));
	const btRigidBody& body = scene.addBody(box, 1, {0, 1.2, 0});
	int touched = 0;
	for (int i = 0; i < 240; ++i)
	{
		scene.step();
		touched += ghost.getNumOverlappingObjects() > 0 && scene.contacts() > 0 ? 1 : 0;
	}
	EXPECT_GT(touched, 10);
	EXPECT_LT(heightOf(body), -2);
	scene.world.removeCollisionObject(&ghost);
}

// A depth is the way out as the bodies lie, not all the way that the ghost has come.
TEST(Facilities, AGhostThatSweepsThroughABodyIsNoDeeperThanThat)
{
	BulletWorld scene;
	btClodShape& torus = scene.addShape(body("torus", 900).hierarchy);
	const double radius = double(torus.hierarchy().asset().radius), half = 0.4 * radius;
	btCollisionObject ghost;
	ghost.setCollisionShape(&torus);
	ghost.setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
	scene.world.addCollisionObject(&ghost, btBroadphaseProxy::SensorTrigger, btBroadphaseProxy::AllFilter);
	btClodShape& cube = scene.addShape(body("box", 12).hierarchy);
	cube.setLocalScaling(vector(1, 1, 1) * btScalar(half * std::sqrt(3) / double(cube.hierarchy().asset().radius)));
	scene.world.setGravity(vector(0, 0, 0));
	scene.addBody(cube, 1, {0, 0, 0});
	double deepest = 0;
	for (double x = -2 * radius; x < 2 * radius; x += 0.1 * radius)
	{
		ghost.setWorldTransform(at(x, 0.2 * radius, 0));
		scene.step();
		for (int i = 0; i < scene.dispatcher.getNumManifolds(); ++i)
		{
			const btPersistentManifold& manifold = *scene.dispatcher.getManifoldByIndexInternal(i);
			for (int k = 0; k < manifold.getNumContacts(); ++k)
				deepest = std::min(deepest, double(manifold.getContactPoint(k).getDistance()));
		}
	}
	EXPECT_TRUE(deepest < -0.2 * radius && deepest > -(std::sqrt(3) * half + 0.1 * radius)) << deepest / radius;
	scene.world.removeCollisionObject(&ghost);
}

TEST(Facilities, AKinematicLiftCarriesConvexBodies)
{
	BulletWorld scene;
	btRigidBody& lift = scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	lift.setCollisionFlags(lift.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
	auto& box = scene.add(std::make_unique<btBoxShape>(vector(0.5, 0.5, 0.5)));
	const btRigidBody& body = scene.addBody(box, 1, {0, 0.5, 0});
	double lowest = 1;
	for (int i = 1; i <= 240; ++i)
	{
		lift.setWorldTransform(at(0, -0.5 + i / 240.0, 0));
		scene.step();
		if (i > 10) lowest = std::min(lowest, heightOf(body) - i / 240.0);
	}
	EXPECT_NEAR(heightOf(body), 1.5, 0.01);
	EXPECT_GT(lowest, 0.49);
}

// Ground of ours beside Bullet's own mesh.
TEST(Facilities, ACharacterWalksAsOnAMesh)
{
	const auto ground = landscape();
	Bvh bvh(*ground);
	double end[2][3];
	for (const bool ours : {true, false})
	{
		BulletWorld scene;
		btGhostPairCallback callback;
		scene.broadphase.getOverlappingPairCache()->setInternalGhostPairCallback(&callback);
		btCollisionShape& shape = ours ? static_cast<btCollisionShape&>(scene.addShape(ground)) : *bvh.shape;
		scene.addBody(shape, 0, {0, -0.5, 0});
		btCapsuleShape capsule(btScalar(0.3), btScalar(1));
		btPairCachingGhostObject ghost;
		ghost.setWorldTransform(at(0, 1.5, 0));
		ghost.setCollisionShape(&capsule);
		ghost.setCollisionFlags(btCollisionObject::CF_CHARACTER_OBJECT);
		btKinematicCharacterController character(&ghost, &capsule, btScalar(0.2), vector(0, 1, 0));
		scene.world.addCollisionObject(&ghost, btBroadphaseProxy::CharacterFilter,
									   btBroadphaseProxy::StaticFilter | btBroadphaseProxy::DefaultFilter);
		scene.world.addAction(&character);
		character.setWalkDirection(vector(0.01, 0, 0.004));
		scene.timeStep = 1.0 / 60;
		scene.step(240);
		for (int i = 0; i < 3; ++i) end[ours ? 0 : 1][i] = double(ghost.getWorldTransform().getOrigin()[i]);
		scene.world.removeAction(&character);
		scene.world.removeCollisionObject(&ghost);
	}
	for (int i = 0; i < 3; ++i) EXPECT_NEAR(end[0][i], end[1][i], 0.02) << i;
	EXPECT_GT(end[0][0], 2);
}

TEST(Facilities, AVehicleStandsAsOnAMesh)
{
	const auto ground = landscape();
	Bvh bvh(*ground);
	double height[2];
	for (const bool ours : {true, false})
	{
		BulletWorld scene;
		btCollisionShape& shape = ours ? static_cast<btCollisionShape&>(scene.addShape(ground)) : *bvh.shape;
		scene.addBody(shape, 0, {0, -0.5, 0});
		auto& box = scene.add(std::make_unique<btBoxShape>(vector(1, 0.3, 2)));
		btRigidBody& chassis = scene.addBody(box, 800, {0, 1, 0});
		btDefaultVehicleRaycaster caster(&scene.world);
		btRaycastVehicle::btVehicleTuning tuning;
		btRaycastVehicle vehicle(tuning, &chassis, &caster);
		vehicle.setCoordinateSystem(0, 1, 2);
		for (int i = 0; i < 4; ++i)
			vehicle.addWheel(vector((i & 1) != 0 ? 0.9 : -0.9, 0, (i & 2) != 0 ? 1.5 : -1.5), vector(0, -1, 0),
							 vector(-1, 0, 0), btScalar(0.5), btScalar(0.4), tuning, (i & 2) != 0);
		scene.world.addAction(&vehicle);
		scene.step(960);
		height[ours ? 0 : 1] = heightOf(chassis);
		scene.world.removeAction(&vehicle);
	}
	EXPECT_NEAR(height[0], height[1], 1e-3);
	EXPECT_GT(height[0], 0.4);
}

namespace
{
// A base and a link of ours, hinged, fall on a box. How low do they get?
double lowestOfLinks(double start, double speed, double gravity, int rate)
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btMultiBodyConstraintSolver solver;
	btMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	Context context;
	context.warn = {};
	if (!btClodCollisionAlgorithm::registerAlgorithm(&dispatcher, &context)) return 0;
	world.setGravity(vector(0, -gravity, 0));
	btClodShape shape(cube());
	btBoxShape floorShape(vector(10, 1, 10));
	btRigidBody ground(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &floorShape));
	ground.setWorldTransform(at(0, -1, 0));
	world.addRigidBody(&ground);
	btVector3 inertia;
	shape.calculateLocalInertia(1, inertia);
	btMultiBody body(1, 1, inertia, false, false);
	body.setupRevolute(0, 1, inertia, -1, btQuaternion::getIdentity(), vector(0, 0, 1), vector(0.6, 0, 0),
					   vector(0.6, 0, 0), true);
	body.finalizeMultiDof();
	body.setBasePos(vector(0, start, 0));
	body.setBaseVel(vector(0, -speed, 0));
	btMultiBodyLinkCollider base(&body, -1), link(&body, 0);
	for (btMultiBodyLinkCollider* collider : {&base, &link})
	{
		collider->setCollisionShape(&shape);
		collider->setActivationState(DISABLE_DEACTIVATION);
		world.addCollisionObject(collider, btBroadphaseProxy::DefaultFilter,
								 btBroadphaseProxy::StaticFilter | btBroadphaseProxy::DefaultFilter);
	}
	body.setBaseCollider(&base);
	body.getLink(0).m_collider = &link;
	world.addMultiBody(&body);
	btAlignedObjectArray<btQuaternion> rotations;
	btAlignedObjectArray<btVector3> origins;
	body.forwardKinematics(rotations, origins);
	body.updateCollisionObjectWorldTransforms(rotations, origins);
	double lowest = start;
	for (int i = 0; i < rate; ++i)
	{
		world.stepSimulation(btScalar(1.0 / rate), 0);
		for (const btMultiBodyLinkCollider* collider : {&base, &link})
			lowest = std::min(lowest, double(collider->getWorldTransform().getOrigin().y()));
	}
	world.removeMultiBody(&body);
	world.removeCollisionObject(&base);
	world.removeCollisionObject(&link);
	world.removeRigidBody(&ground);
	return lowest;
}
}  // namespace

// Where their speed is not seen they dip by what a step carries them, up to 80 mm, depending on where they start.
TEST(Facilities, LinksOfAMultiBodyAreSeenMoving)
{
	for (const int rate : {60, 120})
		for (int i = 0; i < 12; ++i)
		{
			const double lowest = lowestOfLinks(1.5 + 0.007 * i, 5, 9.81, rate);
			EXPECT_GT(lowest, 0.5) << i << " at " << rate;
			EXPECT_LT(lowest, 0.501) << i << " at " << rate;
		}
}

// At rest 3 cm over the ground: the coming step's forces alone would carry them 8 cm.
TEST(Facilities, ForcesOnLinksAreSeen)
{
	for (const double start : {0.53, 0.55, 0.57})
	{
		const double lowest = lowestOfLinks(start, 0, 300, 60);
		EXPECT_GT(lowest, 0.499) << start;
		EXPECT_LT(lowest, 0.501) << start;
	}
}

TEST(Facilities, CompoundsOfConvexShapesAndOfOursRest)
{
	for (const bool oursInside : {true, false})
	{
		BulletWorld scene;
		auto& compound = scene.add(std::make_unique<btCompoundShape>());
		auto& box = scene.add(std::make_unique<btBoxShape>(vector(0.5, 0.5, 0.5)));
		auto& plate = scene.add(std::make_unique<btBoxShape>(vector(5, 0.5, 5)));
		btCollisionShape& part = oursInside ? static_cast<btCollisionShape&>(scene.addShape(cube())) : box;
		btCollisionShape& ground = oursInside ? static_cast<btCollisionShape&>(plate) : scene.addShape(slab());
		compound.addChildShape(at(-0.7, 0, 0), &part);
		compound.addChildShape(at(0.7, 0, 0), &part);
		scene.addBody(ground, 0, {0, -0.5, 0});
		const btRigidBody& body = scene.addBody(compound, 1, {0, 0.55, 0});
		scene.step(480);
		EXPECT_NEAR(heightOf(body), 0.5, 2e-3) << oursInside;
		EXPECT_LT(double(body.getLinearVelocity().length()), 1e-3) << oursInside;
	}
}

// A child is added, made another or taken away while the compound lies on its others.
TEST(Facilities, EditsOfACompoundAreNoticed)
{
	BulletWorld scene;
	auto& compound = scene.add(std::make_unique<btCompoundShape>());
	btClodShape &part = scene.addShape(cube()), &larger = scene.addShape(cube());
	larger.setLocalScaling(vector(2, 2, 2));
	compound.addChildShape(at(-1.2, 0, 0), &part);
	compound.addChildShape(at(1.2, 0, 0), &part);
	scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	btRigidBody& body = scene.addBody(compound, 1, {0, 0.55, 0});
	body.setAngularFactor(0);
	scene.step(240);
	EXPECT_NEAR(heightOf(body), 0.5, 2e-3);
	compound.addChildShape(at(0, -0.5, 0), &part);
	scene.step(480);
	EXPECT_NEAR(heightOf(body), 1, 5e-3);
	compound.removeChildShapeByIndex(2);
	compound.addChildShape(at(0, -0.5, 0), &larger);
	scene.step(480);
	EXPECT_NEAR(heightOf(body), 1.5, 5e-3);
	compound.removeChildShape(&larger);
	scene.step(480);
	EXPECT_NEAR(heightOf(body), 0.5, 2e-3);
}

// Against Bullet's own mesh, and without a look at what the sweep does not pass.
TEST(Facilities, SweepsHitWhatTheyHitOfAMesh)
{
	Random random(17);
	const Body& torus = body("torus-900");
	const double scale = 1 / double(torus.hierarchy->asset().radius);
	Bvh bvh(*torus.hierarchy);
	btScaledBvhTriangleMeshShape theirs(bvh.shape.get(), vector(scale, scale, scale));
	int hits = 0;
	for (int round = 0; round < 200; ++round)
	{
		std::unique_ptr<btConvexShape> swept;
		if (round % 2 == 0)
			swept = std::make_unique<btSphereShape>(btScalar(0.1));
		else
			swept = std::make_unique<btBoxShape>(vector(0.2, 0.05, 0.1));
		btTransform from = randomPose(random, 0), to = randomPose(random, 0);
		from.setOrigin(toBullet(2.0 * randomDirection(random)));
		to.setOrigin(-from.getOrigin() + toBullet(0.7 * randomDirection(random)));
		if (round % 4 < 2) to.setBasis(from.getBasis());
		double fraction[2];
		for (const bool ours : {true, false})
		{
			BulletWorld scene;
			btClodShape& shape = scene.addShape(torus.hierarchy);
			shape.setLocalScaling(vector(scale, scale, scale));
			scene.addBody(ours ? static_cast<btCollisionShape&>(shape) : theirs, 0, {});
			scene.world.updateAabbs();
			btCollisionWorld::ClosestConvexResultCallback closest(from.getOrigin(), to.getOrigin());
			scene.world.convexSweepTest(swept.get(), from, to, closest);
			fraction[ours ? 0 : 1] = double(closest.m_closestHitFraction);
		}
		EXPECT_NEAR(fraction[0], fraction[1], 2e-4) << round;
		hits += fraction[0] < 1 ? 1 : 0;
	}
	EXPECT_GT(hits, 50);
	EXPECT_LT(hits, 200);
}

// Bullet sweeps convex bodies that are told to be swept, and leaves others alone.
TEST(Facilities, BulletsContinuousCollisionMayBeAsked)
{
	for (const bool isConvex : {true, false})
		for (const bool isAsked : {true, false})
		{
			BulletWorld scene;
			scene.timeStep = 1.0 / 60;
			btClodShape& plate = scene.addShape(slab());
			plate.setLocalScaling(vector(1, 0.02, 1));
			scene.addBody(plate, 0, {0, 0, 0});
			auto& ball = scene.add(std::make_unique<btSphereShape>(btScalar(0.1)));
			btClodShape& small = scene.addShape(cube());
			small.setLocalScaling(vector(0.2, 0.2, 0.2));
			btRigidBody& body =
				scene.addBody(isConvex ? static_cast<btCollisionShape&>(ball) : small, 1, {0.3, 4, 0.2});
			if (isAsked)
			{
				body.setCcdMotionThreshold(btScalar(0.05));
				body.setCcdSweptSphereRadius(btScalar(0.08));
			}
			body.setLinearVelocity(vector(0, -300, 0));
			scene.step(240);
			EXPECT_NEAR(heightOf(body), 0.11, 2e-3) << isConvex << isAsked;
		}
}

// A cube and a box in any overlap, one wholly inside the other, or a plate through a corner, too: contactPairTest has a point,
// and below zero. The oracle is the separating axes of boxes.
TEST(Facilities, ContactPairTestKnowsOverlapsOfAnyDepth)
{
	Random random(23);
	const auto ours = patchHierarchy(boxMesh({1, 1, 1}, {1, 1, 1}, 1));  // few corners, and none in between
	int overlapping = 0;
	for (int round = 0; round < 300; ++round)
	{
		const double size = round % 3 == 0 ? 0.3 : 1;
		const btVector3 extent = round % 3 == 1 ? vector(1.7, 0.02, 1.3) : vector(size, size, size);
		BulletWorld scene;
		btRigidBody& a = scene.addBody(scene.addShape(ours), 1, {});
		const bool isConvex = round % 2 == 0;
		btClodShape& second = scene.addShape(ours);
		second.setLocalScaling(extent);
		auto& box = scene.add(std::make_unique<btBoxShape>(btScalar(0.5) * extent));
		btRigidBody& b = scene.addBody(isConvex ? static_cast<btCollisionShape&>(box) : second, 1, {});
		const btTransform pose = randomPose(random, 1.3);
		b.setWorldTransform(pose);
		// The least overlap along the faces' normals and the edges' products.
		double least = std::numeric_limits<double>::infinity();
		std::vector<btVector3> axes;
		for (int i = 0; i < 3; ++i)
		{
			btVector3 e(0, 0, 0);
			e[i] = 1;
			axes.push_back(e);
			axes.push_back(pose.getBasis().getColumn(i));
			for (int j = 0; j < 3; ++j)
				if (e.cross(pose.getBasis().getColumn(j)).length() > btScalar(1e-3))
					axes.push_back(e.cross(pose.getBasis().getColumn(j)).normalized());
		}
		for (const btVector3& axis : axes)
		{
			double reach = 0.5 * double(axis.absolute().dot(vector(1, 1, 1)));
			for (int j = 0; j < 3; ++j)
				reach += 0.5 * double(extent[j]) * std::abs(double(axis.dot(pose.getBasis().getColumn(j))));
			least = std::min(least, reach - std::abs(double(axis.dot(pose.getOrigin()))));
		}
		if (std::abs(least) < 2e-3) continue;
		Touches touches;
		scene.world.contactPairTest(&a, &b, touches);
		const bool overlaps = touches.points > 0 && touches.deepest < 0;
		EXPECT_EQ(overlaps, least > 0) << round << " by " << least << ", extent " << extent.x() << ", " << extent.y() << (isConvex ? ", box" : "");
		overlapping += least > 0 ? 1 : 0;
	}
	EXPECT_GT(overlapping, 100);
}

// As a user may put them: some way into the ground, upright, a little aslant, half.
TEST(Facilities, ThinBodiesComeOutOfTheGroundTheyWereMadeIn)
{
	btTriangleMesh triangles;
	const btVector3 corners[] = {vector(-4, 0, -4), vector(-4, 0, 4), vector(4, 0, 4), vector(4, 0, -4)};
	triangles.addTriangle(corners[0], corners[1], corners[2]);
	triangles.addTriangle(corners[0], corners[2], corners[3]);
	for (const char* name : {"box-12", "torus-900", "cup-3000", "number8-600"})
		for (const double tilt : {0.0, 0.02})
			for (const double share : {0.05, 0.2, 0.5})
			{
				BulletWorld scene;
				scene.addBody(scene.add(std::make_unique<btBvhTriangleMeshShape>(&triangles, true)), 0, {});
				btClodShape& shape = scene.addShape(body(name).hierarchy);
				const double size = 0.5 / double(body(name).hierarchy->asset().radius);
				shape.setLocalScaling(vector(size, size, size));
				const btQuaternion turn(vector(1, 0.3, 0.2).normalized(), btScalar(tilt));
				btVector3 low, high;
				shape.getAabb(btTransform(turn), low, high);
				const double y = -double(low.y()) - share * double(high.y() - low.y());
				btRigidBody& made = scene.addBody(shape, 1, {0.03, y, 0.02}, turn);
				scene.step(480);
				EXPECT_GT(heightOf(made), 0.01) << name << ", tilt " << tilt << ", " << share << " of it deep";
			}
}

TEST(Facilities, DeepRoundBodiesAreKnownToOverlap)
{
	for (const double depth : {0.1, 0.3, 0.5})
	{
		BulletWorld scene;
		btRigidBody& a = scene.addBody(scene.addShape(cube()), 1, {});
		auto& ball = scene.add(std::make_unique<btSphereShape>(btScalar(0.1)));
		btRigidBody& b = scene.addBody(ball, 1, {0, 0.5 - depth, 0});
		Touches touches;
		scene.world.contactPairTest(&a, &b, touches);
		EXPECT_GT(touches.points, 0) << depth;
		EXPECT_LT(touches.deepest, 0) << depth;
	}
}

TEST(Facilities, ABodyAtRestFallsAsleepAndWakes)
{
	BulletWorld scene;
	scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	auto& box = scene.add(std::make_unique<btBoxShape>(vector(0.5, 0.5, 0.5)));
	btRigidBody& body = scene.addBody(box, 1, {0, 0.5, 0});
	body.forceActivationState(ACTIVE_TAG);
	scene.step(1200);
	EXPECT_FALSE(body.isActive());
	EXPECT_NEAR(heightOf(body), 0.5, 2e-3);
	body.activate();
	body.applyCentralImpulse(vector(0, 3, 0));
	scene.step(10);
	EXPECT_GT(heightOf(body), 0.51);
}
}  // namespace clod::test
