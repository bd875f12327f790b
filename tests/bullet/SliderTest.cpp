// SPDX-License-Identifier: GPL-3.0-or-later
// Ghost forces at patch borders: a body sliding without friction over a flat slab of many patches must feel nothing. And
// a body that slides from rest into a wedge.
// The bound on vertical speed is 1e-3 sqrt(g L), L the body's size; forward speed must not change.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clod/bullet/BodyState.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"

namespace clod::test
{
namespace
{
constexpr double kGravity = 981;  // centimetres
constexpr double kSpeed = 50;

double restHeight(const btClodShape& shape)
{
	return -double(shape.hierarchy().asset().boxMin[1]);
}

struct Ride
{
	double vertical = 0, spin = 0, forward = 0;
};

Ride slide(const PatchedMesh& bodyMesh, bool slabFirst)
{
	BulletWorld scene;
	scene.world.setGravity(btVector3(0, btScalar(-kGravity), 0));
	btClodShape& slab = scene.addShape(patchHierarchy(boxMesh({80, 2, 20}, {85, 2, 8}, 1)));  // 1,714 patches
	btClodShape& shape = scene.addShape(patchHierarchy(bodyMesh));
	const auto addSlab = [&] { scene.addBody(slab, 0, {0, -1, 0}).setFriction(0); };
	if (slabFirst) addSlab();
	btRigidBody& body = scene.addBody(shape, 1, {-35.03, restHeight(shape), 0.017});
	if (!slabFirst) addSlab();
	body.setFriction(0);
	body.setLinearVelocity(btVector3(btScalar(kSpeed), 0, 0));
	Ride ride;
	for (int i = 0; i < 300; ++i)
	{
		scene.step();
		if (i < 24) continue;  // the first contact
		ride.vertical = std::max(ride.vertical, std::abs(double(body.getLinearVelocity().y())));
		ride.spin = std::max(ride.spin, double(body.getAngularVelocity().length()));
	}
	ride.forward = double(body.getLinearVelocity().x());
	return ride;
}

void expectSmooth(const Ride& ride, double size)
{
	EXPECT_LT(ride.vertical, 1e-3 * std::sqrt(kGravity * size));
	EXPECT_NEAR(ride.forward, kSpeed, 1e-3 * kSpeed);
	EXPECT_LT(ride.spin, 0.02);  // a rocking polyhedron, bounded
}
}  // namespace

TEST(Slider, BallOfOnePatch)
{
	for (const bool slabFirst : {true, false}) expectSmooth(slide(ballMesh(2, 3), slabFirst), 4);
}

TEST(Slider, BallWhoseTrianglesAreAllPatches)
{
	for (const bool slabFirst : {true, false}) expectSmooth(slide(singleTriangles(ballMesh(2, 3)), slabFirst), 4);
}

TEST(Slider, Box)
{
	for (const bool slabFirst : {true, false}) expectSmooth(slide(boxMesh({4, 2, 3}, {1, 1, 1}, 1), slabFirst), 2);
}

TEST(Slider, BoxOfManyPatches)
{
	for (const bool slabFirst : {true, false}) expectSmooth(slide(boxMesh({4, 2, 3}, {8, 4, 6}, 2), slabFirst), 2);
}

// Over Bullet's own triangle mesh as well.
TEST(Slider, BallAndBoxOverATriangleMesh)
{
	for (const bool ball : {true, false})
	{
		BulletWorld scene;
		scene.world.setGravity(btVector3(0, btScalar(-kGravity), 0));
		btTriangleMesh mesh;
		for (int i = 0; i < 80; ++i)
			for (int j = 0; j < 20; ++j)
			{
				const btVector3 a(btScalar(i - 40), 0, btScalar(j - 10)), x(1, 0, 0), z(0, 0, 1);
				mesh.addTriangle(a, a + z, a + x);
				mesh.addTriangle(a + x + z, a + x, a + z);
			}
		auto& ground = scene.add(std::make_unique<btBvhTriangleMeshShape>(&mesh, true));
		scene.addBody(ground, 0, {}).setFriction(0);
		const PatchedMesh bodyMesh = ball ? ballMesh(2, 3) : boxMesh({4, 2, 3}, {1, 1, 1}, 1);
		btClodShape& shape = scene.addShape(patchHierarchy(bodyMesh));
		btRigidBody& body = scene.addBody(shape, 1, {-35.03, restHeight(shape), 0.017});
		body.setFriction(0);
		body.setLinearVelocity(btVector3(btScalar(kSpeed), 0, 0));
		Ride ride;
		for (int i = 0; i < 300; ++i)
		{
			scene.step();
			if (i >= 24) ride.vertical = std::max(ride.vertical, std::abs(double(body.getLinearVelocity().y())));
		}
		ride.forward = double(body.getLinearVelocity().x());
		expectSmooth(ride, 2);
	}
}

// From rest into the gap between a floor and a wall that leans over it: the wall turns the motion of the very first step,
// in which forces alone move the body, and nothing moves it towards the floor.
TEST(Slider, FromRestIntoAWedge)
{
	for (const double angle : {0.4, 0.6, 0.8})
	{
		BulletWorld scene;
		scene.timeStep = 1.0 / 60;
		scene.world.setGravity(btVector3(600, 0, 0));
		const btScalar s = btScalar(std::sin(angle)), c = btScalar(std::cos(angle));
		btClodShape& slab = scene.addShape(patchHierarchy(boxMesh({10, 2, 10}, {1, 1, 1}, 1)));
		scene.addBody(slab, 0, {0, -1, 0}).setFriction(0);
		const btVector3 edge = btVector3(0.5, btScalar(1.005), 0) + btScalar(1.002) * btVector3(c, s, 0);
		const btQuaternion lean(btVector3(0, 0, 1), btScalar(angle) + SIMD_HALF_PI);
		scene.addBody(slab, 0, toVec3(edge), lean).setFriction(0);
		btClodShape& box = scene.addShape(patchHierarchy(boxMesh({1, 1, 1}, {1, 1, 1}, 1)));
		btRigidBody& cube = scene.addBody(box, 1, {0, 0.505, 0});
		cube.setFriction(0);
		for (int i = 0; i < 10; ++i)
		{
			scene.step();
			double lowest = 1;
			for (const double x : {-0.5, 0.5})
				for (const double y : {-0.5, 0.5})
					lowest = std::min(lowest, double((cube.getWorldTransform() * btVector3(btScalar(x), btScalar(y), 0)).y()));
			EXPECT_GT(lowest, -2e-3) << angle << ", step " << i;
		}
	}
}
}  // namespace clod::test
