// SPDX-License-Identifier: GPL-3.0-or-later
// surf and reach by overlay: a polygon is compared with one triangle t of the target (the lemma at its corners); where
// that is not tight, the part that projects onto t is cut out along t's edges and bounded by t, and the rest goes on
// with its own nearest triangles. The number of parts follows the two meshes, not the tolerance.
#include "builder/assemble/Certify.h"

#include <algorithm>
#include <boost/container/small_vector.hpp>

namespace clod::builder
{
namespace
{
// Parts of one triangle before the bound at hand is taken: at least so many, and so many for each triangle of the
// target, as all of a fine mesh's flat side may lie under one triangle of a coarse level.
constexpr std::size_t kPartBudget = 20000, kPartsPerTarget = 4;
// Parts narrower than this share of the triangle are rounding of a cut: every point of one lies that close to its
// neighbour part, which the slack of the stored bounds covers.
constexpr double kSliver = 1e-13;

using Polygon = boost::container::small_vector<Vec3, 8>;

struct Part
{
	Polygon polygon;
	int halvings = 0;
	bool isCut = true;
};

Vec3 middle(const Polygon& p)
{
	Vec3 sum;
	for (const Vec3& v : p) sum += v;
	return (1 / double(p.size())) * sum;
}

// Both sides of the plane; a side without area stays empty.
void cut(const Polygon& p, const Vec3& normal, double offset, Polygon& below, Polygon& above)
{
	below.clear();
	above.clear();
	for (std::size_t i = 0; i < p.size(); ++i)
	{
		const Vec3 &u = p[i], &v = p[(i + 1) % p.size()];
		const double a = dot(normal, u) - offset, b = dot(normal, v) - offset;
		if (a <= 0) below.push_back(u);
		if (a >= 0) above.push_back(u);
		if ((a < 0 && b > 0) || (a > 0 && b < 0))
		{
			const Vec3 w = u + (a / (a - b)) * (v - u);
			below.push_back(w);
			above.push_back(w);
		}
	}
	if (below.size() < 3) below.clear();
	if (above.size() < 3) above.clear();
}

double area(const Polygon& p)
{
	Vec3 sum;
	for (std::size_t i = 2; i < p.size(); ++i) sum += 0.5 * cross(p[i - 1] - p[0], p[i] - p[0]);
	return length(sum);
}

double largestDistance(const Polygon& p, const Triangle& t)
{
	double most = 0;
	for (const Vec3& v : p) most = std::max(most, distanceSquared(v, t));
	return std::sqrt(most);
}

double radiusFrom(const Polygon& p, const Vec3& c)
{
	double most = 0;
	for (const Vec3& v : p) most = std::max(most, length(v - c));
	return most;
}

void halve(const Part& part, std::vector<Part>& stack)
{
	const Polygon& p = part.polygon;
	std::size_t from = 0, to = 0;
	for (std::size_t i = 0; i < p.size(); ++i)
		for (std::size_t j = i + 1; j < p.size(); ++j)
			if (lengthSquared(p[i] - p[j]) > lengthSquared(p[from] - p[to])) from = i, to = j;
	const Vec3 normal = normalized(p[to] - p[from]);
	Part first{{}, part.halvings + 1, true}, second{{}, part.halvings + 1, true};
	cut(p, normal, dot(normal, 0.5 * (p[from] + p[to])), first.polygon, second.polygon);
	for (Part* half : {&first, &second})
		if (!half->polygon.empty()) stack.push_back(std::move(*half));
}

// Nearest: Vec3 -> (triangle, distance). Bounds one triangle's supremum into `sup`.
template <class Nearest>
class Overlay
{
public:
	Overlay(const Nearest& nearest, std::size_t targets, const Tolerance& tolerance, Supremum& sup)
		: m_nearest(nearest),
		  m_budget(std::max(kPartBudget, kPartsPerTarget * targets)),
		  m_tolerance(tolerance),
		  m_sup(sup)
	{
	}

	void add(const Triangle& t)
	{
		m_normal = normalized(areaVector(t));
		m_parts = 1;
		m_size = radiusFrom({t.a, t.b, t.c}, centroid(t));
		m_stack.push_back({{t.a, t.b, t.c}, 0, false});
		while (!m_stack.empty())
		{
			const Part part = std::move(m_stack.back());
			m_stack.pop_back();
			visit(part);
		}
	}

private:
	bool good(double bound) const { return bound <= m_tolerance.accepted(m_sup.lower, m_sup.upper); }
	void take(double bound) { m_sup.upper = std::max(m_sup.upper, bound); }

	void visit(const Part& part)
	{
		const Vec3 c = middle(part.polygon);
		if (part.isCut && area(part.polygon) <= kSliver * m_size * radiusFrom(part.polygon, c)) return;
		const auto found = m_nearest(c);
		const double byCorners = largestDistance(part.polygon, found.first);
		const double bound = std::min(byCorners, found.second + radiusFrom(part.polygon, c));
		m_sup.lower = std::max(m_sup.lower, found.second);
		if (good(bound)) return take(bound);
		if (++m_parts > m_budget || part.halvings > 40) return take(bound);
		cutOut(part, found.first);
	}

