// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/assemble/Protrusion.h"

#include <algorithm>

#include "builder/assemble/HullPlanes.h"

namespace clod::builder
{
namespace
{
// x -> x + amount * (shift + pull * (center - x))
struct Displacement
{
	Vec3 shift;
	double pull = 0;
	Vec3 center;
	Vec3 at(const Vec3& x) const { return shift + pull * (center - x); }
};

double largest(const Displacement& d, const std::vector<Vec3>& points)
{
	double most = 0;
	for (const Vec3& p : points) most = std::max(most, length(d.at(p)));
	return most;
}

// What is left of a triangle inside all half-spaces; at most 3 + planes corners.
bool meetsInterior(const Triangle& t, const std::vector<HalfSpace>& planes, double slack)
{
	for (const HalfSpace& plane : planes)
		if (std::min({dot(plane.normal, t.a), dot(plane.normal, t.b), dot(plane.normal, t.c)}) > plane.offset + slack)
			return false;
	std::vector<Vec3> polygon{t.a, t.b, t.c}, next;
	for (const HalfSpace& plane : planes)
	{
		next.clear();
		for (std::size_t i = 0; i < polygon.size(); ++i)
		{
			const Vec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
			const double a = dot(plane.normal, p) - plane.offset - slack,
						 b = dot(plane.normal, q) - plane.offset - slack;
			if (a <= 0) next.push_back(p);
			if ((a <= 0) != (b <= 0)) next.push_back(p + (a / (a - b)) * (q - p));
		}
		polygon.swap(next);
		if (polygon.empty()) return false;
	}
	return true;
}

// One convex cell of the body with the input triangles near it.
class Cell
{
public:
	Cell(const Solid& solid, const std::vector<Vec3>& points, const ProtrusionScale& scale)
		: m_solid(solid), m_scale(scale), m_shape(hullShape(points, 0.25 * scale.rounding))
	{
		for (const Vec3& p : m_shape.corners) m_center += (1 / double(m_shape.corners.size())) * p;
		for (const Vec3& p : m_shape.corners) m_reach = std::max(m_reach, length(p - m_center));
	}
	const HullShape& shape() const { return m_shape; }
	const Vec3& center() const { return m_center; }
	double reach() const { return m_reach; }

	// The smallest amount of this displacement (times its largest length) that brings the cell into the solid, up to 15
	// %; infinity beyond `limit`.
	double needed(const Displacement& displacement, double start, double limit)
	{
		constexpr double kStep = 1.15;
		const double speed = largest(displacement, m_shape.corners);
		if (speed <= 0) return std::numeric_limits<double>::infinity();
		double amount = start;
		gather(limit);
		for (bool clear = false; !clear;)
		{
			clear = true;
			std::vector<HalfSpace> planes = moved(displacement, amount / speed);
			for (const Triangle& t : m_near)
				while (meetsInterior(t, planes, kSlack * m_scale.radius))
				{
					clear = false;
					amount *= kStep;
					if (amount > limit) return std::numeric_limits<double>::infinity();
					planes = moved(displacement, amount / speed);
				}
		}
		const Vec3 inside = m_center + (amount / speed) * displacement.at(m_center);
		return m_solid.signedDistance(inside) < 0 ? amount : std::numeric_limits<double>::infinity();
	}

private:
	static constexpr double kSlack = 1e-13;

	std::vector<HalfSpace> moved(const Displacement& d, double amount) const
	{
		std::vector<HalfSpace> planes = m_shape.planes;
		for (HalfSpace& p : planes)
			p.offset += amount * (dot(p.normal, d.shift) + d.pull * (dot(p.normal, d.center) - p.offset));
		return planes;
	}

	void gather(double limit)
	{
		if (limit <= m_gathered) return;
		m_gathered = limit;
		m_near.clear();
		AxisBox box;
		for (const Vec3& p : m_shape.corners) box.add(p);
		box.low = box.low - Vec3{limit, limit, limit};
		box.high = box.high + Vec3{limit, limit, limit};
		m_solid.tree().forEachIn(box,
								 [this](std::uint32_t i)
								 {
									 m_near.push_back(m_solid.tree().triangle(i));
									 return true;
								 });
	}

