// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/assemble/Protrusion.h"

#include <algorithm>

#include "builder/assemble/Displacement.h"

namespace clod::builder
{
namespace
{
constexpr double kTight = 1.05;  // times what is attained: a bound good enough

// A corner of a cell, and where the cell's maps take it: as deep below the surface as the bound allows, which carries a
// chord over a hollow in one piece, or only just below it, which stays in thin walls. Nowhere if it is deeper already.
struct Corner
{
	Vec3 point;
	double distance;  // to the solid
	double toSurface;
	Vec3 image[2];
	double moved[2];  // infinity: no place in the solid was found
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
		m_result.lower = m_result.upper = known.lower;  // that of all corners
		m_depth = std::max(0.1 * m_result.lower, 1e-5 * scale.radius);
		constexpr double kAnywhere = std::numeric_limits<double>::infinity();
		const std::uint32_t apex = add(center, kAnywhere), first = apex + 1;
		for (const Vec3& p : shape.corners) add(p, kAnywhere);
		for (const std::array<std::uint32_t, 3>& f : shape.facets)
			m_cells.push_back({{apex, first + f[0], first + f[1], first + f[2]}, known.upper});
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
			const double moved = smallestMove(cell);
			if (moved <= accepted())
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
	// No looser than what is hopeless beyond, while that can still be kept.
	double accepted() const
	{
		const double good =
			std::max({kTight * m_result.lower, m_result.lower + 3e-5 * m_scale.radius, m_scale.enough});
		return std::max({m_result.upper, m_result.lower, std::min(good, m_hopeless)});
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
		Corner corner{p, 0, 0, {p, p}, {0, 0}};
		const TriangleTree::Nearest near = nearestWithin(p, limit);
		const double d = signedDistance(p, near);
		corner.toSurface = std::fabs(d);
		corner.distance = std::max(0.0, d);
		m_result.lower = std::max(m_result.lower, corner.distance);
		const double most = accepted() * (1 - 1e-9) - d;
		if (d > -m_depth) place(corner, 1, near, {m_depth, 0.3 * m_depth});
		if (most > 0) place(corner, 0, near, {most, 0.5 * most});
		m_corners.push_back(corner);
		return std::uint32_t(m_corners.size() - 1);
	}

	// The first of the depths at which the image lies in the solid.
	void place(Corner& corner, std::size_t map, const TriangleTree::Nearest& near,
			   std::initializer_list<double> depths) const
	{
		const Vec3 inward = -normalized(m_solid.normal(near));
		corner.moved[map] = std::numeric_limits<double>::infinity();
		for (double depth : depths)
		{
			const Vec3 image = near.closest.point + depth * inward;
			if (signedDistance(image, nearestWithin(image, depth)) >= 0) continue;
			corner.image[map] = image;
			corner.moved[map] = length(image - corner.point);
			break;
		}
	}

	// The largest move of the first map that brings the cell into the solid within what is accepted; else infinity.
	double smallestMove(const Tetrahedron& cell) const
	{
		for (std::size_t map : {std::size_t(0), std::size_t(1)})
		{
			double most = 0;
			for (std::uint32_t c : cell.corner) most = std::max(most, m_corners[c].moved[map]);
			if (most <= accepted() && imageIsInside(cell, map)) return most;
		}
		return std::numeric_limits<double>::infinity();
	}

	// The distance to the solid has Lipschitz constant 1.
	double lipschitz(const Tetrahedron& cell) const
	{
		double least = std::numeric_limits<double>::infinity();
		for (std::uint32_t c : cell.corner)
		{
			double longest = 0;
			for (std::uint32_t other : cell.corner)
				longest = std::max(longest, length(m_corners[c].point - m_corners[other].point));
			least = std::min(least, m_corners[c].distance + longest);
		}
		return least;
	}

	// No input triangle meets the image's interior. A flat image is held by its box besides its faces.
	bool imageIsInside(const Tetrahedron& cell, std::size_t map) const
	{
		constexpr int kFaces[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
		std::array<Vec3, 4> v;
		AxisBox box;
		for (std::size_t i = 0; i < 4; ++i) box.add(v[i] = m_corners[cell.corner[i]].image[map]);
		static thread_local std::vector<HalfSpace> planes;
		planes.clear();
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
	const double start = std::max({result.lower, scale.rounding, scale.enough});
	if (result.lower > hopeless) return {result.lower, std::numeric_limits<double>::infinity()};
	result.upper = byDisplacement(whole, body.realNormals, start, std::max(4 * start, start + 0.01 * scale.radius));
	if (result.upper <= std::max(kTight * start, start + 1e-4 * scale.radius)) return result;
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
