// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles: the nearest point, also where there is no area, and clipping, also where rounding decides.
#include "clod/collide/Triangle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "clod/collide/ClippedPolygon.h"
#include "tests/query/Bodies.h"

namespace
{
using namespace clod;
using namespace clod::test;

double distanceToEdges(const Triangle& triangle, const Vec3& from)
{
	double best = std::numeric_limits<double>::infinity();
	for (int i = 0; i < 3; ++i)
	{
		const Vec3 corner = triangle[i], edge = triangle[(i + 1) % 3] - corner;
		const double squared = lengthSquared(edge);
		const double share = squared > 0 ? std::clamp(dot(from - corner, edge) / squared, 0.0, 1.0) : 0;
		best = std::min(best, length(from - corner - share * edge));
	}
	return best;
}

// Of corners in one line, no area is left but rounding: where along it the nearest point lies is known the less.
TEST(NearestOnTriangle, IsOnTheEdgesWhereThereIsNoArea)
{
	Random random(41);
	for (int i = 0; i < 20000; ++i)
	{
		const Vec3 p = randomDirection(random), q = randomDirection(random);
		const Vec3 between = p + uniform(random, -1, 2) * (q - p), from = 2 * randomDirection(random);
		const Triangle shapes[] = {{p, p, q}, {p, q, q}, {p, q, p}, {p, p, p}, {p, q, between}, {p, between, q}};
		for (int shape = 0; shape < 6; ++shape)
		{
			const NearestOnTriangle nearest = nearestOnTriangle(shapes[shape], from);
			const double truth = distanceToEdges(shapes[shape], from);
			ASSERT_NEAR(std::sqrt(nearest.squared), truth, shape < 4 ? 1e-12 : 1e-4) << i << " shape " << shape;
			ASSERT_NEAR(length(from - nearest.point), truth, shape < 4 ? 1e-12 : 1e-4);
		}
	}
}

TEST(NearestOnTriangle, IsNoFartherThanAnyPointOfIt)
{
	Random random(42);
	for (int i = 0; i < 20000; ++i)
	{
		const Triangle triangle = {randomDirection(random), randomDirection(random), randomDirection(random)};
		const Vec3 from = 2 * randomDirection(random);
		const NearestOnTriangle nearest = nearestOnTriangle(triangle, from);
		double u = uniform(random, 0, 1), v = uniform(random, 0, 1);
		if (u + v > 1) u = 1 - u, v = 1 - v;
		const Vec3 other = triangle[0] + u * (triangle[1] - triangle[0]) + v * (triangle[2] - triangle[0]);
		ASSERT_LE(std::sqrt(nearest.squared), length(from - other) * (1 + 1e-12));
		ASSERT_LE(std::sqrt(nearest.squared), distanceToEdges(triangle, from) * (1 + 1e-12));
	}
}
// Each plane adds a corner at most, and what is left is all of the triangle that is not beyond a plane.
TEST(ClippedPolygon, HoldsWhatFivePlanesLeave)
{
	Random random(43);
	int most = 0;
	for (int i = 0; i < 20000; ++i)
	{
		const Triangle triangle = {randomDirection(random), randomDirection(random), randomDirection(random)};
		ClippedPolygon polygon(triangle);
		double u = uniform(random, 0, 1), v = uniform(random, 0, 1);
		if (u + v > 1) u = 1 - u, v = 1 - v;
		const Vec3 inside = triangle[0] + u * (triangle[1] - triangle[0]) + v * (triangle[2] - triangle[0]);
		for (int plane = 0; plane < 5; ++plane)
		{
			const Vec3 normal = randomDirection(random);
			const int before = polygon.count;
			clipByPlane(polygon, normal, dot(normal, inside) + 0.1 * uniform(random, 0, 1));
			ASSERT_LE(polygon.count, before + 1);
			ASSERT_GE(polygon.count, 3);
		}
		most = std::max(most, polygon.count);
		Vec3 sum;
		for (int k = 0; k < polygon.count; ++k) sum += polygon.vertex[std::size_t(k)];
		const Vec3 middle = (1.0 / polygon.count) * sum;
		// On the same side of each edge as the middle.
		for (int k = 0; k < polygon.count; ++k)
		{
			const Vec3 from = polygon.vertex[std::size_t(k)],
					   edge = polygon.vertex[std::size_t((k + 1) % polygon.count)] - from;
			ASSERT_GT(dot(cross(edge, middle - from), cross(edge, inside - from)), -1e-12);
		}
	}
	EXPECT_EQ(most, ClippedPolygon::kMost);
}

// Corners in one line have signs that rounding gives them, in any order.
TEST(ClippedPolygon, StaysWholeWhereRoundingDecides)
{
	ClippedPolygon zigzag;
	zigzag.count = 6;
	for (int i = 0; i < 6; ++i) zigzag.vertex[std::size_t(i)] = {double(i), 0, i % 2 ? 1e-17 : -1e-17};
	clipByPlane(zigzag, {0, 0, 1}, 0);
	EXPECT_EQ(zigzag.count, 6);
}
}  // namespace
