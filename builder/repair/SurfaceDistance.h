// SPDX-License-Identifier: GPL-3.0-or-later
// How far two surfaces are apart, as a certified bracket: neither needs to be closed, oriented or manifold.
//
// Directed distance of A to B: sup over the points of A of the distance to B. Branch and bound over pieces of A's
// triangles. A piece is bounded from above by the largest distance of its corners to one and the same triangle of B
// (the distance to a convex set is convex, so its maximum over a triangle is at a corner), from below by the distance
// of its corners to all of B (as Tang, Lee, Kim 2009 and CGAL's bounded_error_Hausdorff_distance, which needs
// manifolds).
#pragma once
#include "builder/Lod.h"

namespace clod::builder
{
struct DistanceBracket
{
	double lower = 0, upper = 0;  // lower <= directed distance <= upper
	Vec3 at;                      // a point of A whose distance to B is `lower`
};

// Cost: about 5 nearest-triangle look-ups a triangle of `from` where the surfaces agree, more where they do not. Stops
// at upper <= max(1.02 lower, rounding), or after 300,000 further pieces with a wider bracket (pieces across an edge of
// B are cut down to `rounding`). An empty `from` gives zeros, an empty `to` infinity.
DistanceBracket directedDistance(const Mesh& from, const Mesh& to, double rounding);
}  // namespace clod::builder
