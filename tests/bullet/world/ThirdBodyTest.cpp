// SPDX-License-Identifier: GPL-3.0-or-later
// What a third body does to a pair within a step in which contacts are found once.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "tests/bullet/world/ImpactWorld.h"

namespace clod::test
{
namespace
{
enum class Ground
{
	kBody,
	kPlane,
	kMesh
};
// Its top at no height.
struct OnGround : ImpactWorld
{
	OnGround(double rate, Ground kind) : ImpactWorld(false, rate, 0), ground(make(kind)) {}
	btTriangleMesh triangles;
	btRigidBody& ground;

private:
	btRigidBody& make(Ground kind)
	{
		if (kind == Ground::kBody) return put(patchHierarchy(boxMesh({4, 0.5, 4}, {1, 1, 1}, 1)), 0, {0, -0.25, 0});
		if (kind == Ground::kPlane) return addBody(add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0))), 0, {});
		addGround(triangles, 2);
		return addBody(add(std::make_unique<btBvhTriangleMeshShape>(&triangles, true)), 0, {});
	}
};
}  // namespace

// A bar at rest just over the ground, one end a little higher: what falls onto that end turns it into the ground in the same step.
TEST(ThirdBody, WhatItThrowsIsMet)
{
	for (const Ground kind : {Ground::kBody, Ground::kPlane, Ground::kMesh})
		for (const double rate : {240, 60})
		{
			OnGround world(rate, kind);
			btRigidBody& bar = world.put(patchHierarchy(boxMesh({1, 0.1, 0.1}, {1, 1, 1}, 1)), 1, {0, 0.054, 0});
			bar.setWorldTransform(btTransform(btQuaternion(btVector3(0, 0, 1), btScalar(0.006)), bar.getWorldTransform().getOrigin()));
			btRigidBody& cube = world.put(patchHierarchy(boxMesh({0.2, 0.2, 0.2}, {1, 1, 1}, 1)), 1, {0.4, 0.21, 0});
			cube.setLinearVelocity(btVector3(0, -3, 0));
			for (int i = 0; i < 6; ++i)
			{
				world.step();
				double lowest = 0;
				for (const double x : {-0.5, 0.5})
					for (const double y : {-0.05, 0.05})
						lowest = std::min(lowest, double((bar.getWorldTransform() * btVector3(btScalar(x), btScalar(y), 0)).y()));
				EXPECT_GT(lowest, -1e-3) << int(kind) << " at " << rate << ", " << i;
			}
		}
}

// Newton's cradle: the last of a row leaves with the speed of the first, though the first reaches them all within one step.
TEST(ThirdBody, WhatItThrowsBouncesOff)
{
	for (const double rate : {1000, 240, 60})
	{
		ImpactWorld world(false, rate, 0);
		std::vector<btRigidBody*> cubes;
		for (int i = 0; i < 5; ++i)
		{
			cubes.push_back(&world.put(unitCube(), 1, {i == 0 ? -2 : 1.01 * (i - 1), 0, 0}));
			cubes.back()->setRestitution(1);
		}
		cubes.front()->setLinearVelocity(btVector3(3, 0, 0));
		for (int i = 0; i < int(rate); ++i) world.step();
		for (const btRigidBody* cube : cubes)
			EXPECT_NEAR(double(cube->getLinearVelocity().x()), cube == cubes.back() ? 3 : 0, 0.03) << " at " << rate;
	}
}
}  // namespace clod::test
