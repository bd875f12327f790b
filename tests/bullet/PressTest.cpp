// SPDX-License-Identifier: GPL-3.0-or-later
// Overlapping starts, hard pressing, fast falls: bodies leave on the side they came in, and nothing is silent.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "clod/bullet/ConfigureWorld.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"

namespace clod::test
{
namespace
{
std::shared_ptr<const Hierarchy> sheet(double thickness)
{
	return patchHierarchy(boxMesh({20, thickness, 20}, {20, 1, 20}, 2));
}
// Of a convex body.
PatchedMesh onePiece(PatchedMesh mesh)
{
	mesh.patch.assign(mesh.triangles.size(), 0);
	return mesh;
}
btRigidBody& addBox(BulletWorld& scene, const Vec3& size, double mass, double height)
{
	return scene.addBody(scene.addShape(patchHierarchy(onePiece(boxMesh(size, {1, 1, 1}, 1)))), mass, {0, height, 0});
}
struct Distances : btCollisionWorld::ContactResultCallback
{
	std::vector<double> distances;
	btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
							 const btCollisionObjectWrapper*, int, int) override
	{
		distances.push_back(double(point.getDistance()));
		return 0;
	}
};
bool finite(const btRigidBody& body)
{
	return std::isfinite(double(body.getWorldTransform().getOrigin().length2())) &&
		   std::isfinite(double(body.getLinearVelocity().length2()));
}
}  // namespace

TEST(Press, AnOverlappingBoxLeavesOnTheSideItCameIn)
{
	for (const double thickness : {0.05, 0.2, 2.0})
		for (const double side : {1.0, -1.0})
		{
			BulletWorld scene;
			scene.world.setGravity(btVector3(0, 0, 0));
			scene.world.getSolverInfo().m_splitImpulsePenetrationThreshold = 0;
			scene.addBody(scene.addShape(sheet(thickness)), 0, {});
			const double depth = 0.25 * std::min(thickness, 1.0);
			const PatchedMesh box = boxMesh({2, 1, 2}, {4, 2, 4}, 2);
			const btRigidBody& body =
				scene.addBody(scene.addShape(patchHierarchy(box)), 1, {0.1, side * (0.5 + thickness / 2 - depth), 0.2});
			scene.step(480);
			EXPECT_GT(side * heightOf(body), 0.5 + thickness / 2 - 0.01 - 0.1 * depth) << thickness << " " << side;
			EXPECT_LT(double(body.getLinearVelocity().length()), 0.1);
			EXPECT_EQ(scene.context.lastStep().deepPairs, 0u);
		}
}

// Overlaps are left by positions. What weight a heap has is lifted so; speed it gains none.
TEST(Press, AHeapOfOverlapsGainsNoSpeed)
{
	BulletWorld scene;
	configureWorld(scene.world);
	scene.world.setGravity(btVector3(0, 0, 0));
	std::vector<const btRigidBody*> bodies;
	for (int i = 0; i < 8; ++i)
		bodies.push_back(&scene.addBody(scene.addShape(patchHierarchy(boxMesh({2, 1, 1}, {4, 2, 2}, 2))), 1,
										{0.7 * (i % 2), 0.6 * (i / 2 % 2), 0.5 * (i / 4)},
										btQuaternion(btVector3(1, btScalar(i), 2).normalized(), btScalar(0.9 * i))));
	const btVector3 start = bodies.front()->getWorldTransform().getOrigin();
	double deepest = 0;
	for (int i = 0; i < 240; ++i)
	{
		scene.step();
		for (const btRigidBody* body : bodies)
		{
			ASSERT_LT(double(body->getLinearVelocity().length()), 1e-4) << i;
			ASSERT_LT(double(body->getAngularVelocity().length()), 1e-4) << i;
		}
		deepest = 0;
		scene.context.forEachPair(
			[&](const PairReport& pair)
			{
				for (const HeldPoint& held : pair.clusters->points()) deepest = std::max(deepest, -held.point.height);
			});
	}
	EXPECT_LT(deepest, 0.005);
	EXPECT_GT(double((bodies.front()->getWorldTransform().getOrigin() - start).length()), 0.2);
}

