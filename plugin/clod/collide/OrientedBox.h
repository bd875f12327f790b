// SPDX-License-Identifier: Zlib
// An oriented box and the sphere round its centre that encloses the same things, as files store it.
#pragma once
#include "clod/collide/Vector.h"

namespace clod
{
struct OrientedBox
{
	float center[3];
	float radius;      // of the sphere
	float axis[3][3];  // orthonormal rows to kAxisTolerance; the box is { c + sum_i t_i axis[i], |t_i| <= half[i] } with
	float half[3];     // half enlarged for the rounding of the axes
};
static_assert(sizeof(OrientedBox) == 64);
// Of the axes' squared lengths and of their products. Rounding unit vectors to float takes 1.1e-7.
inline constexpr double kAxisTolerance = 1.5e-7;

inline Vec3 centerOf(const OrientedBox& box)
{
	return toVec3(box.center);
}
}  // namespace clod
