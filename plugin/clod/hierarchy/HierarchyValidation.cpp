// SPDX-License-Identifier: Zlib
// The rules of Layout.h, first half: the asset record, index ranges and the shape of the graph.
#include <algorithm>

#include "clod/hierarchy/HierarchyRules.h"

namespace clod
{
std::string validate(const Hierarchy& hierarchy)
{
	for (const auto rule :
		 {rules::asset, rules::levels, rules::ranges, rules::children, rules::hulls, rules::nodeNumbers,
		  rules::monotone, rules::faces, rules::levelMaxima, rules::cullBoxes, rules::grid})
	{
		std::string problem = rule(hierarchy);
		if (!problem.empty()) return problem;
	}
	return "";
}

namespace rules
{
namespace
{
bool allFinite(const double* values, int count)
{
	return std::all_of(values, values + count, [](double v) { return std::isfinite(v); });
}
bool allFinite(const float* values, int count)
{
	return std::all_of(values, values + count, [](float v) { return std::isfinite(v); });
}

std::string assetFloats(const Asset& a)
{
	if (!allFinite(a.meshFromBody, 3)) return "asset: meshFromBody is not finite";
	if (!std::isfinite(a.volume) || a.volume <= 0) return "asset: volume is not positive";
	if (!allFinite(a.inertia, 6) || a.inertia[0] <= 0 || a.inertia[1] <= 0 || a.inertia[2] <= 0)
		return "asset: moments of inertia are not positive";
	const double* const q = a.principal;
	if (!allFinite(q, 4) || std::fabs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1) > 1e-9)
		return "asset: principal is not a unit quaternion";
	if (a.buildSeconds != 0 || std::signbit(a.buildSeconds)) return "asset: buildSeconds is not zero";
	if (!allFinite(a.sphereCenter, 3)) return "asset: sphereCenter is not finite";
	if (!std::isfinite(a.radius) || a.radius <= 0) return "asset: radius is not positive";
	return "";
}
}  // namespace

std::string asset(const Hierarchy& h)
{
	const Asset& a = h.asset();
	std::string problem = assetFloats(a);
	if (!problem.empty()) return problem;
	if (!allFinite(a.boxMin, 3) || !allFinite(a.boxMax, 3)) return "asset: box is not finite";
	for (int i = 0; i < 3; ++i)
		if (a.boxMin[i] > a.boxMax[i]) return "asset: box is inside out";
	if (!std::isfinite(a.storageTolerance) || a.storageTolerance <= 0) return "asset: storageTolerance is not positive";
	if (!std::isfinite(a.areaTolerance) || a.areaTolerance <= 0) return "asset: areaTolerance is not positive";
	if (!std::isfinite(a.thinnestWall) || a.thinnestWall < 0) return "asset: thinnestWall is negative";
	if ((a.flags & ~(kPaperBuild | kScaled)) != 0) return "asset: unknown flags";
	if (a.componentCount == 0) return "asset: componentCount is zero";
	if (a.padding[0] != 0 || a.padding[1] != 0) return "asset: padding is not zero";
	if (!h.isCoarse() && a.triangleCount != h.levels()[0].faceCount)
		return "asset: triangleCount is not the number of level 0 faces";
	return "";
}

std::string levels(const Hierarchy& h)
{
	std::uint64_t node = 0, face = 0;
	for (std::size_t i = 0; i < h.levels().size; ++i)
	{
		const Level& level = h.levels()[i];
		const std::string name = element("level", i);
		if (level.firstNode != node || level.firstFace != face) return name + "does not follow the level before it";
		if (level.nodeCount == 0) return name + "has no nodes";
		if (i > 0 && level.nodeCount >= h.levels()[i - 1].nodeCount)
			return name + "is not smaller than the level before it";
		if ((level.flags & ~kClodNode) != 0) return name + "unknown flags";
		if (i == 0 && level.flags != kClodNode) return name + "is not a contact level";
		if (i > 0 && level.flags > h.levels()[i - 1].flags) return name + "is a contact level above a completion level";
		if ((level.faceCount == 0) != (level.flags == 0)) return name + "has real faces exactly where it must not";
		if (level.padding != 0) return name + "padding is not zero";
		if (!std::isfinite(level.patchTolerance) || level.patchTolerance < 0)
			return name + "patchTolerance is negative";
		node += level.nodeCount;
		face += level.faceCount;
	}
	if (node != h.nodes().size) return "levels: they hold " + std::to_string(node) + " nodes, not all";
	if (face != h.faces().size) return "levels: they hold " + std::to_string(face) + " faces, not all";
	if (h.levels()[h.levels().size - 1].nodeCount != 1) return "levels: the last one is not a single root";
	return "";
}

std::string ranges(const Hierarchy& h)
{
	std::uint64_t child = 0, vertex = 0, face = 0;
	std::size_t level = 0;
	for (std::size_t i = 0; i < h.nodes().size; ++i)
	{
		while (i >= std::uint64_t(h.levels()[level].firstNode) + h.levels()[level].nodeCount) ++level;
		const Node& n = h.nodes()[i];
		const std::string name = element("node", i);
		if (n.level != level) return name + "level " + std::to_string(n.level) + " is not " + std::to_string(level);
		if (n.flags != h.levels()[level].flags) return name + "flags are not its level's";
		if (n.firstChild != child || n.firstVertex != vertex || n.firstFace != face)
			return name + "children, vertices or faces do not follow those of the node before it";
		if (n.vertexCount == 0 || n.vertexCount > h.hullSize()) return name + "impossible number of vertices";
		if ((n.faceCount == 0) != (n.flags == 0)) return name + "has real faces exactly where it must not";
		for (std::uint32_t word : n.padding)
			if (word != 0) return name + "padding is not zero";
		child += n.childCount;
		vertex += (std::uint64_t(n.vertexCount) + kVertexLanes - 1) / kVertexLanes * kVertexLanes;
		face += n.faceCount;
		if (child > h.childrenSize()) return name + "too many children";
		if (vertex > h.hullSize()) return name + "vertices end outside the file";
		const Level& l = h.levels()[level];
		if (n.firstFace < l.firstFace || face > std::uint64_t(l.firstFace) + l.faceCount)
			return name + "faces lie outside its level";
	}
	if (child != h.childrenSize()) return "nodes: " + std::to_string(child) + " children are used, not all";
	if (vertex != h.hullSize()) return "nodes: " + std::to_string(vertex) + " vertices are used, not all";
	if (face != h.faces().size) return "nodes: " + std::to_string(face) + " faces are used, not all";
	return "";
}

namespace
{
std::string childrenOf(const Hierarchy& h, std::size_t i, std::vector<std::uint8_t>& hasParent)
{
	const Node& n = h.nodes()[i];
	const std::string name = element("node", i);
	if ((n.childCount == 0) != (n.level == 0)) return name + "has children exactly where it must not";
	if (n.primaryChildCount > n.childCount) return name + "more primary children than children";
	if (n.level > 0 && n.primaryChildCount == 0) return name + "has no primary child";
	if (h.isPaperBuild() && n.primaryChildCount != n.childCount) return name + "shared children in a paper build";
	std::vector<std::uint32_t> list(h.children(n).begin(), h.children(n).end());
	for (std::size_t k = 0; k < list.size(); ++k)
	{
		if (list[k] >= h.nodes().size) return name + "child " + std::to_string(list[k]) + " does not exist";
		if (h.nodes()[list[k]].level >= n.level)
			return name + "child " + std::to_string(list[k]) + " is not of a finer level";
		if (k < n.primaryChildCount && hasParent[list[k]]++)
			return element("node", list[k]) + "has two primary parents";
	}
	std::sort(list.begin(), list.end());
	if (std::adjacent_find(list.begin(), list.end()) != list.end()) return name + "the same child twice";
	return "";
}
}  // namespace

std::string children(const Hierarchy& h)
{
	std::vector<std::uint8_t> hasParent(h.nodes().size, 0);
	for (std::size_t i = 0; i < h.nodes().size; ++i)
	{
		std::string problem = childrenOf(h, i, hasParent);
		if (!problem.empty()) return problem;
	}
	for (std::size_t i = 0; i + 1 < h.nodes().size; ++i)
		if (!hasParent[i]) return element("node", i) + "has no primary parent";
	return "";
}
}  // namespace rules
}  // namespace clod