TEST(Press, TenTimesItsWeightSinksNoDeeperThanAHundredth)
{
	BulletWorld scene;
	scene.addBody(scene.addShape(sheet(1)), 0, {0, -0.5, 0});
	const PatchedMesh box = boxMesh({2, 1, 2}, {4, 2, 4}, 2);
	btRigidBody& body = scene.addBody(scene.addShape(patchHierarchy(box)), 1, {0.1, 0.5, 0.2});
	double lowest = 1;
	for (int i = 0; i < 240; ++i)
	{
		body.applyCentralForce(btVector3(0, btScalar(-9 * 9.81), 0));
		scene.step();
		lowest = std::min(lowest, heightOf(body));
	}
	EXPECT_GT(lowest, 0.49);
	EXPECT_LT(heightOf(body), 0.51);
}

TEST(Press, FallingBodiesAreCaughtByAThinSheet)
{
	for (const double speed : {1.0, 3.0, 10.0})
		for (const bool ball : {true, false})
		{
			BulletWorld scene;
			scene.addBody(scene.addShape(sheet(0.05)), 0, {0, -0.025, 0});
			const PatchedMesh mesh = ball ? ballMesh(0.5, 3) : boxMesh({1, 1, 1}, {2, 2, 2}, 1);
			btRigidBody& body = scene.addBody(scene.addShape(patchHierarchy(mesh)), 1, {0.1, 0.7, 0.2});
			body.setLinearVelocity(btVector3(0, btScalar(-speed), 0));
			double lowest = 1;
			for (int i = 0; i < 240; ++i)
			{
				scene.step();
				lowest = std::min(lowest, heightOf(body));
				ASSERT_TRUE(finite(body));
			}
			EXPECT_GT(lowest, 0.49) << speed << (ball ? " ball" : " box");
		}
}

TEST(Press, OverlapThatNoContactAnswersIsReportedDeep)
{
	BulletWorld scene;
	scene.world.setGravity(btVector3(0, 0, 0));
	scene.addBody(scene.addShape(patchHierarchy(boxMesh({10, 10, 10}, {10, 10, 10}, 2))), 0, {});
	scene.addBody(scene.addShape(patchHierarchy(boxMesh({1, 1, 1}, {1, 1, 1}, 1))), 1, {0.1, 0.2, 0.3});
	scene.step(1);
	EXPECT_EQ(scene.context.lastStep().deepPairs, 1u);
	EXPECT_EQ(scene.warnings.size(), 1u);
}

// Of a body of one piece only what is near the other is looked at. That must not hide corners deep inside, beside
// shallow ones that tell of an overlap.
TEST(Press, DeepCornersAreToldOfBesideShallowOnes)
{
	for (const double lean : {0.003, 0.01, 0.03, 0.1})
	{
		BulletWorld scene;
		const double shallow = 0.0005, deep = shallow + 2 * std::sin(lean);
		const PatchedMesh floor = onePiece(boxMesh({20, 2, 20}, {1, 1, 1}, 1)), box = onePiece(boxMesh({2, 1, 2}, {1, 1, 1}, 1));
		btRigidBody& ground = scene.addBody(scene.addShape(patchHierarchy(floor)), 0, {0, -1, 0});
		btRigidBody& body = scene.addBody(scene.addShape(patchHierarchy(box)), 1,
										  {0.1, 0.5 * std::cos(lean) - std::sin(lean) - shallow, 0.2},
										  btQuaternion(btVector3(0, 0, 1), btScalar(lean)));
		Distances found;
		scene.world.contactPairTest(&body, &ground, found);
		ASSERT_FALSE(found.distances.empty()) << lean;
		EXPECT_NEAR(*std::min_element(found.distances.begin(), found.distances.end()), -deep, 1e-5) << lean;
	}
}