	const Solid& m_solid;
	const ProtrusionScale m_scale;
	HullShape m_shape;
	Vec3 m_center;
	double m_reach = 0;
	double m_gathered = -1;
	std::vector<Triangle> m_near;
};

// Tries the families of maps: straight in along the mean normal with a little contraction, more of it, contraction
// only.
double byDisplacement(Cell& cell, const std::vector<Vec3>& normals, double start, double limit)
{
	Vec3 inward;
	for (const Vec3& n : normals) inward -= n;
	inward = normalized(inward);
	double best = std::numeric_limits<double>::infinity();
	for (double pull : {0.1, 0.5, 2.0})
	{
		if (inward == Vec3{} || cell.reach() <= 0) break;
		best = std::min(best, cell.needed({inward, pull / cell.reach(), cell.center()}, start, std::min(limit, best)));
		if (best <= 1.4 * start) return best;
	}
	if (cell.reach() > 0)
		best = std::min(best, cell.needed({Vec3{}, 1 / cell.reach(), cell.center()}, start, std::min(limit, best)));
	return best;
}

// A corner of a cell, and where the cell's map takes it: a little below the surface, or nowhere if it is deeper
// already.
struct Corner
{
	Vec3 point, image;
	double distance;  // to the solid
	double toSurface;
	double moved;  // infinity: no place in the solid was found
};

struct Tetrahedron
{
	std::array<std::uint32_t, 4> corner;
	double bound;  // holds whatever happens
	bool operator<(const Tetrahedron& other) const { return bound < other.bound; }
};

// The body cut into tetrahedra, each with its own affine map given by the images of its corners.
class Mapping
{
public:
	Mapping(const Solid& solid, const HullShape& shape, const Vec3& center, const ProtrusionScale& scale,
			Protrusion known, double hopeless)
		: m_solid(solid), m_scale(scale), m_known(known), m_hopeless(hopeless)
	{
		m_result.lower = known.lower;
		for (const Triangle& f : shape.facets)
			for (int k = 0; k < 3; ++k) m_result.lower = std::max(m_result.lower, solid.distance(f[k]));
		m_depth = std::max(0.1 * m_result.lower, 1e-5 * scale.radius);
		m_result.upper = m_result.lower;
		constexpr double kAnywhere = std::numeric_limits<double>::infinity();
		const std::uint32_t apex = add(center, kAnywhere);
		for (const Triangle& f : shape.facets)
			m_cells.push_back({{apex, add(f.a, kAnywhere), add(f.b, kAnywhere), add(f.c, kAnywhere)}, known.upper});
	}

	// The cell with the largest bound first, so that what is left when the budget ends is bounded well.
	Protrusion run()
	{
		for (int i = 0; !m_cells.empty() && m_cells.front().bound > accepted(); ++i)
		{
			if (m_result.lower > m_hopeless) break;
			std::pop_heap(m_cells.begin(), m_cells.end());
			const Tetrahedron cell = m_cells.back();
			m_cells.pop_back();
			const double moved = largestMove(cell);
			if (moved <= accepted() && imageIsInside(cell))
				m_result.upper = std::max(m_result.upper, moved);
			else if (i < m_scale.budget)
				split(cell);
			else
				m_result.upper = std::max(m_result.upper, cell.bound);
		}
		m_result.upper = std::max(m_result.upper, m_cells.empty() ? 0 : m_cells.front().bound);
		m_result.upper = std::min(std::max(m_result.upper, m_result.lower), m_known.upper);
		return m_result;
	}

private:
	double accepted() const
	{
		return std::max({m_result.upper, m_scale.inParts * m_result.lower, m_result.lower + 3e-5 * m_scale.radius});
	}

	// The nearest surface point, which lies within the limit.
	TriangleTree::Nearest nearestWithin(const Vec3& p, double limit) const
	{
		const double room = limit * (1 + 1e-6) + 1e-12 * m_scale.radius;
		const TriangleTree::Nearest near = m_solid.tree().nearest(
			p, [](std::uint32_t) { return true; }, room * room);
		return near.triangle == kNone ? m_solid.tree().nearest(p) : near;
	}

	double signedDistance(const Vec3& p, const TriangleTree::Nearest& near) const
	{
		const double d = std::sqrt(near.distanceSquared);
		return dot(m_solid.normal(near), p - near.closest.point) < 0 ? -d : d;
	}

	// The surface is known to pass within `limit` of p.
	std::uint32_t add(const Vec3& p, double limit)
	{
		Corner corner{p, p, 0, 0, 0};
		const TriangleTree::Nearest near = nearestWithin(p, limit);
		const double d = signedDistance(p, near);
		corner.toSurface = std::fabs(d);
		corner.distance = std::max(0.0, d);
		m_result.lower = std::max(m_result.lower, corner.distance);
		if (d > -m_depth)
		{
			const Vec3 inward = -normalized(m_solid.normal(near));
			corner.moved = std::numeric_limits<double>::infinity();
			for (double depth : {m_depth, 0.3 * m_depth})
			{
				corner.image = near.closest.point + depth * inward;
				if (signedDistance(corner.image, nearestWithin(corner.image, depth)) >= 0) continue;
				corner.moved = length(corner.image - p);
				break;
			}
		}
		m_corners.push_back(corner);
		return std::uint32_t(m_corners.size() - 1);
	}

