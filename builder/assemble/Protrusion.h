// SPDX-License-Identifier: GPL-3.0-or-later
// How far a convex body reaches out of the input solid: a certified upper bound of sup over the body of the distance to
// the solid, 0 inside.
//
// Proof by displacement: if an affine map phi moves no point of the body K by more than e, and phi(K) lies in the
// solid, then every point of K is within e of the solid. phi(K) lies in the solid when one of its points does and no
// input triangle meets its interior. Where no such map is found the body is cut into tetrahedra with maps of their own
// (branch and bound); what the budget leaves is bounded by the 1-Lipschitz signed distance.
#pragma once
#include <vector>

#include "builder/assemble/TriangleTree.h"

namespace clod::builder
{
struct ConvexBody
{
	std::vector<Vec3> points;       // K is their hull
	std::vector<Vec3> realNormals;  // of the faces that lie near the surface; guide the search, prove nothing
};

struct ProtrusionScale
{
	double radius;      // of the whole object
	double rounding;    // below this nothing is measured: the answer is at least that
	int budget;         // cells that may be cut
	double enough = 0;  // an upper bound this low is not made tighter
};

struct Protrusion
{
	double lower = 0;  // attained at a point that was looked at
	double upper = 0;
};

// Gives up as soon as more than `hopeless` is attained: lower then exceeds it.
Protrusion protrusion(const Solid& solid, const ConvexBody& body, const ProtrusionScale& scale,
					  double hopeless = std::numeric_limits<double>::infinity());
}  // namespace clod::builder
