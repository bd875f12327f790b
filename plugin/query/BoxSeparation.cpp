// SPDX-License-Identifier: Zlib
// Separating axes of two oriented boxes, rounded against the float rounding of their axes.
#include "clod/query/BoxSeparation.h"

#include <algorithm>

namespace clod
{
namespace
{
// The stored axes are orthonormal to float rounding; every projection is off by at most this share of the sizes.
constexpr double kAxisRounding = 6e-7;

Vec3 rowOf(const CullBox& box, int i)
{
	return {double(box.axis[i][0]), double(box.axis[i][1]), double(box.axis[i][2])};
}
Vec3 centerOf(const CullBox& box)
{
	return {double(box.center[0]), double(box.center[1]), double(box.center[2])};
}
}  // namespace

PlacedBox placeInA(const CullBox& box)
{
	return {centerOf(box),
			{rowOf(box, 0), rowOf(box, 1), rowOf(box, 2)},
			{double(box.half[0]), double(box.half[1]), double(box.half[2])},
			double(box.radius)};
}

PlacedBox placeInA(const CullBox& box, const RelativePose& pose)
{
	return {pose.apply(centerOf(box)),
			{pose.rotation * rowOf(box, 0), pose.rotation * rowOf(box, 1), pose.rotation * rowOf(box, 2)},
			{double(box.half[0]), double(box.half[1]), double(box.half[2])},
			double(box.radius)};
}

double boxSeparation(const PlacedBox& a, const PlacedBox& b)
{
	const Vec3 between = b.center - a.center;
	const double distance = length(between);
	double best = distance - a.radius - b.radius;
	double reachA[3] = {0, 0, 0};  // of box a along the axes of b
	for (int i = 0; i < 3; ++i)
	{
		double reachB = 0;
		for (int j = 0; j < 3; ++j)
		{
			const double cosine = std::abs(dot(a.axis[i], b.axis[j]));
			reachB += cosine * b.half[j];
			reachA[j] += cosine * a.half[i];
		}
		best = std::max(best, std::abs(dot(between, a.axis[i])) - a.half[i] - reachB);
	}
	for (int j = 0; j < 3; ++j) best = std::max(best, std::abs(dot(between, b.axis[j])) - b.half[j] - reachA[j]);
	return best - kAxisRounding * (a.radius + b.radius + distance);
}

double boxDistance(const PlacedBox& box, const Vec3& point)
{
	const Vec3 offset = point - box.center;
	double squared = 0;
	for (int i = 0; i < 3; ++i)
	{
		const double beyond = std::max(0.0, std::abs(dot(offset, box.axis[i])) - box.half[i]);
		squared += beyond * beyond;
	}
	const double distance = length(offset);
	const double best = std::max(std::sqrt(squared), distance - box.radius);
	return std::max(0.0, best - kAxisRounding * (box.radius + distance));
}
}  // namespace clod
