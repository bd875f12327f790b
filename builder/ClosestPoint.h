// SPDX-License-Identifier: GPL-3.0-or-later
// The point of a triangle nearest to another, once for the builder and for its checker: of a sheet's rims, slivers, it
// tells which side a point is on, where a wall starts and how far a hull stands out, which both must see alike.
//
// Based on: Ericson, Real-Time Collision Detection, 2005, sec. 5.1.5. Departs from it for slivers, whose width is lost
// in the products of products that weigh the regions.
#pragma once
#include <array>
#include <cmath>
#include <limits>

#include "clod/collide/Vector.h"

namespace clod::builder
{
// Which part of a triangle a closest point lies on.
enum class Feature
{
	vertexA,
	vertexB,
	vertexC,
	edgeAB,
	edgeBC,
	edgeCA,
	face
};

struct ClosestPoint
{
	Vec3 point;
	Feature feature = Feature::face;
};

// a b - c d to two roundings (Kahan): nothing is lost where the products are nearly the same.
inline double differenceOfProducts(double a, double b, double c, double d)
{
	const double product = c * d;
	return std::fma(a, b, -product) + std::fma(-c, d, product);
}
inline Vec3 accurateCross(const Vec3& a, const Vec3& b)
{
	return {differenceOfProducts(a.y, b.z, a.z, b.y), differenceOfProducts(a.z, b.x, a.x, b.z),
			differenceOfProducts(a.x, b.y, a.y, b.x)};
}

// However thin the triangle: on the nearest of its sides, or under the point where that is over it.
inline ClosestPoint closestOnSliver(const Vec3& p, const std::array<Vec3, 3>& corners)
{
	const Vec3 normal = accurateCross(corners[1] - corners[0], corners[2] - corners[0]);
	ClosestPoint best;
	double least = std::numeric_limits<double>::infinity();
	bool isOver = true;
	for (int i = 0; i < 3; ++i)
	{
		const int next = (i + 1) % 3;
		const Vec3 &from = corners[std::size_t(i)], &to = corners[std::size_t(next)];
		const Vec3 side = to - from, offset = p - from;
		const double along = dot(offset, side), whole = lengthSquared(side);
		isOver = isOver && dot(accurateCross(side, offset), normal) > 0;
		ClosestPoint here{from, Feature(i)};
		if (along > 0) here = {to, Feature(next)};
		if (along > 0 && along < whole) here = {from + (along / whole) * side, Feature(3 + i)};
		const double squared = lengthSquared(p - here.point);
		if (squared >= least) continue;
		least = squared;
		best = here;
	}
	if (!isOver) return best;
	const Vec3 under = p - (dot(normal, p - best.point) / lengthSquared(normal)) * normal;
	return lengthSquared(p - under) < least ? ClosestPoint{under, Feature::face} : best;
}

inline ClosestPoint closestPoint(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c)
{
	constexpr double kSliver = 1e-3;  // height over length, to whose square products of products are lost
	const Vec3 ab = b - a, ac = c - a, ap = p - a;
	const double d1 = dot(ab, ap), d2 = dot(ac, ap);
	if (d1 <= 0 && d2 <= 0) return {a, Feature::vertexA};
	const Vec3 bp = p - b;
	const double d3 = dot(ab, bp), d4 = dot(ac, bp);
	if (d3 >= 0 && d4 <= d3) return {b, Feature::vertexB};
	const double longest = std::fmax(lengthSquared(ab), lengthSquared(ac));
	if (lengthSquared(cross(ab, ac)) < kSliver * kSliver * longest * longest) return closestOnSliver(p, {a, b, c});
	const double vc = d1 * d4 - d3 * d2;
	if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + (d1 - d3 > 0 ? d1 / (d1 - d3) : 0) * ab, Feature::edgeAB};
	const Vec3 cp = p - c;
	const double d5 = dot(ab, cp), d6 = dot(ac, cp);
	if (d6 >= 0 && d5 <= d6) return {c, Feature::vertexC};
	const double vb = d5 * d2 - d1 * d6;
	if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + (d2 - d6 > 0 ? d2 / (d2 - d6) : 0) * ac, Feature::edgeCA};
	const double va = d3 * d6 - d5 * d4, along = (d4 - d3) + (d5 - d6);
	if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
		return {b + (along > 0 ? (d4 - d3) / along : 0) * (c - b), Feature::edgeBC};
	const double scale = 1 / (va + vb + vc);
	return {a + (vb * scale) * ab + (vc * scale) * ac, Feature::face};
}
}  // namespace clod::builder
