// SPDX-License-Identifier: GPL-3.0-or-later
// Thicknesses against the walls behind them, and flat hulls, which enclose nothing that the hull test could see.
//
// Wall: along a ray into the solid from a point of its surface, the distance to the first face that is left outward.
// A crossing near an edge may be missed by one program and met by another, so a wall is a bracket: the first crossing
// of faces grown by the slack, and the first of faces shrunk by it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "builder/check/LevelSolid.h"
#include "builder/check/Rounding.h"
#include "builder/check/Subject.h"

namespace clod::check
{
namespace
{
constexpr double kMost = 0.03;      // of the radius: the largest thickness of a face
constexpr double kRelative = 1e-4;  // of a thickness, for the rounding of the stored direction
constexpr double kRadius = 1e-6;    // the stored radius may exceed the one that thicknesses were cut at
constexpr double kBlind = 8;        // tolerances of a level: hulls thinner than this have a front to be looked at

struct Wall
{
	double low, high;  // infinite where nothing is met within the reach
};

// Distance along the ray where it leaves through the triangle, its edges moved outward by `grown`; negative if not.
double crossing(const Triangle& t, const Vec3& origin, const Vec3& direction, double grown)
{
	const Vec3 n = cross(t[1] - t[0], t[2] - t[0]);
	const double along = dot(n, direction);
	if (along <= 0) return -1;
	const double at = dot(n, t[0] - origin) / along;
	const Vec3 p = origin + at * direction;
	for (std::size_t e = 0; e < 3; ++e)
	{
		const Vec3 edge = t[(e + 1) % 3] - t[e];
		if (dot(cross(normalized(n), edge), p - t[e]) < -grown * length(edge)) return -1;
	}
	return at;
}

Wall wallBehind(const Subject& s, const TriangleTree& surface, const Vec3& origin, const Vec3& direction, double limit)
{
	constexpr double kNone = std::numeric_limits<double>::infinity();
	Wall wall{kNone, kNone};
	Box box;
	box.add(origin);
	box.add(origin + limit * direction);
	box.grow(s.slack);
	for (const std::uint32_t f : surface.overlapping(box))
	{
		const double possible = crossing(surface.triangles()[f], origin, direction, s.slack);
		const double certain = crossing(surface.triangles()[f], origin, direction, -s.slack);
		if (possible > -s.slack && possible <= limit) wall.low = std::min(wall.low, std::max(0.0, possible));
		if (certain > s.slack && certain <= limit) wall.high = std::min(wall.high, certain);
	}
	return wall;
}

// Of a face: half the wall behind the point of the input surface nearest to its centroid, at most 3 % of the radius. Of
// several points as near, to rounding, any will do. Of a scaled body no more than that.
void faceThickness(const Subject& s, const TriangleTree& surface, std::uint32_t f, Wall& wall, Tally& tally)
{
	const Triangle t = s.triangle(f);
	const float(&n)[3] = s.h.faces()[f].normal;
	const Vec3 middle = (1.0 / 3) * (t[0] + t[1] + t[2]);
	const double most = kMost * s.radius;
	const float stored = s.h.faces()[f].thickness;
	const double limit = surface.nearest(middle).distance + s.slack;
	Box box;
	box.add(middle);
	box.grow(limit);
	bool sound = false;
	for (const std::uint32_t other : surface.overlapping(box))
	{
		const Vec3 origin = nearestOn(surface.triangles()[other], middle);
		if (sound || length(origin - middle) > limit) continue;
		wall = wallBehind(s, surface, origin, {-double(n[0]), -double(n[1]), -double(n[2])}, 2.1 * most);
		// One number where nothing is undecided, and then to the last bit.
		const double room = wall.low == wall.high ? 1e-12 * s.radius : s.slack;
		const double low = std::min(most, 0.5 * wall.low), high = std::min(most, 0.5 * wall.high);
		const double between = 0.5 * (low * (1 - kRadius) + high * (1 + kRadius));
		const double noise = 0.5 * (high - low) + kRadius * between + room;
		sound = s.h.isScaled() ? double(stored) <= between + noise : isGridBelow(stored, between, noise);
	}
	tally.add(f, sound ? 0 : 1,
			  fmt::format("face {}: thickness {:.9g} is not half the wall [{:.9g}, {:.9g}] behind it", f,
						  double(stored), wall.low, wall.high));
}

// Nothing is met so far behind a face's middle, but where rounding decides.
void clearWay(const Subject& s, const TriangleTree& surface, std::uint32_t f, double far, Tally& tally)
{
	const Triangle t = s.triangle(f);
	const Vec3 inward = -toVec3(s.h.faces()[f].normal);
	const Wall wall = wallBehind(s, surface, (1.0 / 3) * (t[0] + t[1] + t[2]), inward, far);
	const bool isShort = wall.low == wall.high && wall.low > double(s.h.asset().storageTolerance);
	tally.add(f, isShort ? far - wall.low : 0, fmt::format("face {}: the wall behind it is {:.6g}", f, wall.low));
}

// Of a level 0 node: at most half the largest wall met along `inward` from its faces; at most half the smallest where
// there are so few that the builder looks at all of them.
void nodeThickness(const Subject& s, const TriangleTree& surface, std::uint32_t i, Tally& tally)
{
	constexpr std::uint32_t kAllLookedAt = 16;
	const Node& n = s.h.node(i);
	if (n.thickness == 0) return tally.hold();
	const Vec3 inward = (1 / double(n.thickness)) * s.sweep(n);
	double least = 1e300, most = 0;
	for (std::uint32_t f = n.firstFace; f < n.firstFace + n.faceCount; ++f)
	{
		const Triangle t = s.triangle(f);
		if (dot(cross(t[1] - t[0], t[2] - t[0]), inward) >= 0) continue;
		const double wall =
			wallBehind(s, surface, (1.0 / 3) * (t[0] + t[1] + t[2]), inward, 2.1 * double(n.thickness)).high;
		least = std::min(least, wall);
		most = std::max(most, wall);
	}
	const double half = 0.5 * (n.faceCount <= kAllLookedAt ? least : most) * (1 + kRelative) + s.slack;
	tally.add(
		i, double(n.thickness) - half,
		fmt::format("node {}: thickness {:.6g} exceeds half the wall behind it, {:.6g}", i, double(n.thickness), half));
}

// Corners of the convex hull of points of a plane, counter-clockwise (Andrew's monotone chain).
std::vector<std::array<double, 2>> outlineOf(std::vector<std::array<double, 2>> points)
{
	std::sort(points.begin(), points.end());
	std::vector<std::array<double, 2>> chain;
	for (int pass = 0; pass < 2; ++pass)
	{
		const std::size_t start = chain.size();
		for (const auto& p : points)
		{
			while (chain.size() >= start + 2)
			{
				const auto &a = chain[chain.size() - 2], &b = chain.back();
				if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
				chain.pop_back();
			}
			chain.push_back(p);
		}
		chain.pop_back();
		std::reverse(points.begin(), points.end());
	}
	return chain;
}

// Points of a flat patch's outline that no face of the patch covers must lie next to the level's surface, or under it.
void flatHull(const Subject& s, const LevelSolid& solid, std::uint32_t i, double eps, Tally& tally)
{
	const Node& n = s.h.node(i);
	const HullView hull = s.h.hull(n);
	const float(&mean)[3] = n.meanNormal;
	const Vec3 normal = normalized({double(mean[0]), double(mean[1]), double(mean[2])}), origin = hull.vertex(0);
	const Vec3 u = normalized(cross(normal, std::abs(normal.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 0, 1}));
	const Vec3 v = cross(normal, u);
	std::vector<std::array<double, 2>> flat;
	double low = 0, high = 0;
	for (std::uint32_t k = 0; k < n.vertexCount; ++k)
	{
		const Vec3 d = hull.vertex(k) - origin;
		low = std::min(low, dot(normal, d));
		high = std::max(high, dot(normal, d));
		flat.push_back({dot(u, d), dot(v, d)});
	}
	if (high - low > kBlind * eps || n.vertexCount <= 3) return tally.hold();
	const auto outline = outlineOf(flat);
	constexpr int kSteps = 8;
	double excess = 0;
	for (std::size_t k = 1; k + 1 < outline.size(); ++k)
		for (int a = 1; a < kSteps; ++a)
			for (int b = 1; a + b < kSteps; ++b)
			{
				const double x = double(a) / kSteps, y = double(b) / kSteps;
				std::array<double, 2> p;
				for (std::size_t c = 0; c < 2; ++c)
					p[c] = (1 - x - y) * outline[0][c] + x * outline[k][c] + y * outline[k + 1][c];
				const Vec3 point = origin + p[0] * u + p[1] * v + 0.5 * (low + high) * normal;
				const double beyond = solid.surface().nearest(point).distance - 2 * kBlind * eps - s.slack;
				if (beyond > excess && !solid.holds(point)) excess = beyond;
			}
	tally.add(i, excess, fmt::format("node {}: its flat hull spans open space, {:.3g} off the surface", i, excess));
}
}  // namespace

Invariants checkWalls(const Subject& s)
{
	Tally faces("face-thickness"), nodes("node-thickness"), thinnest("thinnest-wall"), flat("flat-hulls");
	const Level& first = s.h.levels()[0];
	const TriangleTree surface(s.levelTriangles(first));
	std::vector<Wall> walls(s.h.faces().size);
	s.forEach("face-thickness", walls.size(),
			  [&](std::size_t f) { faceThickness(s, surface, std::uint32_t(f), walls[f], faces); });
	s.forEach("node-thickness", first.nodeCount,
			  [&](std::size_t i) { nodeThickness(s, surface, std::uint32_t(i), nodes); });
	// Walls were followed as far as faces may be thick; a model all thicker is looked through once more, as far as it
	// says.
	Wall least{2.1 * kMost * s.radius, 2.1 * kMost * s.radius};
	walls.resize(first.faceCount);
	const double rounding = double(s.h.asset().storageTolerance) * (1 - kRadius);  // nothing thinner is a wall
	for (const Wall& wall : walls)
		least = {std::min(least.low, wall.low > rounding ? wall.low : least.low),
				 std::min(least.high, wall.high > rounding ? wall.high : least.high)};
	const double stored = double(s.h.asset().thinnestWall);
	const bool isThick = least.low >= 2.1 * kMost * s.radius;
	if (isThick)
	{
		const double far = stored * (1 - kStored) - s.slack;
		s.forEach("thinnest-wall", first.faceCount, [&](std::size_t f) { clearWay(s, surface, std::uint32_t(f), far, thinnest); });
	}
	const double room = 1e-12 * s.radius;
	const bool isSharp = !isThick && least.low == least.high;
	const double between = 0.5 * (least.low + least.high);
	const double noise = isSharp ? room : 0.5 * (least.high - least.low) + s.slack;
	const int roundings = s.h.isScaled() ? 2 : 1;  // a uniform scale's is that of what was rounded
	const bool sound = isThick ? stored >= least.low * (1 - kStored) - s.slack
							   : isGridBelow(s.h.asset().thinnestWall, between, noise, roundings);
	thinnest.add(first.faceCount, sound ? 0 : 1,
				 fmt::format("thinnest wall {:.6g} is not within [{:.6g}, {:.6g}]", stored, least.low, least.high));
	for (const Level& level : s.h.levels())
	{
		if (level.faceCount == 0) continue;
		const LevelSolid own(s, level);
		const double eps = std::max(double(level.patchTolerance), double(s.h.asset().storageTolerance));
		s.forEach("flat-hulls", level.nodeCount,
				  [&](std::size_t i) { flatHull(s, own, level.firstNode + std::uint32_t(i), eps, flat); });
	}
	return {faces.result(), nodes.result(), thinnest.result(), flat.result()};
}
}  // namespace clod::check
