// SPDX-License-Identifier: GPL-3.0-or-later
// Points, triangles and boxes: what every step of the assembly shares.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "clod/collide/Vector.h"

namespace clod::builder
{
struct Triangle
{
	Vec3 a, b, c;
	const Vec3& operator[](int i) const { return i == 0 ? a : i == 1 ? b : c; }
};

inline Vec3 centroid(const Triangle& t)
{
	return (1.0 / 3) * (t.a + t.b + t.c);
}
inline Vec3 areaVector(const Triangle& t)
{
	return 0.5 * cross(t.b - t.a, t.c - t.a);
}

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

// Ericson, Real-Time Collision Detection, 2005, sec. 5.1.5.
inline ClosestPoint closestPoint(const Vec3& p, const Triangle& t)
{
	const Vec3 ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a;
	const double d1 = dot(ab, ap), d2 = dot(ac, ap);
	if (d1 <= 0 && d2 <= 0) return {t.a, Feature::vertexA};
	const Vec3 bp = p - t.b;
	const double d3 = dot(ab, bp), d4 = dot(ac, bp);
	if (d3 >= 0 && d4 <= d3) return {t.b, Feature::vertexB};
	const double vc = d1 * d4 - d3 * d2;
	if (vc <= 0 && d1 >= 0 && d3 <= 0) return {t.a + (d1 - d3 > 0 ? d1 / (d1 - d3) : 0) * ab, Feature::edgeAB};
	const Vec3 cp = p - t.c;
	const double d5 = dot(ab, cp), d6 = dot(ac, cp);
	if (d6 >= 0 && d5 <= d6) return {t.c, Feature::vertexC};
	const double vb = d5 * d2 - d1 * d6;
	if (vb <= 0 && d2 >= 0 && d6 <= 0) return {t.a + (d2 - d6 > 0 ? d2 / (d2 - d6) : 0) * ac, Feature::edgeCA};
	const double va = d3 * d6 - d5 * d4, along = (d4 - d3) + (d5 - d6);
	if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
		return {t.b + (along > 0 ? (d4 - d3) / along : 0) * (t.c - t.b), Feature::edgeBC};
	const double scale = 1 / (va + vb + vc);
	return {t.a + (vb * scale) * ab + (vc * scale) * ac, Feature::face};
}

inline double distanceSquared(const Vec3& p, const Triangle& t)
{
	return lengthSquared(p - closestPoint(p, t).point);
}

struct AxisBox
{
	Vec3 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
			 std::numeric_limits<double>::infinity()};
	Vec3 high = -low;
	void add(const Vec3& p)
	{
		for (int i = 0; i < 3; ++i)
		{
			low[i] = std::min(low[i], p[i]);
			high[i] = std::max(high[i], p[i]);
		}
	}
	void add(const AxisBox& b)
	{
		add(b.low);
		add(b.high);
	}
	Vec3 extent() const { return high - low; }
};

inline AxisBox boxOf(const Triangle& t)
{
	AxisBox box;
	for (int i = 0; i < 3; ++i) box.add(t[i]);
	return box;
}

// A ball that holds a triangle, to pass over those too far away.
struct Ball
{
	Vec3 middle;
	double radius = 0;
	bool isBeyond(const Vec3& p, double distance) const
	{
		return lengthSquared(p - middle) > (distance + radius) * (distance + radius);
	}
};
inline Ball ballRound(const Triangle& t)
{
	const Vec3 middle = centroid(t);
	const double squared =
		std::max({lengthSquared(t.a - middle), lengthSquared(t.b - middle), lengthSquared(t.c - middle)});
	return {middle, std::sqrt(squared) * (1 + 1e-9)};
}

inline bool overlaps(const AxisBox& a, const AxisBox& b)
{
	for (int i = 0; i < 3; ++i)
		if (a.low[i] > b.high[i] || b.low[i] > a.high[i]) return false;
	return true;
}

inline double distanceSquared(const Vec3& p, const AxisBox& b)
{
	double sum = 0;
	for (int i = 0; i < 3; ++i)
	{
		const double d = std::max(std::max(b.low[i] - p[i], p[i] - b.high[i]), 0.0);
		sum += d * d;
	}
	return sum;
}
}  // namespace clod::builder
