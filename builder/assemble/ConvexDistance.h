// SPDX-License-Identifier: GPL-3.0-or-later
// Distance from a point to a contact hull: hull(vertices) (+) segment [0, sweep]. Every answer carries its own proof:
// it is the length of the difference to a convex combination of the hull's points, hence an upper bound.
#pragma once
#include <cstddef>

#include "clod/collide/Vector.h"

namespace clod::builder
{
struct ConvexSet
{
	const Vec3* vertices = nullptr;
	std::size_t count = 0;
	Vec3 sweep;

	Vec3 support(const Vec3& direction) const;
};

// Upper bound, within a relative 1e-3 of the distance or 1e-12 of the set's size. Stops early once it proves a distance
// of at most `enough` (and then returns a value that is at most `enough`).
double distanceBound(const Vec3& p, const ConvexSet& set, double enough = 0);
}  // namespace clod::builder