	// The part of the polygon that projects onto t along the polygon's normal, bounded by t; the rest is stacked.
	void cutOut(const Part& part, const Triangle& t)
	{
		const double turned = dot(areaVector(t), m_normal) >= 0 ? 1 : -1;
		Polygon rest = part.polygon, inside, outside;
		std::vector<Part> aside;
		for (int e = 0; e < 3; ++e)
		{
			const Vec3 side = normalized(turned * cross(t[(e + 1) % 3] - t[e], m_normal));
			if (side == Vec3{} || rest.empty()) continue;
			cut(rest, side, dot(side, t[e]), inside, outside);
			if (!outside.empty()) aside.push_back({outside, part.halvings, true});
			rest = inside;
		}
		constexpr double kWorthwhile = 0.02;  // of the polygon's area
		if (aside.empty() || area(rest) <= kWorthwhile * area(part.polygon)) return halve(part, m_stack);
		const double bound = largestDistance(rest, t);
		if (good(bound))
			take(bound);
		else
			halve({rest, part.halvings, true}, m_stack);
		for (Part& p : aside) m_stack.push_back(std::move(p));
	}

	const Nearest& m_nearest;
	const std::size_t m_budget;
	const Tolerance m_tolerance;
	Supremum& m_sup;
	Vec3 m_normal;
	double m_size = 0;
	std::size_t m_parts = 0;
	std::vector<Part> m_stack;
};

// The nearest of some faces, the first of equally near ones. The one found last is tried first; a face whose ball is
// beyond the best so far is passed over.
class NearestFace
{
public:
	explicit NearestFace(const NodeDraft& node)
	{
		for (std::size_t i = 0; i < node.faces.size(); ++i)
		{
			m_faces.push_back(node.face(i));
			m_balls.push_back(ballRound(m_faces.back()));
		}
	}
	std::pair<Triangle, double> operator()(const Vec3& p) const { return within(p, -1); }

	// Any face that is as near as `enough` will do.
	std::pair<Triangle, double> within(const Vec3& p, double enough) const
	{
		std::size_t best = m_last;
		double least = distanceSquared(p, m_faces[best]), reach = std::sqrt(least) * (1 + 1e-12);
		for (std::size_t i = 0; i < m_faces.size() && reach > enough; ++i)
		{
			if (i == m_last || m_balls[i].isBeyond(p, reach)) continue;
			const double d = distanceSquared(p, m_faces[i]);
			if (d > least || (d == least && i > best)) continue;
			least = d, best = i;
			reach = std::sqrt(least) * (1 + 1e-12);
		}
		m_last = best;
		return {m_faces[best], std::sqrt(least)};
	}

private:
	std::vector<Triangle> m_faces;
	std::vector<Ball> m_balls;
	mutable std::size_t m_last = 0;
};

// The triangles one after the other, given upper bounds of their corners' distances. Where those alone show that a
// triangle does not exceed what is attained elsewhere, it is not looked at.
template <class Nearest>
void addTriangles(const std::vector<Vec3>& corners, const std::vector<std::array<std::uint32_t, 3>>& triangles,
				  const std::vector<double>& distances, const Nearest& nearest, std::size_t targets,
				  const Tolerance& tolerance, Supremum& sup)
{
	sup.upper = sup.lower;
	Overlay<Nearest> overlay(nearest, targets, tolerance, sup);
	for (const auto& t : triangles)
	{
		const Triangle triangle{corners[t[0]], corners[t[1]], corners[t[2]]};
		double bound = std::numeric_limits<double>::infinity();
		for (int k = 0; k < 3; ++k)
		{
			const double reach = std::max(lengthSquared(triangle[(k + 1) % 3] - triangle[k]),
										  lengthSquared(triangle[(k + 2) % 3] - triangle[k]));
			bound = std::min(bound, distances[t[std::size_t(k)]] + std::sqrt(reach));
		}
		if (bound > sup.lower) overlay.add(triangle);
	}
}
}  // namespace

CoverAndReach coverAndReachOf(const NodeDraft& node, const Mesh& input, const Tolerance& tolerance)
{
	const Territory territory = territoryOf(node.pieces, input);
	const NearestFace nearest(node);
	const ConvexSet hull = node.hull();
	CoverAndReach result;
	std::vector<double> distances;
	distances.reserve(territory.corners.size());
	for (const Vec3& corner : territory.corners)
	{
		// The hull holds the faces: what is that near to a face adds to neither.
		distances.push_back(nearest.within(corner, result.cover).second);
		if (distances.back() <= result.cover) continue;
		result.reach.lower = std::max(result.reach.lower, distances.back());
		result.cover = std::max(result.cover, distanceBound(corner, hull, result.cover));
	}
	addTriangles(territory.corners, territory.triangles, distances, nearest, node.faces.size(), tolerance,
				 result.reach);
	return result;
}

Supremum surfOf(const NodeDraft& node, const TriangleTree& input, const Tolerance& tolerance)
{
	const auto nearest = [&input](const Vec3& p)
	{
		const TriangleTree::Nearest n = input.nearest(p);
		return std::pair<Triangle, double>(input.triangle(n.triangle), std::sqrt(n.distanceSquared));
	};
	Supremum sup;
	std::vector<double> distances;
	for (const Vec3& corner : node.vertices)
	{
		distances.push_back(nearest(corner).second);
		sup.lower = std::max(sup.lower, distances.back());
	}
	addTriangles(node.vertices, node.faces, distances, nearest, input.size(), tolerance, sup);
	return sup;
}
}  // namespace clod::builder
