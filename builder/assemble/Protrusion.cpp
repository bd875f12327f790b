// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/assemble/Protrusion.h"

#include <algorithm>
#include <queue>

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

// Branch and bound over tetrahedra (Lipschitz constant 1).
struct Tetrahedron
{
	std::array<Vec3, 4> corner;
	double bound;
	bool operator<(const Tetrahedron& other) const { return bound < other.bound; }
};

double boundOf(const Solid& solid, const std::array<Vec3, 4>& corner, double& lower)
{
	const Vec3 c = 0.25 * (corner[0] + corner[1] + corner[2] + corner[3]);
	double reach = 0, toTriangle = 0;
	std::uint32_t nearest = 0;
	const double d = solid.signedDistance(c, nearest);
	const Triangle& t = solid.tree().triangle(nearest);
	for (const Vec3& p : corner)
	{
		reach = std::max(reach, length(p - c));
		toTriangle = std::max(toTriangle, std::sqrt(distanceSquared(p, t)));
	}
	lower = std::max(lower, d);
	return std::max(0.0, std::min(d + reach, d < -reach ? 0.0 : toTriangle));
}

Protrusion byBranching(const Solid& solid, const HullShape& shape, const Vec3& center, double lower, double tolerance)
{
	constexpr int kBudget = 400;
	std::priority_queue<Tetrahedron> queue;
	for (const Triangle& f : shape.facets)
	{
		const std::array<Vec3, 4> corner{center, f.a, f.b, f.c};
		queue.push({corner, boundOf(solid, corner, lower)});
	}
	for (int i = 0; i < kBudget && queue.top().bound > std::max(1.15 * lower, lower + tolerance); ++i)
	{
		const Tetrahedron t = queue.top();
		queue.pop();
		std::size_t from = 0, to = 1;
		for (std::size_t a = 0; a < 4; ++a)
			for (std::size_t b = a + 1; b < 4; ++b)
				if (lengthSquared(t.corner[a] - t.corner[b]) > lengthSquared(t.corner[from] - t.corner[to]))
					from = a, to = b;
		const Vec3 middle = 0.5 * (t.corner[from] + t.corner[to]);
		for (std::size_t replaced : {from, to})
		{
			std::array<Vec3, 4> half = t.corner;
			half[replaced] = middle;
			queue.push({half, std::min(t.bound, boundOf(solid, half, lower))});
		}
	}
	return {lower, std::max(queue.top().bound, lower)};
}

// Facet groups whose normals lie within 45 degrees of the group's first; each spans a cell with the body's centre.
std::vector<std::vector<Triangle>> facetGroups(const HullShape& shape)
{
	constexpr double kCosine = 0.7;
	std::vector<std::vector<Triangle>> groups;
	std::vector<Vec3> heads;
	for (const Triangle& f : shape.facets)
	{
		const Vec3 n = normalized(areaVector(f));
		std::size_t g = 0;
		while (g < heads.size() && dot(heads[g], n) < kCosine) ++g;
		if (g == heads.size())
		{
			heads.push_back(n);
			groups.emplace_back();
		}
		groups[g].push_back(f);
	}
	return groups;
}

Protrusion byCells(const Solid& solid, const HullShape& shape, const Vec3& center, const ProtrusionScale& scale,
				   const Protrusion& known)
{
	Protrusion result{known.lower, known.lower};
	for (const std::vector<Triangle>& group : facetGroups(shape))
	{
		std::vector<Vec3> points{center}, normals;
		for (const Triangle& f : group)
		{
			for (int k = 0; k < 3; ++k) points.push_back(f[k]);
			normals.push_back(areaVector(f));
		}
		Cell cell(solid, points, scale);
		const double start = std::max(result.upper, scale.rounding);
		double upper = byDisplacement(cell, normals, start, known.upper);
		if (!(upper <= std::max(2 * start, start + 1e-3 * scale.radius)))
			upper = std::min(upper,
							 byBranching(solid, cell.shape(), cell.center(), result.lower, 1e-4 * scale.radius).upper);
		result.upper = std::max(result.upper, upper);
	}
	result.upper = std::min(result.upper, known.upper);
	return result;
}
}  // namespace

Protrusion protrusion(const Solid& solid, const ConvexBody& body, const ProtrusionScale& scale)
{
	Cell whole(solid, body.points, scale);
	Protrusion result;
	for (const Vec3& p : whole.shape().corners) result.lower = std::max(result.lower, solid.distance(p));
	const double start = std::max(result.lower, scale.rounding);
	result.upper = byDisplacement(whole, body.realNormals, start, std::max(4 * start, start + 0.01 * scale.radius));
	if (result.upper <= std::max(1.5 * start, start + 1e-4 * scale.radius)) return result;
	if (std::isinf(result.upper))
	{
		const Triangle& t = solid.tree().triangle(solid.tree().nearest(whole.center()).triangle);
		result.upper = 0;
		for (const Vec3& p : whole.shape().corners)
			result.upper = std::max(result.upper, std::sqrt(distanceSquared(p, t)));
	}
	return byCells(solid, whole.shape(), whole.center(), scale, result);
}
}  // namespace clod::builder