// A press that nothing stops comes down on a box on a floor: the box yields to the press, not to the floor.
TEST(Press, NothingIsPressedThroughAFloor)
{
	for (const bool meetsImpacts : {false, true})
		for (const double rate : {60.0, 240.0})
		{
			BulletWorld scene(meetsImpacts);
			scene.timeStep = 1 / rate;
			configureWorld(scene.world);
			addBox(scene, {10, 1, 10}, 0, -0.5);
			const btRigidBody& body = addBox(scene, {1, 0.4, 0.6}, 1, 0.201);
			btRigidBody& press = addBox(scene, {3, 0.4, 3}, 0, 0.7);
			press.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
			double lowest = 1;
			for (double time = 0; time < 2.5; time += scene.timeStep)
			{
				btTransform pose = btTransform::getIdentity();
				pose.setOrigin(btVector3(0, btScalar(std::max(0.22, 0.7 - 0.3 * time)), 0));
				press.setWorldTransform(pose);
				scene.step();
				lowest = std::min(lowest, heightOf(body));
			}
			EXPECT_GT(lowest, 0.17) << rate << (meetsImpacts ? " in passes" : "");
		}
}

// One that a force drives stalls on the box.
TEST(Press, APressOfLimitedForceStalls)
{
	for (const double rate : {60.0, 240.0})
		for (const double force : {10.0, 100.0, 1000.0})  // of a box of 9.8 N
		{
			BulletWorld scene;
			scene.timeStep = 1 / rate;
			configureWorld(scene.world);
			addBox(scene, {10, 1, 10}, 0, -0.5);
			const btRigidBody& body = addBox(scene, {1, 1, 1}, 1, 0.501);
			btRigidBody& press = addBox(scene, {3, 0.4, 3}, 10, 1.5);
			for (int i = 0; i < int(3 * rate); ++i)
			{
				press.applyCentralForce(btVector3(0, btScalar(-force), 0));
				scene.step();
			}
			EXPECT_NEAR(heightOf(body), 0.5, 2e-3) << rate << " " << force;
			EXPECT_NEAR(heightOf(press), 1.2, 4e-3) << rate << " " << force;
		}
}

// Nothing holds the body: it is carried along by a kinematic one that started deep in it, and comes out of it.
TEST(Press, ABodyDeepInAKinematicOneIsStillPushedOn)
{
	BulletWorld scene;
	scene.world.setGravity(btVector3(0, 0, 0));
	configureWorld(scene.world);
	const PatchedMesh mesh = onePiece(boxMesh({1, 1, 1}, {1, 1, 1}, 1));
	const btRigidBody& body = scene.addBody(scene.addShape(patchHierarchy(mesh)), 1, {0.8, 0, 0});
	btRigidBody& pusher = scene.addBody(scene.addShape(patchHierarchy(mesh)), 0, {});
	pusher.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
	for (int i = 1; i <= 240; ++i)
	{
		btTransform pose = btTransform::getIdentity();
		pose.setOrigin(btVector3(btScalar(2 * i * scene.timeStep), 0, 0));
		pusher.setWorldTransform(pose);
		scene.step();
	}
	EXPECT_GT(double(body.getWorldTransform().getOrigin().x()), 2.99);
	EXPECT_NEAR(double(body.getLinearVelocity().x()), 2, 0.02);
}

// A platform that moves by itself is a floor for what lies on it, however heavy, standing or starting to rise.
TEST(Press, AKinematicPlatformBearsWhatIsHeavy)
{
	for (const double lift : {0.0, 1.0})
	{
		BulletWorld scene;
		scene.timeStep = 1.0 / 60;
		configureWorld(scene.world);
		btRigidBody& platform = scene.addBody(scene.addShape(patchHierarchy(onePiece(boxMesh({6, 1, 6}, {1, 1, 1}, 1)))), 0, {});
		platform.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
		btClodShape& crate = scene.addShape(patchHierarchy(onePiece(boxMesh({1, 1, 1}, {1, 1, 1}, 1))));
		const btRigidBody& light = scene.addBody(crate, 1, {0, 1, 0});
		scene.addBody(crate, 100, {0, 2, 0});
		for (int i = 1; i <= 120; ++i)
		{
			btTransform pose = btTransform::getIdentity();
			pose.setOrigin(btVector3(0, btScalar(lift * i * scene.timeStep), 0));
			platform.setWorldTransform(pose);
			scene.step();
			const double over = double(light.getWorldTransform().getOrigin().y() - platform.getWorldTransform().getOrigin().y());
			ASSERT_GT(over, 0.95) << lift << " " << i;
		}
	}
}

