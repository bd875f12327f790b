// SPDX-License-Identifier: GPL-3.0-or-later
// The search for the deepest point, below a roof whose depth has a closed form; and what it says when its cells run
// out.
#include "clod/distance/DepthSearch.h"

#include <gtest/gtest.h>

#include <cmath>

namespace
{
using namespace clod;

// Two planes that fall off from a ridge along y, at z = 0; inside is below both.
struct Roof
{
	static constexpr double kSlope = 0.3;

	static double below(const Vec3& p, int face)
	{
		return -((face == 0 ? p.x : -p.x) * std::sin(kSlope) + p.z * std::cos(kSlope));
	}
	static DepthSample sample(std::uint32_t, const Vec3& p, std::uint32_t)
	{
		const int face = below(p, 0) <= below(p, 1) ? 0 : 1;
		return {below(p, face), std::abs(below(p, face)), std::uint32_t(face)};
	}
	static Triangle triangle(std::uint32_t face)
	{
		const double side = face == 0 ? 100 : -100;
		return {{{0, -side, 0}, {0, side, 0}, {side, 0, -100 * std::tan(kSlope)}}};
	}
	static bool crossesNothing(std::uint32_t, const Triangle&) { return false; }
	static double below(std::uint32_t, const Triangle&) { return std::numeric_limits<double>::infinity(); }
	static std::uint32_t across(std::uint32_t face, int edge) { return edge == 0 ? 1 - face : kNone; }
};

// Of a triangle that is 0.1 below the ridge.
DepthBound deepest(const DepthAccuracy& accuracy)
{
	std::vector<DepthCell> heap;
	Roof roof;
	DepthSearch<Roof> search(roof, accuracy, heap);
	const Triangle flat{{{-1, -0.7, -0.1}, {1.3, -0.2, -0.1}, {0.2, 1.1, -0.1}}};
	DepthSample corner[3];
	for (int i = 0; i < 3; ++i) corner[i] = search.sample(0, flat[i], kNone);
	search.add(0, flat, corner[0], corner[1], corner[2]);
	return search.run();
}

TEST(DepthSearch, FindsTheDepthBelowARoof)
{
	DepthAccuracy accuracy;
	accuracy.absolute = 1e-6;
	accuracy.relative = 0;
	const DepthBound bound = deepest(accuracy);
	const double truth = 0.1 * std::cos(Roof::kSlope);
	EXPECT_LE(bound.lower, truth * (1 + 1e-12));
	EXPECT_GE(bound.upper, truth * (1 - 1e-12));
	EXPECT_LE(bound.upper - bound.lower, 1e-6);
	EXPECT_FALSE(bound.isCutShort);
}

TEST(DepthSearch, SaysWhenItsCellsRunOut)
{
	DepthAccuracy accuracy;
	accuracy.absolute = 1e-6;
	accuracy.relative = 0;
	accuracy.cellLimit = 3;
	const DepthBound bound = deepest(accuracy);
	const double truth = 0.1 * std::cos(Roof::kSlope);
	EXPECT_TRUE(bound.isCutShort);
	EXPECT_LE(bound.lower, truth * (1 + 1e-12));
	EXPECT_GE(bound.upper, truth * (1 - 1e-12));
	EXPECT_GT(bound.upper - bound.lower, 1e-6);
}
}  // namespace
