// SPDX-License-Identifier: GPL-3.0-or-later
// Distances, hulls and a box tree of the checker's own.
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include <clod/hierarchy/Layout.h>

#include "builder/ClosestPoint.h"

namespace clod::check
{
using Triangle = std::array<Vec3, 3>;

inline Vec3 nearestOn(const Triangle& t, const Vec3& p)
{
	return builder::closestPoint(p, t[0], t[1], t[2]).point;
}
inline double distance(const Triangle& t, const Vec3& p)
{
	return length(nearestOn(t, p) - p);
}

// Distance from p to the hull of the points: that of a convex combination which is found by Wolfe's nearest point
// algorithm, hence an upper bound; at most `tolerance` above the truth. Stops early once it is at most `enough`.
double distanceToHull(const std::vector<Vec3>& points, const Vec3& p, double tolerance, double enough);

// What of a convex polygon lies at most `offset` along the normal, of any length.
void keepBelow(std::vector<Vec3>& polygon, const Vec3& normal, double offset);

struct Plane
{
	Vec3 normal;  // unit, outward
	double offset;
};
// The hull of points as CGAL finds it (exact predicates). Facets lower than `least` are left out, as their planes mean
// nothing.
struct Hull
{
	bool solid = false;            // false: all points are coplanar
	std::vector<Triangle> facets;  // counter-clockwise from outside
	std::vector<Plane> planes;
};
Hull hullOf(const std::vector<Vec3>& points, double least);

// Whether something of the triangle lies deeper than `depth` under every plane.
bool enters(const Triangle& t, const std::vector<Plane>& planes, double depth);

struct Box
{
	Vec3 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
			 std::numeric_limits<double>::infinity()};
	Vec3 high = -low;
	void add(const Vec3& p);
	void grow(double by);
	bool overlaps(const Box& other) const;
	double distance(const Vec3& p) const;
};
Box boxOf(const std::vector<Vec3>& points);

// Triangles in a balanced tree of boxes; read-only after construction.
class TriangleTree
{
public:
	explicit TriangleTree(std::vector<Triangle> triangles);
	const std::vector<Triangle>& triangles() const { return m_triangles; }
	std::vector<std::uint32_t> overlapping(const Box& box) const;  // ascending
	struct Nearest
	{
		double distance;
		std::uint32_t triangle;
	};
	// Among triangles nearer than `limit`; the distance is `limit` where there is none.
	Nearest nearest(const Vec3& p, double limit = std::numeric_limits<double>::infinity()) const;

private:
	struct Cell
	{
		Box box;
		std::uint32_t begin, end;  // into m_order
		std::uint32_t right;       // second child; the first follows; 0 in leaves
	};
	std::uint32_t build(std::uint32_t begin, std::uint32_t end);
	std::vector<Triangle> m_triangles;
	std::vector<std::uint32_t> m_order;
	std::vector<Cell> m_cells;
};
}  // namespace clod::check
