// SPDX-License-Identifier: GPL-3.0-or-later
// Overlapping starts, hard pressing, fast falls: bodies leave on the side they came in, and nothing is silent.
#include <gtest/gtest.h>

#include <cmath>

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
}  // namespace clod::test
