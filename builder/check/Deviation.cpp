// SPDX-License-Identifier: GPL-3.0-or-later
// surf and protrude against the input surface.
//
// surf: over a polygon the distance to one input triangle is convex, hence largest at a corner; triangles are cut until
// that settles every part. protrude: the hull, moved by an affine map that shifts no point farther than the
// bound, meets no input face and has a point inside, so it lies in the solid; where no map of a small family does that,
// tetrahedra are halved under the Lipschitz bound or until maps of their own do it. A sample beyond the bound is a
// violation; a node settled by neither is undecided.
#include <fmt/format.h>

#include <algorithm>
#include <queue>

#include "builder/check/LevelSolid.h"

namespace clod::check
{
namespace
{
enum class Verdict
{
	holds,
	broken,
	undecided
};
struct Finding
{
	Verdict verdict = Verdict::holds;
	double excess = 0;
};

// The nearest triangle, looked for within the distance of one that is not far.
TriangleTree::Nearest nearestFrom(const TriangleTree& surface, std::uint32_t known, const Vec3& p)
{
	const TriangleTree::Nearest first{distance(surface.triangles()[known], p), known};
	const TriangleTree::Nearest nearer = surface.nearest(p, first.distance);
	return nearer.distance < first.distance ? nearer : first;
}

// A part of a triangle, and a triangle of the surface that is not far from it.
struct Part
{
	std::vector<Vec3> corners;
	std::uint32_t known;
};

double radiusFrom(const Vec3& from, const std::vector<Vec3>& points)
{
	double most = 0;
	for (const Vec3& p : points) most = std::max(most, length(p - from));
	return most;
}

// What lies over the triangle, and what lies beyond each of its edges; all of it in one piece where no edge cuts off
// more than a strip of width `least`.
std::vector<Part> cutByEdges(const Part& part, const Triangle& t, double least)
{
	std::vector<Part> pieces;
	const Vec3 normal = cross(t[1] - t[0], t[2] - t[0]);
	std::vector<Vec3> rest = part.corners;
	for (std::size_t i = 0; i < 3 && !rest.empty(); ++i)
	{
		const Vec3 outward = normalized(cross(t[(i + 1) % 3] - t[i], normal));
		const double offset = dot(outward, t[i]);
		double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
		for (const Vec3& p : rest)
		{
			lowest = std::min(lowest, dot(outward, p) - offset);
			highest = std::max(highest, dot(outward, p) - offset);
		}
		if (highest <= least) continue;
		std::vector<Vec3> beyond = rest;
		if (lowest >= -least)
			rest.clear();
		else
		{
			keepBelow(beyond, -outward, -offset);
			keepBelow(rest, outward, offset);
		}
		pieces.push_back({std::move(beyond), part.known});
	}
	if (!rest.empty()) pieces.push_back({std::move(rest), part.known});
	return pieces;
}

// Across its longest way from the centre.
std::vector<Part> halves(const Part& part, const Vec3& center)
{
	const Vec3 farthest = *std::max_element(part.corners.begin(), part.corners.end(), [&](const Vec3& a, const Vec3& b)
											{ return lengthSquared(a - center) < lengthSquared(b - center); });
	const Vec3 way = farthest - center;
	Part far = part, near = part;
	keepBelow(far.corners, -way, -dot(way, center));
	keepBelow(near.corners, way, dot(way, center));
	return {std::move(near), std::move(far)};
}

// Distance from a triangle to the surface against `bound`. What one triangle of the surface does not settle is cut
// along the edges of the nearest where that is larger than the bound, as what lies over it settles at once then, else
// halved.
Finding judgeTriangle(const TriangleTree& surface, const Triangle& whole, double bound, double slack)
{
	constexpr int kBudget = 4000;
	constexpr double kStrip = 0.01;  // of the bound
	const double enough = bound + slack;
	std::vector<Part> open = {{{whole[0], whole[1], whole[2]}, surface.nearest(whole[0]).triangle}};
	for (int i = 0; !open.empty(); ++i)
	{
		if (i == kBudget) return {Verdict::undecided, 0};
		Part part = std::move(open.back());
		open.pop_back();
		Vec3 center;
		for (const Vec3& p : part.corners) center += (1 / double(part.corners.size())) * p;
		std::vector<Vec3> from = {center};
		from.insert(from.end(), part.corners.begin(), part.corners.end());
		bool settled = false;
		std::uint32_t middle = part.known;
		for (std::size_t k = 0; k < from.size() && !settled; ++k)
		{
			const TriangleTree::Nearest nearest = nearestFrom(surface, part.known, from[k]);
			if (nearest.distance > enough) return {Verdict::broken, nearest.distance - bound};
			part.known = nearest.triangle;
			if (k == 0) middle = nearest.triangle;
			const Triangle& other = surface.triangles()[nearest.triangle];
			settled = nearest.distance + radiusFrom(from[k], part.corners) <= enough ||
					  std::all_of(part.corners.begin(), part.corners.end(),
								  [&](const Vec3& p) { return distance(other, p) <= enough; });
		}
		if (settled) continue;
		const Triangle& below = surface.triangles()[middle];
		part.known = middle;
		std::vector<Part> pieces;
		if (radiusFrom(below[0], {below[1], below[2]}) > bound) pieces = cutByEdges(part, below, kStrip * bound);
		if (pieces.size() < 2) pieces = halves(part, center);
		for (Part& piece : pieces) open.push_back(std::move(piece));
	}
	return {};
}

// Planes of the hull moved by x -> x + amount * (shift + pull * (center - x)).
struct Map
{
	Vec3 shift;
	double pull;
};

class Body
{
public:
	Body(const LevelSolid& solid, const std::vector<Vec3>& points, double bound, double slack)
		: m_solid(solid), m_points(points), m_hull(hullOf(points, slack)), m_bound(bound), m_slack(slack)
	{
		for (const Vec3& p : points) m_center += (1 / double(points.size())) * p;
		for (const Vec3& p : points) m_radius = std::max(m_radius, length(p - m_center));
		Box box = boxOf(points);
		box.grow(bound + slack);
		m_near = solid.surface().overlapping(box);
	}
	Finding judge(const Vec3& inward) const
	{
		const double outside = sampledDistance();
		if (outside > m_bound + m_slack) return {Verdict::broken, outside - m_bound};
		if (!m_hull.solid) return judgeFlat();
		for (const double pull : {0.05, 0.3, 1.0, 3.0})
			if (fitsInside({inward, pull})) return {};
		if (fitsInside({Vec3{}, 1})) return {};
		return branch();
	}

private:
	// Of corners, facets' middles and the centre: the farthest out, if beyond the bound. The side is asked there alone,
	// as points on the surface cost it exact arithmetic.
	double sampledDistance() const
	{
		double most = 0;
		const auto sample = [&](const Vec3& p)
		{
			const double d = m_solid.surface().nearest(p).distance;
			if (d > m_bound + m_slack && d > most && !m_solid.holds(p)) most = d;
		};
		sample(m_center);
		for (const Vec3& p : m_points) sample(p);
		for (const Triangle& t : m_hull.facets) sample((1.0 / 3) * (t[0] + t[1] + t[2]));
		return most;
	}
	// A hull in a plane: as a fan of triangles round its centre, every pair of points (more than its area, never less).
	Finding judgeFlat() const
	{
		if (m_points.size() > 40) return {Verdict::undecided, 0};
		Finding worst;
		for (std::size_t i = 0; i < m_points.size(); ++i)
			for (std::size_t k = i + 1; k < m_points.size(); ++k)
			{
				const Finding found =
					judgeTriangle(m_solid.surface(), {m_center, m_points[i], m_points[k]}, m_bound, m_slack);
				if (found.verdict != Verdict::holds) worst.verdict = Verdict::undecided;  // it may lie inside the solid
			}
		return worst;
	}
	bool fitsInside(const Map& map) const
	{
		const Vec3 pullCenter = m_center;
		const double scale = m_radius > 0 ? map.pull / m_radius : 0;
		const auto velocity = [&](const Vec3& x) { return map.shift + scale * (pullCenter - x); };
		double fastest = 0;
		for (const Vec3& p : m_points) fastest = std::max(fastest, length(velocity(p)));
		const double amount = fastest > 0 ? m_bound / fastest : 0;
		if (amount * scale >= 1) return m_solid.holds(pullCenter + amount * map.shift);
		std::vector<Plane> planes = m_hull.planes;
		for (Plane& p : planes)
			p.offset += amount * (dot(p.normal, map.shift) + scale * (dot(p.normal, pullCenter) - p.offset));
		for (const std::uint32_t f : m_near)
			if (enters(m_solid.surface().triangles()[f], planes, m_slack)) return false;
		return m_solid.holds(m_center + amount * velocity(m_center));
	}
	// A point of the hull, and it moved straight to where the solid is deeper, no farther than the bound.
	struct Corner
	{
		Vec3 at, image;
	};
	using Corners = std::array<Corner, 4>;
	struct Cell
	{
		Corners corner;
		double bound;
		bool operator<(const Cell& other) const { return bound < other.bound; }
	};
	double boundOf(const Corners& corner, double& attained) const
	{
		const Vec3 c = 0.25 * (corner[0].at + corner[1].at + corner[2].at + corner[3].at);
		const TriangleTree::Nearest nearest = m_solid.surface().nearest(c);
		double radius = 0, toTriangle = 0;
		for (const auto& [at, image] : corner)
		{
			radius = std::max(radius, length(at - c));
			toTriangle = std::max(toTriangle, distance(m_solid.surface().triangles()[nearest.triangle], at));
		}
		const double anywhere = std::min(nearest.distance + radius, toTriangle);
		if (anywhere <= m_bound + m_slack) return anywhere;
		const bool inside = m_solid.holds(c);
		if (!inside) attained = std::max(attained, nearest.distance);
		const double lipschitz = std::max(0.0, (inside ? -nearest.distance : nearest.distance) + radius);
		return std::min(lipschitz, toTriangle);
	}
	Corner cornerAt(const Vec3& p) const
	{
		const TriangleTree::Nearest nearest = m_solid.surface().nearest(p);
		const Triangle& t = m_solid.surface().triangles()[nearest.triangle];
		const Vec3 foot = nearestOn(t, p), face = normalized(cross(t[1] - t[0], t[2] - t[0]));
		const bool inside = nearest.distance > m_slack && m_solid.holds(p);
		const double signedDistance = inside ? -nearest.distance : nearest.distance;
		const Vec3 inward = nearest.distance > m_slack ? (1 / signedDistance) * (foot - p) : -face;
		return {p, p + std::max(0.0, m_bound - std::max(0.0, -signedDistance)) * inward};
	}
	// A cell whose moved corners span one that meets no input face and has a point inside.
	bool isCarriedInside(const Corners& corner) const
	{
		std::vector<Vec3> image;
		Vec3 center;
		for (const Corner& moved : corner)
		{
			image.push_back(moved.image);
			center += 0.25 * moved.image;
		}
		const Hull hull = hullOf(image, m_slack);
		if (!hull.solid || hull.planes.size() != 4) return false;
		for (const std::uint32_t f : m_solid.surface().overlapping(boxOf(image)))
			if (enters(m_solid.surface().triangles()[f], hull.planes, m_slack)) return false;
		return m_solid.holds(center);
	}
	// A cell from the centre to each facet.
	std::priority_queue<Cell> wholeHull(double& attained) const
	{
		std::vector<Corner> known;
		const auto cornerOf = [&](const Vec3& p)
		{
			const auto same = std::find_if(known.begin(), known.end(), [&](const Corner& c) { return c.at == p; });
			if (same != known.end()) return *same;
			known.push_back(cornerAt(p));
			return known.back();
		};
		std::priority_queue<Cell> cells;
		for (const Triangle& t : m_hull.facets)
		{
			const Corners corner{cornerOf(m_center), cornerOf(t[0]), cornerOf(t[1]), cornerOf(t[2])};
			cells.push({corner, boundOf(corner, attained)});
		}
		return cells;
	}
	Finding branch() const
	{
		constexpr int kBudget = 1500;
		double attained = 0;
		std::priority_queue<Cell> open = wholeHull(attained);
		for (int i = 0; i < kBudget && open.top().bound > m_bound + m_slack; ++i)
		{
			if (attained > m_bound + m_slack) return {Verdict::broken, attained - m_bound};
			const Cell cell = open.top();
			open.pop();
			if (isCarriedInside(cell.corner))
			{
				if (open.empty()) return {};
				continue;
			}
			std::size_t from = 0, to = 1;
			for (std::size_t a = 0; a < 4; ++a)
				for (std::size_t b = a + 1; b < 4; ++b)
					if (length(cell.corner[a].at - cell.corner[b].at) >
						length(cell.corner[from].at - cell.corner[to].at))
					{
						from = a;
						to = b;
					}
			const Corner middle = cornerAt(0.5 * (cell.corner[from].at + cell.corner[to].at));
			for (const std::size_t moved : {from, to})
			{
				Corners half = cell.corner;
				half[moved] = middle;
				open.push({half, std::min(cell.bound, boundOf(half, attained))});
			}
		}
		if (attained > m_bound + m_slack) return {Verdict::broken, attained - m_bound};
		return {open.top().bound <= m_bound + m_slack ? Verdict::holds : Verdict::undecided, 0};
	}

