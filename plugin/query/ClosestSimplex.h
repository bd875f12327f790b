// SPDX-License-Identifier: Zlib
// The point of a simplex nearest to the origin: the inner step of GJK.
//
// Every decision is a comparison of products of the same dimension, so the result does not depend on the unit. The
// vector to a triangle is taken along its normal, not as a combination of its corners: the direction then keeps its
// accuracy when the triangle is long and thin and the origin close to it, and with it the lower bound GJK certifies.
//
// Based on: Ericson, Real-Time Collision Detection, sec. 5.1 and 9.5; Montanari et al., "Improving the GJK algorithm
// for faster and more reliable distance queries", 2017 (signed volumes).
#pragma once
#include "clod/hierarchy/Vector.h"

namespace clod
{
struct SimplexPoint
{
	Vec3 nearest;           // of the simplex to the origin
	double weight[4] = {};  // nearest = sum of weight * corner; all >= 0, sum 1
	double squared = 0;     // squared length of nearest
	bool inside = false;    // a tetrahedron that encloses the origin; nearest is then the rounding residual
};

// Nearest point of the hull of corner[0 .. count-1], 1 <= count <= 4, to the origin.
SimplexPoint closestToOrigin(const Vec3* corner, int count);
}  // namespace clod
