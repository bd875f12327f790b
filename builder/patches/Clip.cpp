// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: see Clip.h.
#include "builder/patches/Clip.h"

#include <algorithm>

namespace clod::builder
{
namespace
{
// Whether the open segment p, q passes through the triangle, judged by exact signs; touching counts.
bool segmentCrosses(const Vec3& p, const Vec3& q, const TrianglePoints& t)
{
	const int sideP = orientation(t[0], t[1], t[2], p), sideQ = orientation(t[0], t[1], t[2], q);
	if (sideP * sideQ > 0 || (sideP == 0 && sideQ == 0)) return false;
	const int a = orientation(p, q, t[0], t[1]);
	const int b = orientation(p, q, t[1], t[2]);
	const int c = orientation(p, q, t[2], t[0]);
	return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

bool isVertexOf(const Vec3& p, const TrianglePoints& t)
{
	return p == t[0] || p == t[1] || p == t[2];
}

bool edgesCross(const TrianglePoints& a, const TrianglePoints& b)
{
	for (int i = 0; i < 3; ++i)
	{
		const Vec3 &p = a[i], &q = a[(i + 1) % 3];
		if (isVertexOf(p, b) || isVertexOf(q, b)) continue;
		if (segmentCrosses(p, q, b)) return true;
	}
	return false;
}
}  // namespace

double cross2(const Point2& a, const Point2& b, const Point2& c)
{
	return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

void clipBelow(std::vector<Vec3>& polygon, const Plane& plane, double depth, std::vector<Vec3>& scratch)
{
	scratch.clear();
	for (std::size_t i = 0; i < polygon.size(); ++i)
	{
		const Vec3& p = polygon[i];
		const Vec3& q = polygon[i + 1 < polygon.size() ? i + 1 : 0];
		const double hp = plane.height(p) + depth, hq = plane.height(q) + depth;
		if (hp < 0) scratch.push_back(p);
		if ((hp < 0) != (hq < 0)) scratch.push_back(p + (hp / (hp - hq)) * (q - p));
	}
	polygon.swap(scratch);
}

bool entersHull(const TrianglePoints& triangle, const std::vector<Plane>& planes, double depth)
{
	static thread_local std::vector<const Plane*> crossing;
	static thread_local std::size_t last = 0;  // separated: neighbours mostly share it
	const auto isAbove = [&](const Plane& plane)
	{
		const double limit = plane.offset - depth;
		return dot(plane.normal, triangle[0]) >= limit && dot(plane.normal, triangle[1]) >= limit &&
			   dot(plane.normal, triangle[2]) >= limit;
	};
	if (last < planes.size() && isAbove(planes[last])) return false;
	crossing.clear();
	for (const Plane& plane : planes)
	{
		const double limit = plane.offset - depth;
		const bool in0 = dot(plane.normal, triangle[0]) < limit;
		const bool in1 = dot(plane.normal, triangle[1]) < limit;
		const bool in2 = dot(plane.normal, triangle[2]) < limit;
		if (!in0 && !in1 && !in2)
		{
			last = std::size_t(&plane - planes.data());
			return false;
		}
		if (!(in0 && in1 && in2)) crossing.push_back(&plane);
	}
	static thread_local std::vector<Vec3> polygon, scratch;
	polygon.assign(triangle.begin(), triangle.end());
	for (const Plane* plane : crossing)
	{
		clipBelow(polygon, *plane, depth, scratch);
		if (polygon.size() < 3) return false;
	}
	return true;
}

bool trianglesCross(const TrianglePoints& a, const TrianglePoints& b)
{
	return edgesCross(a, b) || edgesCross(b, a);
}

double squaredDistance(const Vec3& p, const TrianglePoints& t)
{
	const Vec3 ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
	const double d1 = dot(ab, ap), d2 = dot(ac, ap);
	if (d1 <= 0 && d2 <= 0) return lengthSquared(ap);
	const Vec3 bp = p - t[1];
	const double d3 = dot(ab, bp), d4 = dot(ac, bp);
	if (d3 >= 0 && d4 <= d3) return lengthSquared(bp);
	const double vc = d1 * d4 - d3 * d2;
	if (vc <= 0 && d1 >= 0 && d3 <= 0) return lengthSquared(ap - (d1 / (d1 - d3)) * ab);
	const Vec3 cp = p - t[2];
	const double d5 = dot(ab, cp), d6 = dot(ac, cp);
	if (d6 >= 0 && d5 <= d6) return lengthSquared(cp);
	const double vb = d5 * d2 - d1 * d6;
	if (vb <= 0 && d2 >= 0 && d6 <= 0) return lengthSquared(ap - (d2 / (d2 - d6)) * ac);
	const double va = d3 * d6 - d5 * d4;
	if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
		return lengthSquared(bp - ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (t[2] - t[1]));
	const double sum = va + vb + vc;
	return lengthSquared(ap - (vb / sum) * ab - (vc / sum) * ac);
}

std::vector<Point2> convexHull(std::vector<Point2> points)
{
	std::sort(points.begin(), points.end(),
			  [](const Point2& a, const Point2& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
	if (points.size() < 3) return points;
	std::vector<Point2> hull;
	for (int pass = 0; pass < 2; ++pass)
	{
		const std::size_t start = hull.size();
		for (const Point2& p : points)
		{
			while (hull.size() >= start + 2 && cross2(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
			hull.push_back(p);
		}
		hull.pop_back();
		std::reverse(points.begin(), points.end());
	}
	return hull;
}

double areaOf(const std::vector<Point2>& polygon)
{
	double twice = 0;
	for (std::size_t i = 2; i < polygon.size(); ++i) twice += cross2(polygon[0], polygon[i - 1], polygon[i]);
	return 0.5 * twice;
}

double perimeterOf(const std::vector<Point2>& polygon)
{
	double sum = 0;
	for (std::size_t i = 0; i < polygon.size(); ++i)
	{
		const Point2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
		sum += std::sqrt((b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y));
	}
	return sum;
}

std::vector<Point2> clipped(std::vector<Point2> polygon, const std::vector<Point2>& convex)
{
	static thread_local std::vector<Point2> result;
	static thread_local std::vector<double> height;
	for (std::size_t e = 0; e < convex.size() && !polygon.empty(); ++e)
	{
		const Point2 &a = convex[e], &b = convex[e + 1 < convex.size() ? e + 1 : 0];
		height.clear();
		for (const Point2& p : polygon) height.push_back(cross2(a, b, p));
		if (std::all_of(height.begin(), height.end(), [](double h) { return h >= 0; })) continue;
		result.clear();
		for (std::size_t i = 0; i < polygon.size(); ++i)
		{
			const std::size_t next = i + 1 < polygon.size() ? i + 1 : 0;
			const Point2 &p = polygon[i], &q = polygon[next];
			const double hp = height[i], hq = height[next];
			if (hp >= 0) result.push_back(p);
			if ((hp >= 0) != (hq >= 0))
				result.push_back({p.x + hp / (hp - hq) * (q.x - p.x), p.y + hp / (hp - hq) * (q.y - p.y)});
		}
		polygon.swap(result);
	}
	return polygon;
}
}  // namespace clod::builder
