// SPDX-License-Identifier: Zlib
// A triangle in space, and its point nearest to another.
//
// Based on: Ericson, Real-Time Collision Detection, sec. 5.1.5.
#pragma once
#include <array>

#include "clod/collide/Vector.h"

namespace clod
{
using Triangle = std::array<Vec3, 3>;

struct NearestOnTriangle
{
	Vec3 point;
	double squared;  // squared distance
	int feature;     // 0-2: corner i; 3-5: edge from corner i-3 to the next; 6: interior
};
// Of a triangle without area, or with so little that rounding hides it, the nearest of its edges.
NearestOnTriangle nearestOnTriangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& from);
inline NearestOnTriangle nearestOnTriangle(const Triangle& triangle, const Vec3& from)
{
	return nearestOnTriangle(triangle[0], triangle[1], triangle[2], from);
}
}  // namespace clod
