// SPDX-License-Identifier: GPL-3.0-or-later
// What is gathered of a mesh for a body over it: no more than the body may meet, and what it meets at once.
#include <gtest/gtest.h>

#include <cmath>

#include "clod/bullet/ConfigureWorld.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
// Tells how much of it was asked for last.
struct AskedMesh : btBvhTriangleMeshShape
{
	using btBvhTriangleMeshShape::btBvhTriangleMeshShape;
	mutable btVector3 low, high;
	void processAllTriangles(btTriangleCallback* callback, const btVector3& from, const btVector3& to) const override
	{
		low = from;
		high = to;
		btBvhTriangleMeshShape::processAllTriangles(callback, from, to);
	}
};

// A cube on its edge that goes without gravity over waves, or along a rail towards a wall: its box has triangles in it that it
// does not meet.
struct OverMesh : BulletWorld
{
	static constexpr double kSize = 0.5;  // radius of what is over the mesh
	explicit OverMesh(bool hasWaves)
	{
		world.setGravity(btVector3(0, 0, 0));
		const auto at = [](int i, int j)
		{ return btVector3(btScalar(0.1 * i), btScalar(0.05 * std::sin(0.9 * i) * std::cos(0.7 * j)), btScalar(0.1 * j)); };
		for (int i = -9; i < 12 && hasWaves; ++i)
			for (int j = -9; j < 9; ++j)
			{
				triangles.addTriangle(at(i, j), at(i, j + 1), at(i + 1, j));
				triangles.addTriangle(at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
			}
		if (!hasWaves) triangles.addTriangle({-2, btScalar(0.23), btScalar(-0.2)}, {2, btScalar(0.23), btScalar(-0.2)}, {2, btScalar(0.2), btScalar(-0.2)});
		const btScalar wall = btScalar(1.01);
		triangles.addTriangle({wall, btScalar(0.2), -1}, {wall, btScalar(0.2), 1}, {wall, 2, 0});
		mesh = &add(std::make_unique<AskedMesh>(&triangles, true));
		addBody(*mesh, 0, {});
		btClodShape& shape = addShape(body("cube").hierarchy, kSize);
		cube = &addBody(shape, 1, {}, btQuaternion(btVector3(1, 0, 0), btScalar(0.785)));
	}
	btTriangleMesh triangles;
	AskedMesh* mesh;
	btRigidBody* cube;
};
}  // namespace

TEST(NearMesh, NoMoreOfAMeshIsGatheredThanABodyApartMayMeet)
{
	OverMesh scene(true);
	const double reach = OverMesh::kSize / std::sqrt(3.0);  // along the edge it stands on
	for (int i = 0; i < 50; ++i)
	{
		const btScalar x = btScalar(0.007 * i);
		scene.cube->getWorldTransform().setOrigin(btVector3(x, btScalar(0.6), 0));
		scene.world.performDiscreteCollisionDetection();
		ASSERT_EQ(scene.context.lastStep().nodePairs, 0u);
		EXPECT_LT(double(scene.mesh->high.x() - x), 1.1 * reach) << i;
		EXPECT_GT(double(scene.mesh->low.x() - x), -1.1 * reach) << i;
		EXPECT_GT(double(scene.mesh->high.x() - x), reach) << i;
	}
}

// However often it was asked before, a pair meets what one meets that never was: on the way down, turning, over waves,
// and to the wall.
TEST(NearMesh, WhatIsApartFromAMeshIsMetAsByANewPair)
{
	int apart = 0, near = 0;
	for (int approach = 0; approach < 12; ++approach)
	{
		const bool comesDown = approach < 2;
		OverMesh asked(comesDown);
		Vec3 place{0.35 + 0.013 * approach, comesDown ? 0.6 : 0.53, 0.1};
		Vec3 move = comesDown ? Vec3{0.0005, -0.0015, 0} : Vec3{0.006, 0, 0};
		int met = 0;
		for (int step = 0; step < 250 && met < (comesDown ? 60 : 5); ++step)
		{
			place += move;
			btTransform& pose = asked.cube->getWorldTransform();
			pose.setOrigin(toBullet(place));
			if (comesDown) pose.setRotation(btQuaternion(btVector3(0, 1, 0), btScalar(0.001)) * pose.getRotation());
			OverMesh unasked(comesDown);
			unasked.cube->setWorldTransform(pose);
			asked.world.performDiscreteCollisionDetection();
			unasked.world.performDiscreteCollisionDetection();
			const StepReport now = asked.context.lastStep(), fresh = unasked.context.lastStep();
			ASSERT_EQ(now.nodePairs, fresh.nodePairs) << approach << " at " << step;
			ASSERT_EQ(asked.contacts() > 0, unasked.contacts() > 0) << approach << " at " << step;
			met += now.nodePairs > 0;
			if (asked.contacts() > 0 && comesDown) move = {0.006, 0, 0};
			apart += now.boxTests == 0;
		}
		near += met;
		EXPECT_GT(met, 0) << approach;
	}
	std::printf("left alone %d times, near %d times\n", apart, near);
	EXPECT_GT(apart, 100);
	EXPECT_GT(near, 10);
}

TEST(NearMesh, AMeshEditedIntoABodyApartIsMetAtOnce)
{
	OverMesh scene(true);
	scene.cube->getWorldTransform().setOrigin(btVector3(0, btScalar(0.45), btScalar(0.224)));  // crests beside its edge
	scene.step(5);
	ASSERT_EQ(scene.context.lastStep().nodePairs, 0u);
	ASSERT_EQ(scene.context.lastStep().boxTests, 0u);  // left alone
	unsigned char *vertices, *indices;
	int count, stride, faceStride, faces;
	PHY_ScalarType type, indexType;
	scene.triangles.getLockedVertexIndexBase(&vertices, count, type, stride, &indices, faceStride, faces, indexType);
	for (int i = 0; i < count; ++i)
	{
		auto* vertex = reinterpret_cast<btScalar*>(vertices + i * stride);
		if (std::hypot(double(vertex[0]), double(vertex[2])) < 0.5) vertex[1] += btScalar(0.3);
	}
	scene.triangles.unLockVertexBase(0);
	scene.mesh->refitTree(btVector3(-3, -1, -3), btVector3(3, 2, 3));
	scene.step();
	EXPECT_GT(scene.context.lastStep().nodePairs, 0u);
	EXPECT_GT(scene.contacts(), 0);
}
}  // namespace clod::test
