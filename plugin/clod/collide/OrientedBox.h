// SPDX-License-Identifier: Zlib
// An oriented box and the sphere round its centre that encloses the same things, as files store it.
#pragma once
#include <algorithm>

#include "clod/collide/Vector.h"

namespace clod
{
struct OrientedBox
{
	float center[3];
	float radius;      // of the sphere
	float axis[3][3];  // orthonormal rows to kAxisTolerance; the box is { c + sum_i t_i axis[i], |t_i| <= half[i] },
	float half[3];     // with half enlarged for the rounding of the axes
};
static_assert(sizeof(OrientedBox) == 64);
// Of the axes' squared lengths and of their products. Rounding unit vectors to float takes 1.1e-7.
inline constexpr double kAxisTolerance = 1.5e-7;

inline namespace CLOD_ARITHMETIC
{
inline Vec3 centerOf(const OrientedBox& box)
{
	return toVec3(box.center);
}

// Does a segment miss the box grown by an axis-aligned one of half size `grown`? Slab by slab in the box's own axes;
// rounded to the side of no.
inline bool misses(const OrientedBox& box, const Vec3& grown, const Vec3& from, const Vec3& to)
{
	double enter = 0, leave = 1;
	const Vec3 start = from - toVec3(box.center), path = to - from;
	for (int i = 0; i < 3; ++i)
	{
		const Vec3 axis = toVec3(box.axis[i]);
		const double at = dot(axis, start), along = dot(axis, path);
		const double reach = std::abs(axis.x) * grown.x + std::abs(axis.y) * grown.y + std::abs(axis.z) * grown.z;
		const double half = (double(box.half[i]) + reach) * (1 + 1e-6) + 1e-6 * (std::abs(at) + std::abs(along));
		if (along == 0)
		{
			if (std::abs(at) > half) return true;
			continue;
		}
		const double first = (-half - at) / along, second = (half - at) / along;
		enter = std::max(enter, std::min(first, second));
		leave = std::min(leave, std::max(first, second));
		if (enter > leave) return true;
	}
	return false;
}
}  // namespace CLOD_ARITHMETIC
}  // namespace clod
