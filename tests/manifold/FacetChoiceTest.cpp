// SPDX-License-Identifier: GPL-3.0-or-later
// Which facets count where bodies overlap.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/manifold/FacetPair.h"

namespace clod::test
{
// Edge on edge, all but parallel: B's end is beyond A's edge, so that the farther side's face is over it, too, deeper
// than the way out that the edges ask for, which leaves nothing of it.
TEST(FacetChoice, WhatTheWayOutLeavesApartIsNoContact)
{
	const double c = std::sqrt(0.5), turn = 0.0152, sunk = 0.0032, beyond = 0.195;
	const Vec3 up{c, c, 0}, aside{c, -c, 0}, along{0, 0, 1};
	const HierarchyPointer cube = cubeOf(1);
	for (const double side : {-1.0, 1.0})
		for (const double way : {-0.0128, 0.0, 0.0128})
		{
			// About `up`, through the middle of A's edge; B's edge ends so far from there on the one hand.
			const double w = side * turn, k = 1 - std::cos(w), s = std::sin(w);
			const Mat3 turned{
				{{1 - 0.5 * k, 0.5 * k, c * s}, {0.5 * k, 1 - 0.5 * k, -c * s}, {-c * s, c * s, 1 - k}}};
			const Vec3 place = (2 * c - sunk) * up - (0.5 - beyond) * (turned * along);
			FacetPair pair(cube, cube, at(place, turned));
			pair.move(way * aside);
			double deepest = 0;
			for (const ContactPoint& point : pair.points()) deepest = std::min(deepest, point.height);
			EXPECT_LT(deepest, -0.99 * sunk) << side << " " << way;
			EXPECT_GT(deepest, -1.01 * sunk) << side << " " << way;
		}
}
}  // namespace clod::test
