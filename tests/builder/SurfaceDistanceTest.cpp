// SPDX-License-Identifier: GPL-3.0-or-later
// The certified distance of two surfaces against samples and brute force, and the oracle against planted faults.
#include <gtest/gtest.h>

#include <random>

#include "builder/assemble/Geometry.h"
#include "builder/repair/SurfaceDistance.h"
#include "tests/support/Meshes.h"

namespace clod::test
{
namespace
{
using builder::DistanceBracket;
using builder::Mesh;

builder::Triangle triangleOf(const Mesh& mesh, std::size_t i)
{
	const auto& t = mesh.triangles[i];
	return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

double bruteDistance(const Vec3& p, const Mesh& to)
{
	double best = std::numeric_limits<double>::infinity();
	for (std::size_t i = 0; i < to.triangles.size(); ++i)
		best = std::min(best, builder::distanceSquared(p, triangleOf(to, i)));
	return std::sqrt(best);
}

// No sample is farther than `upper`; the point of the lower bound lies on `from` and has the distance claimed.
bool holds(const Mesh& from, const Mesh& to, const DistanceBracket& bracket)
{
	constexpr double kSlack = 1e-12;
	if (!(bracket.lower <= bracket.upper)) return false;
	if (std::abs(bruteDistance(bracket.at, to) - bracket.lower) > kSlack) return false;
	if (bracket.lower > 0 && bruteDistance(bracket.at, from) > kSlack) return false;
	std::mt19937 random(7);
	std::uniform_real_distribution<double> uniform(0, 1);
	for (std::size_t i = 0; i < from.triangles.size(); ++i)
		for (int k = 0; k < 8; ++k)
		{
			const builder::Triangle t = triangleOf(from, i);
			double u = uniform(random), v = uniform(random);
			if (u + v > 1) u = 1 - u, v = 1 - v;
			if (bruteDistance(t.a + u * (t.b - t.a) + v * (t.c - t.a), to) > bracket.upper + kSlack) return false;
		}
	return true;
}

Mesh moved(Mesh mesh, const Vec3& by)
{
	for (Vec3& v : mesh.vertices) v += by;
	return mesh;
}
}  // namespace

TEST(SurfaceDistance, OfConcentricBoxesIsThatOfTheCorners)
{
	const Mesh inner = boxMesh({0.5, 0.5, 0.5}, 4), outer = boxMesh({0.75, 0.75, 0.75}, 4);
	const DistanceBracket in = builder::directedDistance(inner, outer, 1e-9);
	const DistanceBracket out = builder::directedDistance(outer, inner, 1e-9);
	EXPECT_NEAR(in.lower, 0.25, 1e-12);
	EXPECT_NEAR(out.lower, 0.25 * std::sqrt(3.0), 1e-12);
	for (const DistanceBracket& b : {in, out}) EXPECT_LE(b.upper, 1.02 * b.lower);
	EXPECT_TRUE(holds(inner, outer, in));
	EXPECT_TRUE(holds(outer, inner, out));
}

TEST(SurfaceDistance, OfTheSameSurfaceIsZero)
{
	const Mesh torus = torusMesh(1, 0.4, 24, 12);
	EXPECT_LE(builder::directedDistance(torus, torus, 1e-9).upper, 1e-15);
	Mesh part = torus;
	part.triangles.resize(100);
	EXPECT_LE(builder::directedDistance(part, torus, 1e-9).upper, 1e-15);
	const DistanceBracket rest = builder::directedDistance(torus, part, 1e-9);
	EXPECT_GT(rest.lower, 0.5);
	EXPECT_TRUE(holds(torus, part, rest));
}

TEST(SurfaceDistance, HoldsOnSamplesOfMovedAndOtherSurfaces)
{
	const Mesh torus = torusMesh(1, 0.4, 24, 12), wrinkled = wrinkledTorusMesh(1, 0.35, 0.06, 6, 36, 14);
	for (const Mesh& other : {moved(torus, {0.1, 0.02, 0}), wrinkled, boxMesh({1, 0.3, 0.2}, 3)})
	{
		const DistanceBracket bracket = builder::directedDistance(torus, other, 1e-6);
		EXPECT_LE(bracket.upper, 1.02 * bracket.lower);
		EXPECT_TRUE(holds(torus, other, bracket));
	}
}

TEST(SurfaceDistance, OracleFindsPlantedFaults)
{
	const Mesh torus = torusMesh(1, 0.4, 24, 12), other = moved(torus, {0.1, 0.02, 0});
	const DistanceBracket good = builder::directedDistance(torus, other, 1e-6);
	DistanceBracket upperTooSmall = good, lowerTooLarge = good, elsewhere = good;
	upperTooSmall.upper = upperTooSmall.lower = 0.9 * good.lower;
	lowerTooLarge.lower = lowerTooLarge.upper = 1.1 * good.upper;
	elsewhere.at += Vec3{0, 0.01, 0};
	EXPECT_FALSE(holds(torus, other, upperTooSmall));
	EXPECT_FALSE(holds(torus, other, lowerTooLarge));
	EXPECT_FALSE(holds(torus, other, elsewhere));
}

TEST(SurfaceDistance, OfNothingIsZeroAndToNothingInfinite)
{
	const Mesh torus = torusMesh(1, 0.4, 24, 12);
	EXPECT_EQ(builder::directedDistance({}, torus, 1e-9).upper, 0);
	EXPECT_TRUE(std::isinf(builder::directedDistance(torus, {}, 1e-9).lower));
}
}  // namespace clod::test
