// SPDX-License-Identifier: GPL-3.0-or-later
// The exact sign of the volume of a tetrahedron, and planes of triangles.
// Source: J. R. Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates, 1997.
#pragma once
#include "clod/collide/Vector.h"

namespace clod::builder
{
// +1 where d lies above the plane of the triangle a, b, c (counter-clockwise seen from d), -1 below, 0 exactly on it.
// Exact for every finite input without underflow: a filter in double first, expansions where it cannot decide.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

// Points with dot(normal, x) = offset; the normal has length 1, or 0 where the triangle has no area.
struct Plane
{
	Vec3 normal;
	double offset = 0;
	double height(const Vec3& x) const { return dot(normal, x) - offset; }
};

inline Plane planeOf(const Vec3& a, const Vec3& b, const Vec3& c)
{
	const Vec3 n = normalized(cross(b - a, c - a));
	return {n, dot(n, (1.0 / 3) * (a + b + c))};
}

// The coordinates as a file will store them.
inline Vec3 roundedToFloat(const Vec3& v)
{
	return toVec3(toFloat3(v));
}
}  // namespace clod::builder
