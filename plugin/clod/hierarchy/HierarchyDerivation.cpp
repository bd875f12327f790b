// SPDX-License-Identifier: Zlib
// What a loaded hierarchy adds to its file: trees that jump over levels, and levels as a whole.
#include <algorithm>
#include <cmath>

#include "clod/hierarchy/Hierarchy.h"

namespace clod
{
namespace
{
constexpr std::size_t kErrorsCounted = 24;
double errorCounted(const Hierarchy& hierarchy, std::size_t i)
{
	return std::ldexp(double(hierarchy.asset().radius), -int(i));
}
}  // namespace

struct HierarchyDerivation
{
	static void derive(Hierarchy& h)
	{
		for (std::uint32_t i = 0; i < h.m_levels.size; ++i)
			if (h.m_levels[i].flags & kClodNode) h.m_coarsestClodLevel = i;
		boundLevels(h);
		countFewest(h);
		for (std::uint32_t level = 0; level <= h.coarsestClodLevel(); ++level) h.m_wide.push_back(collapse(h, level));
	}

private:
	// None of a node at the base or below.
	static Span<std::uint32_t> primaryChildren(const Hierarchy& h, std::uint32_t node, std::uint32_t base)
	{
		const Node& n = h.node(node);
		return {h.children(n).data, n.level > base ? n.primaryChildCount : 0U};
	}
	// Which of the descendants listed so far to replace by its children: the largest that leaves room; their number:
	// none.
	static std::size_t widest(const Hierarchy& h, std::uint32_t base, const std::uint32_t* listed, std::size_t count)
	{
		std::size_t best = count;
		for (std::size_t i = 0; i < count; ++i)
		{
			const std::size_t children = primaryChildren(h, listed[i], base).size;
			if (children == 0 || count - 1 + children > kWideChildren) continue;
			if (best == count || h.cullBox(listed[i]).radius > h.cullBox(listed[best]).radius) best = i;
		}
		return best;
	}
	// Collapses the tree of primary children above a level (Hierarchy::wideChildren). Parents lie behind their
	// children.
	static Hierarchy::WideTree collapse(const Hierarchy& h, std::uint32_t base)
	{
		Hierarchy::WideTree tree;
		std::vector<std::uint32_t>& list = tree.children;
		const Level& level = h.m_levels[base];
		tree.firstNode = level.firstNode + level.nodeCount;
		const std::size_t count = h.m_nodes.size - tree.firstNode;
		tree.ranges.resize(count);
		std::vector<bool> isMet(count, false);
		if (count > 0) isMet.back() = true;
		for (std::uint32_t node = h.root() + 1; node-- > tree.firstNode;)
		{
			if (!isMet[node - tree.firstNode]) continue;
			const std::uint32_t first = std::uint32_t(list.size());
			for (const std::uint32_t child : primaryChildren(h, node, base)) list.push_back(child);
			for (;;)
			{
				const std::size_t listed = list.size() - first, i = widest(h, base, list.data() + first, listed);
				if (i == listed) break;
				const Span<std::uint32_t> finer = primaryChildren(h, list[first + i], base);
				list[first + i] = finer[0];
				list.insert(list.end(), finer.begin() + 1, finer.end());
			}
			for (std::size_t i = first; i < list.size(); ++i)
				if (list[i] >= tree.firstNode) isMet[list[i] - tree.firstNode] = true;
			tree.ranges[node - tree.firstNode] = {first, std::uint32_t(list.size() - first)};
		}
		return tree;
	}

	static void boundLevels(Hierarchy& h)
	{
		h.m_bounds.resize(h.coarsestClodLevel() + 1);
		for (const Node& node : h.m_nodes)
		{
			for (const std::uint32_t child : h.children(node))
				for (std::uint32_t k = h.node(child).level + 1U; k < node.level && k < h.m_bounds.size(); ++k)
					h.m_bounds[k].isWhole = false;
			if (node.level >= h.m_bounds.size()) continue;
			LevelBounds& bounds = h.m_bounds[node.level];
			bounds.cover = std::max(bounds.cover, node.cover);
			bounds.protrude = std::max(bounds.protrude, node.protrude);
			bounds.isWhole = bounds.isWhole && (node.flags & kClodNode) != 0;
			addBox(h.cullBox(std::uint32_t(&node - h.m_nodes.begin())), bounds);
		}
	}
	static void addBox(const OrientedBox& box, LevelBounds& bounds)
	{
		const double x = 2 * double(box.half[0]), y = 2 * double(box.half[1]), z = 2 * double(box.half[2]);
		bounds.boxes += 1;
		bounds.volume += x * y * z;
		bounds.area += 2 * (x * y + y * z + z * x);
		bounds.edges += x + y + z;
	}
	// A node is among the fewest within every error from its own up to its primary parent's.
	static void countFewest(Hierarchy& h)
	{
		// Of the errors counted, the first that is below the node's own.
		const auto firstBelow = [&](const Node& node)
		{
			const double error = std::max(node.cover, node.protrude);
			std::size_t i = 0;
			while ((node.flags & kClodNode) != 0 && i < kErrorsCounted && errorCounted(h, i) >= error) ++i;
			return i;
		};
		std::vector<std::int64_t> change(kErrorsCounted + 1, 0);
		const auto count = [&](std::size_t from, std::size_t end) { ++change[from], --change[end]; };
		count(0, firstBelow(h.node(h.root())));
		for (const Node& node : h.m_nodes)
		{
			const std::size_t above = firstBelow(node);
			for (std::uint32_t i = 0; i < node.primaryChildCount; ++i)
				count(above, std::max(above, firstBelow(h.node(h.children(node)[i]))));
		}
		std::int64_t sum = 0;
		for (std::size_t i = 0; i < kErrorsCounted; ++i) h.m_fewest.push_back(std::uint32_t(sum += change[i]));
	}
};

void deriveData(Hierarchy& hierarchy)
{
	HierarchyDerivation::derive(hierarchy);
}

// The root's box and the asset's box enclose everything: their farthest corner from the origin is at R. The corners of
// a box that fits what it encloses along each of its axes are then within sqrt(3) R; load() refuses others.
double Hierarchy::reach() const
{
	const OrientedBox& box = cullBox(root());
	const double half = std::sqrt(double(box.half[0]) * box.half[0] + double(box.half[1]) * box.half[1] +
								  double(box.half[2]) * box.half[2]);
	double squared = 0;
	for (int i = 0; i < 3; ++i)
	{
		const double far = std::max(std::abs(asset().boxMin[i]), std::abs(asset().boxMax[i]));
		squared += far * far;
	}
	return 1.7321 * std::max(std::sqrt(squared), length(toVec3(box.center)) + std::max(half, double(box.radius)));
}

std::uint32_t Hierarchy::fewestWithin(double error) const
{
	std::size_t i = 0;
	while (i + 1 < m_fewest.size() && errorCounted(*this, i) > error) ++i;
	return errorCounted(*this, i) > error ? m_levels[0].nodeCount : m_fewest[i];
}
}  // namespace clod