	double largestMove(const Tetrahedron& cell) const
	{
		double most = 0;
		for (std::uint32_t c : cell.corner) most = std::max(most, m_corners[c].moved);
		return most;
	}

	// The distance to the solid has Lipschitz constant 1.
	double lipschitz(const Tetrahedron& cell) const
	{
		double least = std::numeric_limits<double>::infinity();
		for (std::uint32_t c : cell.corner)
		{
			double reach = 0;
			for (std::uint32_t other : cell.corner)
				reach = std::max(reach, length(m_corners[c].point - m_corners[other].point));
			least = std::min(least, m_corners[c].distance + reach);
		}
		return least;
	}

	// No input triangle meets the image's interior. A flat image is held by its box besides its faces.
	bool imageIsInside(const Tetrahedron& cell) const
	{
		constexpr int kFaces[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
		std::array<Vec3, 4> v;
		AxisBox box;
		for (std::size_t i = 0; i < 4; ++i) box.add(v[i] = m_corners[cell.corner[i]].image);
		std::vector<HalfSpace> planes;
		for (int f = 0; f < 4; ++f)
		{
			const Vec3& a = v[std::size_t(kFaces[f][0])];
			Vec3 n = normalized(cross(v[std::size_t(kFaces[f][1])] - a, v[std::size_t(kFaces[f][2])] - a));
			if (n == Vec3{}) continue;
			if (dot(n, v[std::size_t(3 - f)] - a) > 0) n = -n;
			planes.push_back({n, 0});
		}
		for (int axis = 0; axis < 3; ++axis)
			for (double sign : {1.0, -1.0})
			{
				Vec3 n;
				n[axis] = sign;
				planes.push_back({n, 0});
			}
		for (HalfSpace& plane : planes)
			plane.offset = std::max(
				{dot(plane.normal, v[0]), dot(plane.normal, v[1]), dot(plane.normal, v[2]), dot(plane.normal, v[3])});
		const double slack = 1e-13 * m_scale.radius;
		return m_solid.tree().forEachIn(
			box, [&](std::uint32_t i) { return !meetsInterior(m_solid.tree().triangle(i), planes, slack); });
	}

	void push(Tetrahedron cell)
	{
		cell.bound = std::min(cell.bound, lipschitz(cell));
		m_cells.push_back(cell);
		std::push_heap(m_cells.begin(), m_cells.end());
	}

	void split(const Tetrahedron& cell)
	{
		std::size_t from = 0, to = 1;
		double longest = 0;
		for (std::size_t a = 0; a < 4; ++a)
			for (std::size_t b = a + 1; b < 4; ++b)
			{
				const double l = lengthSquared(m_corners[cell.corner[a]].point - m_corners[cell.corner[b]].point);
				if (l > longest) longest = l, from = a, to = b;
			}
		const Corner &u = m_corners[cell.corner[from]], &v = m_corners[cell.corner[to]];
		const double limit = std::min(u.toSurface, v.toSurface) + 0.5 * std::sqrt(longest);
		const std::uint32_t middle = add(0.5 * (u.point + v.point), limit);
		for (std::size_t replaced : {from, to})
		{
			Tetrahedron half = cell;
			half.corner[replaced] = middle;
			push(half);
		}
	}

	const Solid& m_solid;
	const ProtrusionScale m_scale;
	const Protrusion m_known;
	const double m_hopeless;
	double m_depth = 0;
	Protrusion m_result;
	std::vector<Corner> m_corners;
	std::vector<Tetrahedron> m_cells;
};
}  // namespace

Protrusion protrusion(const Solid& solid, const ConvexBody& body, const ProtrusionScale& scale, double hopeless)
{
	Cell whole(solid, body.points, scale);
	Protrusion result;
	for (const Vec3& p : whole.shape().corners) result.lower = std::max(result.lower, solid.distance(p));
	const double start = std::max(result.lower, scale.rounding);
	if (result.lower > hopeless) return {result.lower, std::numeric_limits<double>::infinity()};
	result.upper = byDisplacement(whole, body.realNormals, start, std::max(4 * start, start + 0.01 * scale.radius));
	if (result.upper <= std::max(scale.atOnce * start, start + 1e-4 * scale.radius)) return result;
	if (std::isinf(result.upper))
	{
		const Triangle& t = solid.tree().triangle(solid.tree().nearest(whole.center()).triangle);
		result.upper = 0;
		for (const Vec3& p : whole.shape().corners)
			result.upper = std::max(result.upper, std::sqrt(distanceSquared(p, t)));
	}
	return Mapping(solid, whole.shape(), whole.center(), scale, result, hopeless).run();
}
}  // namespace clod::builder
