// SPDX-License-Identifier: GPL-3.0-or-later
// A contact hull as an intersection of half-spaces, each of which contains every vertex as stored.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "builder/assemble/Geometry.h"

namespace clod::builder
{
struct HalfSpace
{
	Vec3 normal;    // unit, outward
	double offset;  // the hull lies in dot(normal, x) <= offset
};

struct HullShape
{
	std::vector<HalfSpace> planes;
	std::vector<Vec3> corners;  // the vertices that span the hull
	std::vector<std::array<std::uint32_t, 3>> facets;  // of corners
};

// The convex hull of points. A set without volume is first thickened by `minimum` along its thinnest direction (both
// ways), so the planes always bound a body.
HullShape hullShape(const std::vector<Vec3>& points, double minimum);
}  // namespace clod::builder
