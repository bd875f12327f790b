// SPDX-License-Identifier: Zlib
// The rules of Layout.h, second half: floats, hulls, certified numbers, faces and culling boxes. Indices are proved.
#include <algorithm>
#include <limits>
#include <utility>

#include "clod/hierarchy/BoundGrid.h"
#include "clod/hierarchy/HierarchyRules.h"

namespace clod::rules
{
namespace
{
constexpr double kUnitTolerance = 1e-5;  // of the squared length of a stored unit vector, axes of boxes apart

bool sound(float v)
{
	return std::isfinite(v) && v >= 0;
}

std::string nodeVectors(const Node& n)
{
	if (!isUnit(toVec3(n.inward), kUnitTolerance)) return "inward is not a unit vector";
	if (!std::isfinite(n.curvature)) return "curvature is not finite";
	if (n.flags == 0)
	{
		if (toVec3(n.meanNormal) != Vec3{} || n.coneCosine != -1) return "a completion node has no mean normal";
		return n.thickness == 0 ? "" : "a completion node has no thickness";
	}
	if (!isUnit(toVec3(n.meanNormal), kUnitTolerance)) return "meanNormal is not a unit vector";
	return n.coneCosine >= -1 && n.coneCosine <= 1 ? "" : "coneCosine is outside [-1, 1]";
}

std::string nodeBounds(const Hierarchy& h, const Node& n)
{
	if (!sound(n.thickness)) return "thickness is not a length";
	if (!sound(n.cover) || !sound(n.reach) || !sound(n.protrude) || !sound(n.surf))
		return "a certified number is not a length";
	if (!sound(n.deviation) || n.deviation != std::max({n.cover, n.protrude, n.surf}))
		return "deviation is not the largest of cover, protrude and surf";
	if (n.reach < n.cover) return "reach is less than cover";
	if (!sound(n.resolution)) return "resolution is not finite";
	if (!sound(n.hausdorff)) return "hausdorff is not a length";
	if (!std::isfinite(n.contactArea) || n.contactArea <= 0) return "contactArea is not positive";
	if (n.flags == 0)
		return n.featureVolume == std::numeric_limits<float>::infinity()
				   ? ""
				   : "featureVolume of a completion node is not infinite";
	if (!sound(n.featureVolume)) return "featureVolume is not finite";
	const bool zero =
		n.cover == 0 && n.reach == 0 && n.surf == 0 && n.resolution == 0 && n.featureVolume == 0 && n.hausdorff == 0;
	return n.level > 0 || h.isCoarse() || zero ? ""
							   : "cover, reach, surf, resolution, featureVolume and hausdorff must be 0 at level 0";
}

// The point's distance to the box along each axis must be inside half.
bool encloses(const OrientedBox& box, const Vec3& p)
{
	const Vec3 d = p - toVec3(box.center);
	if (lengthSquared(d) > double(box.radius) * double(box.radius)) return false;
	for (int i = 0; i < 3; ++i)
		if (std::fabs(dot(toVec3(box.axis[i]), d)) > double(box.half[i])) return false;
	return true;
}

// From the origin.
double farthestCorner(const OrientedBox& box)
{
	double squared = 0;
	for (int i = 0; i < 3; ++i)
	{
		const double far = std::fabs(dot(toVec3(box.axis[i]), toVec3(box.center))) + double(box.half[i]);
		squared += far * far;
	}
	return std::sqrt(squared);
}

std::string boxFrame(const OrientedBox& box)
{
	if (!isFinite(toVec3(box.center)) || !sound(box.radius)) return "culling sphere is not finite";
	for (int i = 0; i < 3; ++i)
	{
		if (!sound(box.half[i])) return "half extent of the culling box is not a length";
		if (!isUnit(toVec3(box.axis[i]), kAxisTolerance)) return "axis of the culling box is not a unit vector";
		if (!(std::fabs(dot(toVec3(box.axis[i]), toVec3(box.axis[(i + 1) % 3]))) <= kAxisTolerance))
			return "axes of the culling box are not perpendicular";
	}
	return "";
}
}  // namespace

std::string hulls(const Hierarchy& h)
{
	const Asset& a = h.asset();
	for (std::size_t i = 0; i < h.nodes().size; ++i)
	{
		const HullView hull = h.hull(h.nodes()[i]);
		for (std::uint32_t v = 0; v < hull.padded; ++v)
		{
			const float p[3] = {hull.x[v], hull.y[v], hull.z[v]};
			if (!isFinite(toVec3(p))) return element("node", i) + "hull vertex is not finite";
			if (v >= hull.count && hull.vertex(v) != hull.vertex(hull.count - 1))
				return element("node", i) + "hull padding does not repeat the last vertex";
			for (int k = 0; k < 3; ++k)
				if (p[k] < a.boxMin[k] || p[k] > a.boxMax[k])
					return element("node", i) + "hull vertex outside the asset's box";
			if (h.nodes()[i].level == 0 && !h.isCoarse() &&
				length(toVec3(p) - toVec3(a.sphereCenter)) > double(a.radius))
				return element("node", i) + "input vertex outside the bounding sphere";
		}
	}
	return "";
}

std::string nodeNumbers(const Hierarchy& h)
{
	for (std::size_t i = 0; i < h.nodes().size; ++i)
	{
		std::string problem = nodeBounds(h, h.nodes()[i]);
		if (problem.empty()) problem = nodeVectors(h.nodes()[i]);
		if (!problem.empty()) return element("node", i) + problem;
	}
	return "";
}

std::string monotone(const Hierarchy& h)
{
	for (std::size_t i = 0; i < h.nodes().size; ++i)
	{
		const Node& n = h.nodes()[i];
		for (std::uint32_t c : h.children(n))
		{
			const Node& child = h.node(c);
			const std::string name = element("node", i) + "less than that of child " + std::to_string(c) + ": ";
			if (n.cover < child.cover) return name + "cover";
			if (n.reach < child.reach) return name + "reach";
			if (n.protrude < child.protrude) return name + "protrude";
			if (n.surf < child.surf) return name + "surf";
			if (n.featureVolume < child.featureVolume) return name + "featureVolume";
			if (n.contactArea > child.contactArea)
				return element("node", i) + "contactArea exceeds that of child " + std::to_string(c);
			if (child.resolution > 0 && (n.resolution == 0 || n.resolution > child.resolution))
				return element("node", i) + "resolution exceeds that of child " + std::to_string(c);
		}
	}
	return "";
}

namespace
{
std::string faceRecord(const Hierarchy& h, const Node& n, const Face& f)
{
	for (int i = 0; i < 3; ++i)
		if (f.vertex[i] >= n.vertexCount) return "vertex index outside its node";
	if (f.vertex[0] == f.vertex[1] || f.vertex[1] == f.vertex[2] || f.vertex[2] == f.vertex[0])
		return "the same vertex twice";
	if (f.padding != 0) return "padding is not zero";
	if (!sound(f.thickness)) return "thickness is not a length";
	if (!isUnit(toVec3(f.normal), kUnitTolerance)) return "normal is not a unit vector";
	const HullView hull = h.hull(n);
	const Vec3 normal = toVec3(f.normal), p0 = hull.vertex(f.vertex[0]), p1 = hull.vertex(f.vertex[1]),
			   p2 = hull.vertex(f.vertex[2]);
	if (p0 == p1 || p1 == p2 || p2 == p0) return "two corners in one place";
	const double height = std::max({dot(normal, p0), dot(normal, p1), dot(normal, p2)});
	if (!std::isfinite(f.offset) || double(f.offset) < height) return "offset is below a vertex";
	if (double(f.offset) > height + double(h.asset().storageTolerance)) return "offset is above every vertex";
	const Vec3 area = cross(p1 - p0, p2 - p0);
	if (area != Vec3{} && dot(area, normal) <= 0) return "normal points inward";
	if (dot(normal, toVec3(n.meanNormal)) < double(n.coneCosine) - kUnitTolerance)
		return "normal outside its node's cone";
	const bool hasNone = n.level > 0 || h.isCoarse();
	return (f.source == kNone) == hasNone ? "" : "source belongs to level 0 faces and only to them";
}

// The neighbour across edge e lies in the same level and holds the same edge, reversed, with this face across it.
std::string faceNeighbour(const Hierarchy& h, const std::vector<std::uint32_t>& owner, std::size_t index, int e)
{
	const Face& f = h.faces()[index];
	const Node& n = h.node(owner[index]);
	const Level& level = h.levels()[n.level];
	const std::uint32_t other = f.neighbour[e];
	if (other < level.firstFace || other - level.firstFace >= level.faceCount) return "neighbour outside its level";
	const Node& m = h.node(owner[other]);
	const Vec3 from = h.hull(n).vertex(f.vertex[e]), to = h.hull(n).vertex(f.vertex[(e + 1) % 3]);
	for (int k = 0; k < 3; ++k)
	{
		const Face& g = h.faces()[other];
		if (g.neighbour[k] != index || g.vertex[k] >= m.vertexCount || g.vertex[(k + 1) % 3] >= m.vertexCount) continue;
		if (h.hull(m).vertex(g.vertex[k]) == to && h.hull(m).vertex(g.vertex[(k + 1) % 3]) == from) return "";
	}
	return "neighbour " + std::to_string(other) + " does not share that edge";
}
}  // namespace

std::string faces(const Hierarchy& h)
{
	std::vector<std::uint32_t> owner(h.faces().size);
	for (std::uint32_t i = 0; i < h.nodes().size; ++i)
		for (std::uint32_t f = 0; f < h.node(i).faceCount; ++f) owner[h.node(i).firstFace + f] = i;
	std::vector<std::uint8_t> seen(h.isCoarse() ? 0 : h.asset().triangleCount, 0);
	for (std::size_t i = 0; i < h.faces().size; ++i)
	{
		const Face& f = h.faces()[i];
		std::string problem = faceRecord(h, h.node(owner[i]), f);
		if (problem.empty() && f.source != kNone && (f.source >= seen.size() || seen[f.source]++))
			problem = "source is not a triangle of its own";
		for (int e = 0; e < 3 && problem.empty(); ++e) problem = faceNeighbour(h, owner, i, e);
		if (!problem.empty()) return element("face", i) + problem;
	}
	return "";
}

std::string levelMaxima(const Hierarchy& h)
{
	for (std::size_t i = 0; i < h.levels().size; ++i)
	{
		const Level& level = h.levels()[i];
		float hausdorff = 0, deviation = 0, cover = 0, protrude = 0, surf = 0;
		for (std::uint32_t k = 0; k < level.nodeCount; ++k)
		{
			const Node& n = h.node(level.firstNode + k);
			hausdorff = std::max(hausdorff, n.hausdorff);
			deviation = std::max(deviation, n.deviation);
			cover = std::max(cover, n.cover);
			protrude = std::max(protrude, n.protrude);
			surf = std::max(surf, n.surf);
		}
		if (level.maxHausdorff != hausdorff || level.maxDeviation != deviation || level.maxCover != cover ||
			level.maxProtrude != protrude || level.maxSurf != surf)
			return element("level", i) + "a maximum is not that of its nodes";
	}
	return "";
}

// Every hull vertex, moved to both ends of the thickening segment, lies in the culling boxes of all primary ancestors.
std::string cullBoxes(const Hierarchy& h)
{
	std::vector<std::uint32_t> parent(h.nodes().size, kNone);
	for (std::uint32_t i = 0; i < h.nodes().size; ++i)
		for (std::uint32_t k = 0; k < h.node(i).primaryChildCount; ++k) parent[h.children(h.node(i))[k]] = i;
	const double radius = h.originRadius();
	for (std::uint32_t i = 0; i < h.nodes().size; ++i)
	{
		const std::string problem = boxFrame(h.cullBox(i));
		if (!problem.empty()) return element("node", i) + problem;
		if (!(farthestCorner(h.cullBox(i)) <= radius))
			return element("node", i) + "culling box is larger than the asset";
		const Node& n = h.node(i);
		const Vec3 sweep = double(n.thickness) * toVec3(n.inward);
		for (std::uint32_t v = 0; v < n.vertexCount; ++v)
			for (std::uint32_t box = i; box != kNone; box = parent[box])
				if (!encloses(h.cullBox(box), h.hull(n).vertex(v)) ||
					!encloses(h.cullBox(box), h.hull(n).vertex(v) + sweep))
					return element("node", i) + "its hull leaves the culling box of node " + std::to_string(box);
	}
	return "";
}

// Bounds and centres lie on the grid of BoundGrid.h. (Maxima of levels and deviations are copies of such bounds.)
std::string grid(const Hierarchy& h)
{
	const char* const off = " is off the grid of bounds";
	const Asset& a = h.asset();
	const auto anchored = [&a](const float(&c)[3])
	{ return std::all_of(c, c + 3, [&a](float v) { return isAnchor(v, a.radius); }); };
	if (!isBound(a.areaTolerance)) return std::string("asset: areaTolerance") + off;
	if (!isBound(a.thinnestWall)) return std::string("asset: thinnestWall") + off;
	if (!anchored(a.sphereCenter)) return std::string("asset: sphereCenter") + off;
	for (std::size_t i = 0; i < h.levels().size; ++i)
		if (!isBound(h.levels()[i].patchTolerance)) return element("level", i) + "patchTolerance" + off;
	for (std::uint32_t i = 0; i < h.nodes().size; ++i)
	{
		const Node& n = h.node(i);
		const std::pair<const char*, float> bounds[] = {{"thickness", n.thickness},
														{"cover", n.cover},
														{"reach", n.reach},
														{"protrude", n.protrude},
														{"surf", n.surf},
														{"resolution", n.resolution},
														{"featureVolume", n.featureVolume},
														{"contactArea", n.contactArea},
														{"hausdorff", n.hausdorff}};
		for (const auto& [name, value] : bounds)
			if (!isBound(value)) return element("node", i) + name + off;
		const OrientedBox& box = h.cullBox(i);
		for (const float v : {box.radius, box.half[0], box.half[1], box.half[2]})
			if (!isBound(v)) return element("node", i) + "the size of its culling box" + off;
		if (!anchored(box.center)) return element("node", i) + "the centre of its culling box" + off;
	}
	for (std::size_t i = 0; i < h.faces().size; ++i)
		if (!isBound(h.faces()[i].thickness)) return element("face", i) + "thickness" + off;
	return "";
}
}  // namespace clod::rules
