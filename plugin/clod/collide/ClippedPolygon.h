// SPDX-License-Identifier: Zlib
// What planes leave of a triangle.
//
// Clipping after Sutherland and Hodgman 1974. A plane that cuts a convex polygon takes one corner at least and adds
// two: a triangle cut by n planes has at most 3 + n corners.
#pragma once
#include "clod/collide/Triangle.h"

namespace clod
{
struct ClippedPolygon
{
	static constexpr int kMost = 8;  // five planes
	ClippedPolygon() = default;
	explicit ClippedPolygon(const Triangle& triangle) : count(3)
	{
		for (std::size_t i = 0; i < 3; ++i) vertex[i] = triangle[i];
	}

	std::array<Vec3, kMost> vertex;
	int count = 0;
};

// Keeps the part of the polygon with dot(normal, p) <= offset. Precondition: it is of a triangle and no more than four
// planes. Where rounding hides which corners are beyond, as they lie in the plane or in one line, the polygon stays
// whole: it is beyond by rounding only.
inline void clipByPlane(ClippedPolygon& polygon, const Vec3& normal, double offset)
{
	double height[ClippedPolygon::kMost];
	unsigned beyond = 0;  // a bit a corner
	for (int i = 0; i < polygon.count; ++i)
	{
		height[i] = dot(normal, polygon.vertex[std::size_t(i)]) - offset;
		beyond |= unsigned(height[i] > 0) << i;
	}
	if (beyond == 0) return;
	// Two edges of a convex polygon cross the plane, or none; a bit is left where more do.
	const unsigned crossing = beyond ^ ((beyond >> 1) | ((beyond & 1) << (polygon.count - 1)));
	const unsigned butOne = crossing & (crossing - 1);
	if ((butOne & (butOne - 1)) != 0) return;
	const ClippedPolygon whole = polygon;
	polygon.count = 0;
	const auto push = [&polygon](const Vec3& v) { polygon.vertex[std::size_t(polygon.count++)] = v; };
	for (int i = 0; i < whole.count; ++i)
	{
		const int next = i + 1 == whole.count ? 0 : i + 1;
		const Vec3 &p = whole.vertex[std::size_t(i)], &q = whole.vertex[std::size_t(next)];
		const double heightP = height[i], heightQ = height[next];
		if (heightP <= 0) push(p);
		if ((heightP < 0 && heightQ > 0) || (heightP > 0 && heightQ < 0))
			push(p + (heightP / (heightP - heightQ)) * (q - p));
	}
}
}  // namespace clod
