// SPDX-License-Identifier: Zlib
#include "clod/collide/Triangle.h"

#include <limits>

#include "clod/collide/Constants.h"

namespace clod
{
namespace
{
NearestOnTriangle nearestFeature(const Vec3& from, const Vec3& point, int feature)
{
	return {point, lengthSquared(from - point), feature};
}

// Of a triangle whose area is lost in rounding.
NearestOnTriangle nearestOnEdges(const Triangle& triangle, const Vec3& from)
{
	NearestOnTriangle best{Vec3{}, std::numeric_limits<double>::infinity(), 0};
	for (int i = 0; i < 3; ++i)
	{
		const Vec3 &corner = triangle[i], edge = triangle[(i + 1) % 3] - corner;
		const double along = dot(from - corner, edge), squared = lengthSquared(edge);
		const bool isInner = along > 0 && along < squared;
		const NearestOnTriangle here =
			nearestFeature(from, isInner ? corner + (along / squared) * edge : corner, isInner ? 3 + i : i);
		if (here.squared < best.squared) best = here;
	}
	return best;
}
}  // namespace

NearestOnTriangle nearestOnTriangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& from)
{
	const Vec3 ab = b - a, ac = c - a, ap = from - a;
	const double d1 = dot(ab, ap), d2 = dot(ac, ap);
	if (d1 <= 0 && d2 <= 0) return nearestFeature(from, a, 0);
	const Vec3 bp = from - b;
	const double d3 = dot(ab, bp), d4 = dot(ac, bp);
	if (d3 >= 0 && d4 <= d3) return nearestFeature(from, b, 1);
	const double ofC = d1 * d4 - d3 * d2;
	if (ofC <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return nearestFeature(from, a + (d1 / (d1 - d3)) * ab, 3);
	const Vec3 cp = from - c;
	const double d5 = dot(ab, cp), d6 = dot(ac, cp);
	if (d6 >= 0 && d5 <= d6) return nearestFeature(from, c, 2);
	const double ofB = d5 * d2 - d1 * d6;
	if (ofB <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return nearestFeature(from, a + (d2 / (d2 - d6)) * ac, 5);
	const double ofA = d3 * d6 - d5 * d4;
	if (ofA <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0 && (d4 - d3) + (d5 - d6) > 0)
		return nearestFeature(from, b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b), 4);
	const double sum = ofA + ofB + ofC;
	if (!(sum > kNoArea * (d1 - d3) * (d2 - d6))) return nearestOnEdges({a, b, c}, from);
	const double scale = 1 / sum;
	return nearestFeature(from, a + (ofB * scale) * ab + (ofC * scale) * ac, 6);
}
}  // namespace clod
