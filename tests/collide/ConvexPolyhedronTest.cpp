// SPDX-License-Identifier: GPL-3.0-or-later
// Hulls by support function: every point inside, every corner one of the points, closed, and the error as certified.
#include "clod/collide/ConvexPolyhedron.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
// The farthest that a point lies out of the polyhedron, whose triangles must close.
double farthestOut(const ConvexPolyhedron& hull, const std::vector<Vec3>& points)
{
	double out = -1e300;
	std::map<std::array<std::uint32_t, 2>, int> sides;
	for (const auto& t : hull.triangles)
	{
		const Vec3 &a = hull.vertices[t[0]], &b = hull.vertices[t[1]], &c = hull.vertices[t[2]];
		const Vec3 normal = normalized(cross(b - a, c - a));
		for (const Vec3& p : points) out = std::max(out, dot(normal, p - a));
		for (std::size_t i = 0; i < 3; ++i) ++sides[{t[i], t[(i + 1) % 3]}];
	}
	for (const auto& [side, count] : sides)
	{
		EXPECT_EQ(count, 1);
		EXPECT_EQ(sides.count({side[1], side[0]}), 1u);
	}
	EXPECT_EQ(hull.triangles.size(), 2 * hull.vertices.size() - 4);
	return out;
}
std::vector<Vec3> cubeCorners()
{
	std::vector<Vec3> points;
	for (int i = 0; i < 8; ++i) points.push_back({double(i & 1), double(i >> 1 & 1), double(i >> 2)});
	return points;
}
}  // namespace

TEST(ConvexPolyhedron, HoldsAllPointsWithCornersAmongThem)
{
	Random random(1);
	for (int round = 0; round < 40; ++round)
	{
		std::vector<Vec3> points;
		const double flat = round % 2 == 0 ? 1 : 1e-3, scale = std::pow(10.0, round % 7 - 3);
		for (int i = 0; i < 8 + 10 * round; ++i)
		{
			const Vec3 p = scale * (round % 3 == 0 ? randomDirection(random)
												   : Vec3{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)});
			points.push_back(toVec3(toFloat3({p.x, flat * p.y, p.z + 3 * scale})));
		}
		const ConvexPolyhedron hull = convexPolyhedron(points, 65535);
		EXPECT_LE(farthestOut(hull, points), 1e-6 * scale) << round;
		EXPECT_LE(farthestOut(hull, points), hull.error + 1e-12 * scale) << round;
		EXPECT_LE(hull.error, 1e-6 * scale) << round;
		for (const Vec3& v : hull.vertices) EXPECT_NE(std::find(points.begin(), points.end(), v), points.end());
		// A planted fault: without one of its corners a hull does not hold it.
		std::vector<Vec3> fewer = points;
		fewer.erase(std::find(fewer.begin(), fewer.end(), hull.vertices[0]));
		if (flat < 1) continue;
		EXPECT_GT(farthestOut(convexPolyhedron(fewer, 65535), points), 1e-6 * scale) << round;
	}
}