	const LevelSolid& m_solid;
	const std::vector<Vec3>& m_points;
	Hull m_hull;
	Vec3 m_center;
	double m_radius = 0, m_bound, m_slack;
	std::vector<std::uint32_t> m_near;
};

void record(Tally& tally, std::uint64_t element, const Finding& found, const std::string& what)
{
	if (found.verdict == Verdict::undecided)
		tally.undecided();
	else
		tally.add(element, found.excess, what);
}
}  // namespace

Invariants checkDeviation(const Subject& s)
{
	const LevelSolid solid(s, s.h.levels()[0]);
	Tally surf("surf"), protrude("protrude");
	const Level& first = s.h.levels()[0];
	s.forEach("surf", s.h.faces().size - first.faceCount,
			  [&](std::size_t i)
			  {
				  const std::uint32_t f = first.faceCount + std::uint32_t(i);
				  const double bound = double(s.h.node(s.ownerOfFace[f]).surf);
				  const Finding found = judgeTriangle(solid.surface(), s.triangle(f), bound, s.slack);
				  record(surf, f, found,
						 fmt::format("face {} of node {} is {:.3g} farther from the input surface than surf {:.6g}", f,
									 s.ownerOfFace[f], found.excess, bound));
			  });
	s.forEach("protrude", s.h.nodes().size,
			  [&](std::size_t i)
			  {
				  const std::uint32_t node = std::uint32_t(i);
				  if (!s.isContact(node)) return;
				  const Node& n = s.h.node(node);
				  const std::vector<Vec3> points = s.thickHull(node);
				  const Vec3 inward{double(n.inward[0]), double(n.inward[1]), double(n.inward[2])};
				  const double bound = double(n.protrude);
				  const Finding found = Body(solid, points, bound, s.slack).judge(inward);
				  record(protrude, node, found,
						 fmt::format("the hull of node {} reaches {:.3g} farther out of the solid than protrude {:.6g}",
									 node, found.excess, bound));
			  });
	return {surf.result(), protrude.result()};
}
}  // namespace clod::check
