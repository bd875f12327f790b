// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/check/Geometry.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <numeric>

namespace clod::check
{
namespace
{
// At most four points.
struct Simplex
{
	std::array<Vec3, 4> points;
	std::size_t size = 0;
	Simplex() = default;
	Simplex(std::initializer_list<Vec3> given) : size(given.size()) { std::copy(given.begin(), given.end(), points.begin()); }
	const Vec3& operator[](std::size_t i) const { return points[i]; }
};

// The point nearest to the origin on the hull of at most four points, and which of them carry it.
struct Carrier
{
	Simplex points;
	Vec3 nearest;
};

Vec3 nearestOnSegment(const Vec3& a, const Vec3& b)
{
	const Vec3 d = b - a;
	const double l = lengthSquared(d);
	return l > 0 ? a + std::clamp(-dot(a, d) / l, 0.0, 1.0) * d : a;
}

// Tries every face of the simplex; a tetrahedron that holds the origin gives zero.
Carrier reduce(const Simplex& points)
{
	Carrier best{{points[0]}, points[0]};
	const auto consider = [&](const Simplex& carrier, const Vec3& nearest)
	{
		if (lengthSquared(nearest) < lengthSquared(best.nearest)) best = {carrier, nearest};
	};
	for (std::size_t i = 0; i < points.size; ++i)
	{
		consider({points[i]}, points[i]);
		for (std::size_t j = i + 1; j < points.size; ++j)
		{
			consider({points[i], points[j]}, nearestOnSegment(points[i], points[j]));
			for (std::size_t k = j + 1; k < points.size; ++k)
				consider({points[i], points[j], points[k]}, nearestOn({points[i], points[j], points[k]}, Vec3{}));
		}
	}
	if (points.size < 4) return best;
	const double whole = dot(points[1] - points[0], cross(points[2] - points[0], points[3] - points[0]));
	bool inside = whole != 0;
	for (std::size_t i = 0; i < 4; ++i)
	{
		std::array<Vec3, 4> replaced = points.points;
		replaced[i] = Vec3{};
		const double part = dot(replaced[1] - replaced[0], cross(replaced[2] - replaced[0], replaced[3] - replaced[0]));
		if (part * whole < 0) inside = false;
	}
	return inside ? Carrier{points, Vec3{}} : best;
}

// Wolfe's algorithm from one of the points. Rounding may stop it on a sliver before it has converged.
struct HullDescent
{
	double upper;
	bool converged;
};
HullDescent descend(const std::vector<Vec3>& points, std::size_t start, const Vec3& p, double tolerance, double enough)
{
	constexpr int kMostSteps = 200;
	Carrier carrier{{points[start] - p}, points[start] - p};
	for (int step = 0; step < kMostSteps; ++step)
	{
		const Vec3& x = carrier.nearest;
		const double upper = length(x);
		if (upper <= enough || upper <= tolerance) return {upper, true};
		std::size_t support = 0;
		double least = std::numeric_limits<double>::infinity();
		for (std::size_t i = 0; i < points.size(); ++i)
		{
			const double along = dot(x, points[i] - p);
			if (along >= least) continue;
			least = along;
			support = i;
		}
		if (upper - least / upper <= tolerance) return {upper, true};
		Simplex simplex = carrier.points;
		if (simplex.size == 4) return {upper, false};
		simplex.points[simplex.size++] = points[support] - p;
		const Carrier next = reduce(simplex);
		if (lengthSquared(next.nearest) >= lengthSquared(x)) return {upper, false};
		carrier = next;
	}
	return {length(carrier.nearest), false};
}
}  // namespace

// Sutherland and Hodgman's clipping against one plane.
void keepBelow(std::vector<Vec3>& polygon, const Vec3& normal, double offset)
{
	const auto isAbove = [&](const Vec3& p) { return dot(normal, p) > offset; };
	if (std::none_of(polygon.begin(), polygon.end(), isAbove)) return;
	std::vector<Vec3> kept;
	kept.reserve(polygon.size() + 1);
	for (std::size_t i = 0; i < polygon.size(); ++i)
	{
		const Vec3& p = polygon[i];
		const Vec3& q = polygon[(i + 1) % polygon.size()];
		const double a = dot(normal, p) - offset, b = dot(normal, q) - offset;
		if (a <= 0) kept.push_back(p);
		if ((a < 0 && b > 0) || (a > 0 && b < 0)) kept.push_back(p + (a / (a - b)) * (q - p));
	}
	polygon = std::move(kept);
}

double distanceToHull(const std::vector<Vec3>& points, const Vec3& p, double tolerance, double enough)
{
	double best = std::numeric_limits<double>::infinity();
	for (std::size_t start = 0; start < points.size(); ++start)
	{
		const HullDescent descent = descend(points, start, p, tolerance, enough);
		best = std::min(best, descent.upper);
		if (descent.converged) break;
	}
	return best;
}

Hull hullOf(const std::vector<Vec3>& points, double least)
{
	using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
	using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
	std::vector<Kernel::Point_3> input;
	for (const Vec3& p : points) input.emplace_back(p.x, p.y, p.z);
	Hull hull;
	if (input.size() < 4) return hull;
	Mesh mesh;
	CGAL::convex_hull_3(input.begin(), input.end(), mesh);
	hull.solid = mesh.number_of_faces() > 3 && CGAL::is_closed(mesh);
	if (!hull.solid) return hull;
	for (const auto face : mesh.faces())
	{
		Triangle t;
		std::size_t corner = 0;
		for (const auto vertex : CGAL::vertices_around_face(mesh.halfedge(face), mesh))
		{
			const auto& p = mesh.point(vertex);
			t[corner++ % 3] = {p.x(), p.y(), p.z()};
		}
		hull.facets.push_back(t);
		const Vec3 normal = cross(t[1] - t[0], t[2] - t[0]);
		const double longest =
			std::max({lengthSquared(t[1] - t[0]), lengthSquared(t[2] - t[0]), lengthSquared(t[2] - t[1])});
		if (length(normal) <= least * std::sqrt(longest)) continue;
		const Vec3 unit = normalized(normal);
		hull.planes.push_back({unit, std::max({dot(unit, t[0]), dot(unit, t[1]), dot(unit, t[2])})});
	}
	return hull;
}

bool enters(const Triangle& t, const std::vector<Plane>& planes, double depth)
{
	for (const Plane& plane : planes)
		if (std::min({dot(plane.normal, t[0]), dot(plane.normal, t[1]), dot(plane.normal, t[2])}) >=
			plane.offset - depth)
			return false;
	std::vector<Vec3> polygon(t.begin(), t.end()), next;
	for (const Plane& plane : planes)
	{
		next.clear();
		for (std::size_t i = 0; i < polygon.size(); ++i)
		{
			const Vec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
			const double a = dot(plane.normal, p) - plane.offset + depth;
			const double b = dot(plane.normal, q) - plane.offset + depth;
			if (a < 0) next.push_back(p);
			if ((a < 0) != (b < 0)) next.push_back(p + (a / (a - b)) * (q - p));
		}
		polygon.swap(next);
		if (polygon.empty()) return false;
	}
	return true;
}

void Box::add(const Vec3& p)
{
	for (int i = 0; i < 3; ++i)
	{
		low[i] = std::min(low[i], p[i]);
		high[i] = std::max(high[i], p[i]);
	}
}

void Box::grow(double by)
{
	low = low - Vec3{by, by, by};
	high = high + Vec3{by, by, by};
}

bool Box::overlaps(const Box& other) const
{
	for (int i = 0; i < 3; ++i)
		if (low[i] > other.high[i] || other.low[i] > high[i]) return false;
	return true;
}

double Box::distance(const Vec3& p) const
{
	Vec3 d;
	for (int i = 0; i < 3; ++i) d[i] = std::max({low[i] - p[i], p[i] - high[i], 0.0});
	return length(d);
}

Box boxOf(const std::vector<Vec3>& points)
{
	Box box;
	for (const Vec3& p : points) box.add(p);
	return box;
}

TriangleTree::TriangleTree(std::vector<Triangle> triangles)
	: m_triangles(std::move(triangles)), m_order(m_triangles.size())
{
	std::iota(m_order.begin(), m_order.end(), 0u);
	if (!m_order.empty()) build(0, std::uint32_t(m_order.size()));
}

// Depth is the logarithm of the count: halves are equal.
std::uint32_t TriangleTree::build(std::uint32_t begin, std::uint32_t end)
{
	constexpr std::uint32_t kLeaf = 4;
	const std::uint32_t index = std::uint32_t(m_cells.size());
	Box box, centers;
	const auto center = [this](std::uint32_t i)
	{ return (1.0 / 3) * (m_triangles[i][0] + m_triangles[i][1] + m_triangles[i][2]); };
	for (std::uint32_t i = begin; i < end; ++i)
	{
		for (const Vec3& p : m_triangles[m_order[i]]) box.add(p);
		centers.add(center(m_order[i]));
	}
	m_cells.push_back({box, begin, end, 0});
	if (end - begin <= kLeaf) return index;
	const Vec3 size = centers.high - centers.low;
	const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
	const std::uint32_t middle = begin + (end - begin) / 2;
	std::nth_element(m_order.begin() + begin, m_order.begin() + middle, m_order.begin() + end,
					 [&](std::uint32_t a, std::uint32_t b)
					 {
						 const double pa = center(a)[axis], pb = center(b)[axis];
						 return pa != pb ? pa < pb : a < b;
					 });
	build(begin, middle);
	const std::uint32_t right = build(middle, end);
	m_cells[index].right = right;
	return index;
}

std::vector<std::uint32_t> TriangleTree::overlapping(const Box& box) const
{
	std::vector<std::uint32_t> found, open;
	if (!m_cells.empty()) open.push_back(0);
	while (!open.empty())
	{
		const std::uint32_t index = open.back();
		const Cell& cell = m_cells[index];
		open.pop_back();
		if (!cell.box.overlaps(box)) continue;
		if (cell.right != 0)
		{
			open.push_back(cell.right);
			open.push_back(index + 1);
			continue;
		}
		for (std::uint32_t i = cell.begin; i < cell.end; ++i)
		{
			Box own;
			for (const Vec3& p : m_triangles[m_order[i]]) own.add(p);
			if (own.overlaps(box)) found.push_back(m_order[i]);
		}
	}
	std::sort(found.begin(), found.end());
	return found;
}

TriangleTree::Nearest TriangleTree::nearest(const Vec3& p, double limit) const
{
	Nearest best{limit, kNone};
	struct Open
	{
		std::uint32_t cell;
		double distance;
	};
	std::array<Open, 128> open;
	std::size_t count = 0;
	if (!m_cells.empty()) open[count++] = {0, m_cells[0].box.distance(p)};
	while (count > 0)
	{
		const auto [index, atLeast] = open[--count];
		if (atLeast >= best.distance) continue;
		const Cell& cell = m_cells[index];
		if (cell.right == 0)
		{
			for (std::uint32_t i = cell.begin; i < cell.end; ++i)
			{
				const double d = distance(m_triangles[m_order[i]], p);
				if (d < best.distance) best = {d, m_order[i]};
			}
			continue;
		}
		Open near{index + 1, m_cells[index + 1].box.distance(p)}, far{cell.right, m_cells[cell.right].box.distance(p)};
		if (near.distance > far.distance) std::swap(near, far);
		open[count++] = far;
		open[count++] = near;
	}
	return best;
}
}  // namespace clod::check