// Points that follow the bodies are those that they come to bounce on.
TEST(Bounce, BodiesThatComeSlowlyBounceToo)
{
	for (const bool keeps : {false, true})
	{
		BulletWorld scene;
		configureWorld(scene.world);
		scene.world.setGravity(btVector3(0, 0, 0));
		scene.context.keepPoints = keeps;
		scene.timeStep = 1e-3;
		btClodShape& shape = scene.addShape(patchHierarchy(boxMesh({2, 2, 2}, {1, 1, 1}, 1)));
		scene.addBody(shape, 0, {}).setRestitution(1);
		btRigidBody& moving = scene.addBody(shape, 1, {0, 2.01, 0});
		moving.setRestitution(1);
		moving.setLinearVelocity(btVector3(0, btScalar(-0.25), 0));
		for (int i = 0; i < 100; ++i) scene.step();
		EXPECT_NEAR(double(moving.getLinearVelocity().y()), 0.25, 0.01) << keeps;
	}
}

// The edge of a slab: a triangle that touches the sharp edge with a corner must not be pushed sideways.
TEST(Press, ABoxOverASharpEdgeIsNotStopped)
{
	BulletWorld scene;
	scene.world.setGravity(btVector3(0, btScalar(-981), 0));
	scene.addBody(scene.addShape(patchHierarchy(boxMesh({80, 20, 20}, {85, 1, 8}, 1))), 0, {0, -10, 0}).setFriction(0);
	btRigidBody& body =
		scene.addBody(scene.addShape(patchHierarchy(boxMesh({4, 2, 3}, {1, 1, 1}, 1))), 1, {-35, 0.984, 9.2});
	body.setFriction(0);
	body.setLinearVelocity(btVector3(50, 0, 0));
	for (int i = 0; i < 240; ++i) scene.step();
	EXPECT_NEAR(double(body.getLinearVelocity().x()), 50, 0.1);
	EXPECT_GT(heightOf(body), 0.9);
	EXPECT_LT(double(body.getAngularVelocity().length()), 0.1);
}

// A program may have contacts give way as springs do: a ball then sinks in by its weight over the stiffness, as it does
// between Bullet's own shapes where impulses are not split.
TEST(Press, ContactsGiveWayAsSpringsWhereAskedTo)
{
	for (const bool isOurs : {false, true})
		for (const bool isSplit : {false, true})
			for (const double stiffness : {100.0, 400.0})
			{
				if (isSplit && !isOurs) continue;
				BulletWorld scene;
				configureWorld(scene.world);
				scene.world.getSolverInfo().m_splitImpulse = isSplit;
				auto box = std::make_unique<btBoxShape>(btVector3(5, btScalar(0.5), 5));
				btCollisionShape& bullets = scene.add(std::move(box));
				scene.addBody(isOurs ? scene.addShape(slab()) : bullets, 0, {0, -0.5, 0});
				btRigidBody& ball = scene.addBody(scene.add(std::make_unique<btSphereShape>(btScalar(0.5))), 1, {0, 0.5, 0});
				ball.setContactStiffnessAndDamping(btScalar(stiffness), btScalar(2 * std::sqrt(stiffness)));
				scene.step(960);
				const double expected = 9.81 / stiffness;
				EXPECT_NEAR(0.5 - heightOf(ball), expected, 0.02 * expected) << isOurs << isSplit << " " << stiffness;
				EXPECT_LT(double(ball.getLinearVelocity().length()), 1e-3) << isOurs << isSplit;
			}
}
}  // namespace clod::test
