// SPDX-License-Identifier: GPL-3.0-or-later
// The nearest point of a triangle, those without area among them.
#include "clod/query/SurfaceFaces.h"

#include <gtest/gtest.h>

#include <algorithm>

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
}  // namespace
