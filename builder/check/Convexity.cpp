// SPDX-License-Identifier: GPL-3.0-or-later
// Patches are convex and do not poke out through their virtual faces, within the level's stored tolerance eps:
//   G1  no vertex of a patch lies more than 2 eps above a face of it (exact: double with an error bound, then
//   rationals); G2  no other face of the level enters the hull deeper than 4 eps under all its planes (hull by CGAL).
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <fmt/format.h>

#include <algorithm>

#include "builder/check/Subject.h"

namespace clod::check
{
namespace
{
double toleranceOf(const Subject& s, const Level& level)
{
	return std::max(double(level.patchTolerance), double(s.h.asset().storageTolerance));
}

// Whether p lies more than `bound` above the plane of the triangle, decided exactly.
bool liesAbove(const Triangle& t, const Vec3& p, double bound)
{
	const Vec3 a = t[1] - t[0], b = t[2] - t[0], q = p - t[0];
	const Vec3 n = cross(a, b);
	const double height = dot(n, q), limit = bound * length(n);
	const double error = 1e-14 * length(a) * length(b) * length(q) + 1e-14 * limit;
	if (height <= limit - error) return false;
	if (height > limit + error) return true;
	using Number = CGAL::Exact_predicates_exact_constructions_kernel::FT;
	const auto exact = [](const Vec3& v) { return std::array<Number, 3>{Number(v.x), Number(v.y), Number(v.z)}; };
	const auto o = exact(t[0]), e1 = exact(t[1]), e2 = exact(t[2]), e3 = exact(p);
	std::array<Number, 3> x, y, z;
	for (std::size_t i = 0; i < 3; ++i)
	{
		x[i] = e1[i] - o[i];
		y[i] = e2[i] - o[i];
		z[i] = e3[i] - o[i];
	}
	const std::array<Number, 3> m = {x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
	const Number along = m[0] * z[0] + m[1] * z[1] + m[2] * z[2];
	const Number squared = m[0] * m[0] + m[1] * m[1] + m[2] * m[2];
	return along > Number(0) && along * along > Number(bound) * Number(bound) * squared;
}

double heightAbove(const Triangle& t, const Vec3& p)
{
	return dot(normalized(cross(t[1] - t[0], t[2] - t[0])), p - t[0]);
}

void localConvexity(const Subject& s, std::uint32_t node, double bound, Tally& tally)
{
	for (std::uint32_t f = s.h.node(node).firstFace; f < s.h.node(node).firstFace + s.h.node(node).faceCount; ++f)
		for (const std::uint32_t other : s.h.faces()[f].neighbour)
		{
			if (s.ownerOfFace[other] != node) continue;
			const Triangle t = s.triangle(f);
			double excess = 0;
			for (const Vec3& p : s.triangle(other))
				if (liesAbove(t, p, bound)) excess = std::max(excess, heightAbove(t, p) - bound);
			tally.add(f, excess,
					  fmt::format("faces {} and {} of node {} are reflex by {:.3g}", f, other, node, excess));
		}
}

void facesOnHull(const Subject& s, std::uint32_t node, double bound, Tally& tally)
{
	const HullView hull = s.h.hull(s.h.node(node));
	for (std::uint32_t f = s.h.node(node).firstFace; f < s.h.node(node).firstFace + s.h.node(node).faceCount; ++f)
	{
		const Triangle t = s.triangle(f);
		double excess = 0;
		for (std::uint32_t v = 0; v < hull.count; ++v)
			if (liesAbove(t, hull.vertex(v), bound)) excess = std::max(excess, heightAbove(t, hull.vertex(v)) - bound);
		tally.add(f, excess,
				  fmt::format("a vertex of node {} lies {:.3g} too high above its face {}", node, excess, f));
	}
}

void noForeignFace(const Subject& s, std::uint32_t node, const TriangleTree& faces, double eps, Tally& tally)
{
	const Node& n = s.h.node(node);
	const Level& level = s.h.levels()[n.level];
	std::vector<Vec3> points;
	for (std::uint32_t v = 0; v < n.vertexCount; ++v) points.push_back(s.h.hull(n).vertex(v));
	const Hull hull = hullOf(points, 1e-9 * s.radius);
	if (!hull.solid)
	{
		tally.hold();
		return;
	}
	double excess = 0;
	std::uint32_t intruder = kNone;
	for (const std::uint32_t local : faces.overlapping(boxOf(points)))
	{
		const std::uint32_t f = level.firstFace + local;
		if (s.ownerOfFace[f] == node || !enters(faces.triangles()[local], hull.planes, 4 * eps + s.slack)) continue;
		intruder = std::min(intruder, f);
		for (double depth = 8 * eps; depth < s.radius; depth *= 2)
			if (enters(faces.triangles()[local], hull.planes, depth)) excess = std::max(excess, depth - 4 * eps);
		excess = std::max(excess, s.slack);
	}
	tally.add(node, excess,
			  fmt::format("face {} enters the hull of node {} by {:.3g} or more", intruder, node, excess));
}

}  // namespace

Invariants checkConvexity(const Subject& s)
{
	Tally edges("edges-convex"), planes("faces-on-hull"), foreign("no-foreign-face");
	for (const Level& level : s.h.levels())
	{
		const double eps = toleranceOf(s, level) * (1 + 1e-6);
		const TriangleTree faces(s.levelTriangles(level));
		s.forEach("convexity", level.nodeCount,
				  [&](std::size_t i)
				  {
					  const std::uint32_t node = level.firstNode + std::uint32_t(i);
					  if (!s.isContact(node)) return;
					  localConvexity(s, node, eps, edges);
					  facesOnHull(s, node, 2 * eps, planes);
					  noForeignFace(s, node, faces, eps, foreign);
				  });
	}
	return {edges.result(), planes.result(), foreign.result()};
}
}  // namespace clod::check
