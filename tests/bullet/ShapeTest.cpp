// SPDX-License-Identifier: GPL-3.0-or-later
// btClodShape as Bullet sees it, alone.
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <set>

#include "clod/bullet/btClodShape.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"

namespace clod::test
{
namespace
{
struct Collector : btTriangleCallback
{
	std::multiset<int> indices;
	bool finite = true;
	void processTriangle(btVector3* corners, int, int index) override
	{
		indices.insert(index);
		for (int i = 0; i < 3; ++i) finite = finite && std::isfinite(double(corners[i].length2()));
	}
};

// All triangles whose own box meets the given box, without any tree.
std::multiset<int> bruteForce(const btClodShape& shape, const btVector3& low, const btVector3& high)
{
	std::multiset<int> indices;
	const Hierarchy& hierarchy = shape.hierarchy();
	for (const Node& node : hierarchy.nodes())
		for (std::uint32_t i = 0; node.level == 0 && i < node.faceCount; ++i)
		{
			const Face& face = hierarchy.faces()[node.firstFace + i];
			btVector3 corners[3];
			for (int k = 0; k < 3; ++k)
			{
				const Vec3 v = shape.scale() * hierarchy.hull(node).vertex(face.vertex[k]);
				corners[k] = btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z));
			}
			if (TestTriangleAgainstAabb2(corners, low, high)) indices.insert(int(node.firstFace + i));
		}
	return indices;
}

struct RayHit : btTriangleRaycastCallback
{
	double fraction = 2;
	int visited = 0;
	using btTriangleRaycastCallback::btTriangleRaycastCallback;
	void processTriangle(btVector3* corners, int part, int index) override
	{
		++visited;
		btTriangleRaycastCallback::processTriangle(corners, part, index);
	}
	btScalar reportHit(const btVector3&, btScalar hit, int, int) override
	{
		fraction = std::min(fraction, double(hit));
		return hit;
	}
};
// What a ray meets of the shape, asked as Bullet does, and of all its triangles without any tree.
struct RayHits
{
	RayHit fast, slow;
	RayHits(const btClodShape& shape, const btVector3& from, const btVector3& to) : fast(from, to), slow(from, to)
	{
		btVector3 low = from, high = from;
		low.setMin(to);
		high.setMax(to);
		shape.processAllTriangles(&fast, low, high);
		const Hierarchy& hierarchy = shape.hierarchy();
		for (const Node& node : hierarchy.nodes())
			for (std::uint32_t f = 0; node.level == 0 && f < node.faceCount; ++f)
			{
				btVector3 corners[3];
				for (int k = 0; k < 3; ++k)
				{
					const Vec3 v = hierarchy.hull(node).vertex(hierarchy.faces()[node.firstFace + f].vertex[k]);
					corners[k] = btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z));
				}
				slow.btTriangleRaycastCallback::processTriangle(corners, 0, 0);
			}
	}
};
}  // namespace

TEST(ClodShape, TrianglesInABoxAreThoseOfBruteForce)
{
	const btClodShape shape(patchHierarchy(boxMesh({4, 2, 3}, {8, 4, 6}, 2)));
	std::mt19937 random(7);
	std::uniform_real_distribution<double> place(-3, 3), size(0, 2);
	int hits = 0;
	for (int i = 0; i < 200; ++i)
	{
		btVector3 low, high;
		for (int k = 0; k < 3; ++k) low[k] = btScalar(place(random));
		for (int k = 0; k < 3; ++k) high[k] = low[k] + btScalar(size(random));
		Collector found;
		shape.processAllTriangles(&found, low, high);
		EXPECT_EQ(found.indices, bruteForce(shape, low, high));
		hits += found.indices.empty() ? 0 : 1;
	}
	EXPECT_GT(hits, 40);
	EXPECT_LT(hits, 160);
}