// Faces of many points each, all but flat: what rounding keeps out is within the error told.
TEST(ConvexPolyhedron, WhatIsLeftOutIsWithinTheError)
{
	Random random(9);
	int leftOut = 0;
	for (int round = 0; round < 60; ++round)
	{
		const Mat3 turn = randomRotation(random);
		const double noise = std::pow(10.0, -9 + round % 5);
		std::vector<Vec3> points;
		for (int i = 0; i < 150; ++i)
		{
			Vec3 p{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
			if (round % 2 == 0) p[i % 3] = (i % 2 ? 1 : -1) + noise * uniform(random, -1, 1);
			p.z *= round % 3 == 0 ? 1 : 4e-6;
			points.push_back(toVec3(toFloat3(turn * p)));
		}
		const ConvexPolyhedron hull = convexPolyhedron(points, 65535);
		const double out = farthestOut(hull, points);
		EXPECT_LE(out, hull.error + 1e-12) << round;
		leftOut += out > 1e-10;
	}
	EXPECT_GT(leftOut, 20);
}

// Cylinders, flat but for rounding at their ends, where points may be a little above a face that stays: the face made
// of one and a short edge is so steep that corners of the other face are above it.
TEST(ConvexPolyhedron, WhatIsAboveASteepFaceIsWithinTheError)
{
	Random random(10);
	int isSteep = 0;
	for (int round = 0; round < 200; ++round)
	{
		const Mat3 turn = randomRotation(random);
		const double noise = std::pow(10.0, -11 + round % 5);
		std::vector<Vec3> points;
		for (int i = 0; i < 120; ++i)
		{
			const double angle = uniform(random, 0, 6.28), z = (i % 2 ? 0.5 : -0.5) + noise * uniform(random, -1, 1);
			points.push_back(toVec3(toFloat3(turn * Vec3{std::cos(angle), std::sin(angle), z})));
		}
		const ConvexPolyhedron hull = convexPolyhedron(points, 65535);
		EXPECT_LE(farthestOut(hull, points), hull.error + 5e-12) << round;
		isSteep += hull.error > 1e-6;
	}
	EXPECT_GT(isSteep, 10);
}

// Points are found through a tree: as one after the other they make the same hull, of equal ones the first counting.
TEST(ConvexPolyhedron, IsTheSameWhereAllPointsAreLookedAt)
{
	Random random(4);
	for (int round = 0; round < 24; ++round)
	{
		std::vector<Vec3> points;
		for (int i = 0; i < 3 + 17 * round; ++i)
		{
			Vec3 p = round % 3 == 0 ? randomDirection(random)
									: Vec3{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
			for (int axis = 0; axis < 3 && round % 3 == 1; ++axis) p[axis] = 0.25 * std::round(4 * p[axis]);
			points.push_back(toVec3(toFloat3(p)));
		}
		const Support one = [&points](const Vec3& direction)
		{
			return *std::max_element(points.begin(), points.end(), [&](const Vec3& l, const Vec3& r)
									 { return dot(l, direction) < dot(r, direction); });
		};
		const ConvexPolyhedron hull = convexPolyhedron(points, 65535), expected = convexPolyhedron(one, 0, 65535);
		EXPECT_EQ(hull.vertices, expected.vertices) << round;
		EXPECT_EQ(hull.triangles, expected.triangles) << round;
		EXPECT_EQ(hull.error, expected.error) << round;
	}
}

TEST(ConvexPolyhedron, PointsOfACubeAddNothingButItsCorners)
{
	std::vector<Vec3> points = cubeCorners();
	for (int x = 0; x <= 4; ++x)
		for (int y = 0; y <= 4; ++y)
			for (int z = 0; z <= 4; ++z) points.push_back({0.25 * x, 0.25 * y, 0.25 * z});
	const ConvexPolyhedron hull = convexPolyhedron(points, 65535);
	EXPECT_EQ(hull.vertices.size(), 8u);
	EXPECT_EQ(hull.triangles.size(), 12u);
	EXPECT_LE(farthestOut(hull, points), 1e-12);
}

TEST(ConvexPolyhedron, FewerDimensionsAreTold)
{
	EXPECT_EQ(convexPolyhedron({{1, 2, 3}, {1, 2, 3}}, 100).vertices.size(), 1u);
	const ConvexPolyhedron segment = convexPolyhedron({{0, 0, 0}, {1, 1, 1}, {3, 3, 3}, {2, 2, 2}}, 100);
	EXPECT_EQ(segment.vertices.size(), 2u);
	EXPECT_TRUE(segment.triangles.empty());
	const ConvexPolyhedron square = convexPolyhedron({{0, 0, 0}, {1, 0, 1}, {1, 2, 1}, {0, 2, 0}, {0.5, 1, 0.5}}, 100);
	EXPECT_EQ(square.vertices.size(), 4u);
	EXPECT_EQ(square.triangles.size(), 4u);
}

// A ball of unequal axes: the error is what its support function says, and shrinks with the corners.
TEST(ConvexPolyhedron, RoundBodiesAreAsNearAsCertified)
{
	const Vec3 axes{1, 0.5, 2};
	const Support ball = [&axes](const Vec3& d)
	{
		const Vec3 scaled{axes.x * d.x, axes.y * d.y, axes.z * d.z};
		const Vec3 unit = normalized(scaled);
		return Vec3{axes.x * unit.x, axes.y * unit.y, axes.z * unit.z};
	};
	double last = 1e300;
	for (const std::size_t most : {16u, 64u, 256u})
	{
		const ConvexPolyhedron hull = convexPolyhedron(ball, 0, most);
		double worst = 0;
		for (const auto& t : hull.triangles)
		{
			const Vec3& a = hull.vertices[t[0]];
			const Vec3 normal = normalized(cross(hull.vertices[t[1]] - a, hull.vertices[t[2]] - a));
			worst = std::max(worst, dot(normal, ball(normal) - a));
		}
		EXPECT_NEAR(hull.error, worst, 1e-6);
		EXPECT_LT(hull.error, 0.5 * last);
		last = hull.error;
	}
	const ConvexPolyhedron enough = convexPolyhedron(ball, 0.05, 10000);
	EXPECT_LE(enough.error, 0.05);
	EXPECT_GT(enough.error, 0.02) << enough.vertices.size() << " corners are more than that takes";
}
}  // namespace clod::test
