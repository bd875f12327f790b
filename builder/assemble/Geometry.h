// SPDX-License-Identifier: GPL-3.0-or-later
// Points, triangles and boxes: what every step of the assembly shares.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "builder/ClosestPoint.h"

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

inline ClosestPoint closestPoint(const Vec3& p, const Triangle& t)
{
	return closestPoint(p, t.a, t.b, t.c);
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