TEST(ClodShape, ADebugDrawersEndlessBoxGivesEveryTriangle)
{
	const btClodShape shape(patchHierarchy(ballMesh(1, 2)));
	Collector found;
	const btVector3 everything(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
	shape.processAllTriangles(&found, -everything, everything);
	EXPECT_EQ(found.indices.size(), 320u);
	EXPECT_TRUE(found.finite);
}

TEST(ClodShape, RaysHitAsBruteForceDoesAndVisitFewTriangles)
{
	const btClodShape shape(patchHierarchy(boxMesh({40, 2, 40}, {80, 1, 80}, 1)));
	std::mt19937 random(11);
	std::uniform_real_distribution<double> place(-30, 30);
	int hits = 0;
	for (int i = 0; i < 100; ++i)
	{
		btVector3 from(0, 25, 0), to(0, -25, 0);
		for (btVector3* end : {&from, &to})
			for (const int k : {0, 2}) (*end)[k] = btScalar(place(random));
		const RayHits ray(shape, from, to);  // whose box, long and diagonal, holds most triangles
		EXPECT_EQ(ray.fast.fraction, ray.slow.fraction);
		EXPECT_LT(ray.fast.visited, 100);  // of 25,600
		hits += ray.fast.fraction <= 1 ? 1 : 0;
	}
	EXPECT_GT(hits, 30);
	EXPECT_LT(hits, 80);
}

// Bullet's triangle test has room beside an edge. A ray that picks along one, and so has a box as thin as itself, must get
// there: a third of those that rounding moved outward were lost.
TEST(ClodShape, RaysAlongEdgesHitAsBruteForceDoes)
{
	const btClodShape shape(patchHierarchy(boxMesh({4, 2, 3}, {2, 2, 2}, 1)));
	std::mt19937 random(13);
	std::uniform_real_distribution<double> rounding(-3e-6, 3e-6);
	const double half[3] = {2, 1, 1.5};
	int hits = 0;
	for (int i = 0; i < 300; ++i)
	{
		btVector3 from, to;
		for (int k = 0; k < 3; ++k)
		{
			const double side = (i >> k & 1) != 0 ? half[k] : -half[k];
			from[k] = btScalar((k == i % 3 ? 3 : 1) * side + rounding(random));
			to[k] = btScalar((k == i % 3 ? -3 : 1) * side + rounding(random));
		}
		const RayHits ray(shape, from, to);
		EXPECT_EQ(ray.fast.fraction, ray.slow.fraction) << i;
		hits += ray.slow.fraction <= 1 ? 1 : 0;
	}
	EXPECT_GT(hits, 280);
}

TEST(ClodShape, SweepsLookAtTheirOwnWayOnly)
{
	struct Counter : btTriangleConvexcastCallback
	{
		int triangles = 0;
		using btTriangleConvexcastCallback::btTriangleConvexcastCallback;
		void processTriangle(btVector3*, int, int) override { ++triangles; }
		btScalar reportHit(const btVector3&, const btVector3&, btScalar, int, int) override { return 1; }
	};
	const btClodShape shape(patchHierarchy(boxMesh({20, 1, 20}, {20, 1, 20}, 2)));
	const btSphereShape ball(btScalar(0.1));
	const auto at = [](double x, double y, double z)
	{ return btTransform(btQuaternion::getIdentity(), btVector3(btScalar(x), btScalar(y), btScalar(z))); };
	const btVector3 low(btScalar(-9.2), -2, btScalar(-9.2));
	Counter counter(&ball, at(-9, 1, -9), at(9, 1, 9), at(0, 0, 0), 0);
	shape.processAllTriangles(&counter, low, -low);
	EXPECT_EQ(counter.triangles, 0);
	Counter along(&ball, at(-9, 0.5, -9), at(9, 0.5, 9), at(0, 0, 0), 0);
	shape.processAllTriangles(&along, low, -low);
	EXPECT_GT(along.triangles, 36);
	EXPECT_LT(along.triangles, 260);  // of 800 on that side: patches of eight along the diagonal
}

TEST(ClodShape, InertiaIsThatOfTheSolid)
{
	btClodShape box(patchHierarchy(boxMesh({4, 2, 3}, {8, 4, 6}, 2)));
	btVector3 inertia;
	box.calculateLocalInertia(12, inertia);
	EXPECT_NEAR(double(inertia.x()), 4 + 9, 1e-4);
	EXPECT_NEAR(double(inertia.y()), 16 + 9, 1e-4);
	EXPECT_NEAR(double(inertia.z()), 16 + 4, 1e-4);
	box.setLocalScaling(btVector3(2, 2, 2));
	box.calculateLocalInertia(12, inertia);
	EXPECT_NEAR(double(inertia.x()), 4 * 13, 1e-3);
	const btVector3 principal = box.principalInertia(12);
	EXPECT_NEAR(double(principal.y()), 4 * 25, 1e-3);
}

TEST(ClodShape, ScalesOfZeroAreRefusedWithAReason)
{
	btClodShape shape(patchHierarchy(boxMesh({4, 2, 3}, {1, 1, 1}, 1)));
	const int before = shape.revision();
	const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
	for (const btVector3& bad :
		 {btVector3(1, 0, 1), btVector3(0, 0, 0), btVector3(nan, nan, nan), btVector3(1, 1, nan)})
	{
		shape.setLocalScaling(bad);
		EXPECT_EQ(shape.scale(), 1);
		EXPECT_NE(shape.scalingError(), "");
	}
	EXPECT_EQ(shape.revision(), before);
	shape.setLocalScaling(btVector3(100, 100, 100));
	EXPECT_EQ(shape.scale(), 100);
	EXPECT_EQ(shape.scalingError(), "");
	EXPECT_NE(shape.revision(), before);
	btVector3 low, high;
	shape.getAabb(btTransform::getIdentity(), low, high);
	EXPECT_LE(double(low.x()), -200);
	EXPECT_NEAR(double(high.y()), 100, 0.002 * 270);
	EXPECT_GE(double(high.y()), 100);
}

TEST(ClodShape, MarginWidensTheAabbOnly)
{
	btClodShape shape(patchHierarchy(boxMesh({2, 2, 2}, {1, 1, 1}, 1)));
	EXPECT_EQ(double(shape.getMargin()), 0);
	shape.setMargin(btScalar(0.5));
	btVector3 low, high;
	shape.getAabb(btTransform::getIdentity(), low, high);
	EXPECT_NEAR(double(high.x()), 1.5, 0.002 * 1.74);
}

// Bullet's 2 % of the radius would merge neighbouring teeth.
TEST(ClodShape, BreakingThresholdIsFine)
{
	const btClodShape shape(patchHierarchy(ballMesh(1, 2)));
	EXPECT_LE(double(shape.getContactBreakingThreshold(btScalar(0.02))), 0.0031);
	EXPECT_GT(double(shape.getContactBreakingThreshold(btScalar(0.02))), 0);
}

TEST(ClodShape, MeshFromBodyIsTheCentreOfMass)
{
	PatchedMesh mesh = boxMesh({4, 2, 3}, {1, 1, 1}, 1);
	for (Vec3& v : mesh.vertices) v += Vec3{1, 2, 3};
	btClodShape shape(patchHierarchy(mesh));
	shape.setLocalScaling(btVector3(10, 10, 10));
	EXPECT_NEAR(double(shape.meshFromBody().getOrigin().z()), 30, 1e-4);
}

// A shape keeps its hands off the fields that belong to the user.
TEST(ClodShape, UserFieldsAreUntouched)
{
	btClodShape shape(patchHierarchy(ballMesh(1, 1)));
	EXPECT_EQ(shape.getUserPointer(), nullptr);
	EXPECT_EQ(shape.getUserIndex(), -1);
	EXPECT_STREQ(shape.getName(), "Clod");
	EXPECT_FALSE(shape.isNonMoving() && shape.isConvex());
}
}  // namespace clod::test
