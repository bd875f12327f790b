// SPDX-License-Identifier: Zlib
#include "clod/query/TraversalTables.h"

#include <algorithm>

#include "clod/query/Constants.h"

namespace clod
{
namespace
{
// None of a node at the base or below.
Span<std::uint32_t> primaryChildren(const Hierarchy& h, std::uint32_t node, std::uint32_t base)
{
	const Node& n = h.node(node);
	return {h.children(n).data, n.level > base ? n.primaryChildCount : 0U};
}
// Which of the descendants listed so far to replace by its children: the largest that leaves room; their number:
// none.
std::size_t widest(const Hierarchy& h, std::uint32_t base, const std::uint32_t* listed, std::size_t count)
{
	std::size_t best = count;
	for (std::size_t i = 0; i < count; ++i)
	{
		const std::size_t children = primaryChildren(h, listed[i], base).size;
		if (children == 0 || count - 1 + children > kCollapsedChildren) continue;
		if (best == count || h.cullBox(listed[i]).radius > h.cullBox(listed[best]).radius) best = i;
	}
	return best;
}
// A ball or a capsule is met where it reaches, not where its core is (ConvexPiece.h).
double grownBy(const Hierarchy& h)
{
	return h.isThinCore() ? std::max(0.0, double(h.asset().radius) - double(h.cullBox(h.root()).radius)) : 0;
}
void addBox(const OrientedBox& box, double grown, LevelBounds& bounds)
{
	const double x = 2 * (double(box.half[0]) + grown), y = 2 * (double(box.half[1]) + grown),
				 z = 2 * (double(box.half[2]) + grown);
	bounds.boxes += 1;
	bounds.volume += x * y * z;
	bounds.area += 2 * (x * y + y * z + z * x);
	bounds.edges += x + y + z;
}
bool keepLimit(const LevelBounds& a, const LevelBounds& b, double maxError)
{
	const double cover = double(a.cover) + double(b.cover), protrude = double(a.protrude) + double(b.protrude);
	return b.isWhole && std::max(cover, protrude) <= maxError;
}
}  // namespace

TraversalTables::TraversalTables(const Hierarchy& hierarchy)
{
	boundLevels(hierarchy);
	for (std::uint32_t level = 0; level <= hierarchy.coarsestClodLevel(); ++level)
		m_collapsed.push_back(collapse(hierarchy, level));
}

// Collapses the tree of primary children above a level (collapsedChildren). Parents lie behind their
// children.
TraversalTables::CollapsedTree TraversalTables::collapse(const Hierarchy& h, std::uint32_t base)
{
	CollapsedTree tree;
	std::vector<std::uint32_t>& list = tree.children;
	const Level& level = h.levels()[base];
	tree.firstNode = level.firstNode + level.nodeCount;
	const std::size_t count = h.nodes().size - tree.firstNode;
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

void TraversalTables::boundLevels(const Hierarchy& h)
{
	m_bounds.resize(h.coarsestClodLevel() + 1);
	const double grown = grownBy(h);
	for (const Node& node : h.nodes())
	{
		for (const std::uint32_t child : h.children(node))
			for (std::uint32_t k = h.node(child).level + 1U; k < node.level && k < m_bounds.size(); ++k)
				m_bounds[k].isWhole = false;
		if (node.level >= m_bounds.size()) continue;
		LevelBounds& bounds = m_bounds[node.level];
		bounds.cover = std::max(bounds.cover, node.cover);
		bounds.protrude = std::max(bounds.protrude, node.protrude);
		bounds.isWhole = bounds.isWhole && (node.flags & kClodNode) != 0;
		addBox(h.cullBox(std::uint32_t(&node - h.nodes().begin())), grown, bounds);
	}
}

BaseLevels chooseBaseLevels(const TraversalTables& a, const TraversalTables& b, double maxError, bool isAlone)
{
	struct Choice
	{
		BaseLevels levels;
		double pairs, meeting;
	};
	const auto choiceOf = [&](std::uint32_t levelA, std::uint32_t levelB)
	{
		const LevelBounds &ofA = a.bounds(levelA), &ofB = b.bounds(levelB);
		return Choice{{levelA, levelB}, ofA.boxes * ofB.boxes, meetingBoxes(ofA, ofB)};
	};
	Choice fewest = choiceOf(0, 0), slimmest = fewest;
	std::uint32_t levelB = b.coarsestLevel();
	for (std::uint32_t levelA = 0; levelA <= a.coarsestLevel(); ++levelA)
	{
		if (!a.bounds(levelA).isWhole) continue;
		while (levelB > 0 && !keepLimit(a.bounds(levelA), b.bounds(levelB), maxError)) --levelB;
		if (!keepLimit(a.bounds(levelA), b.bounds(levelB), maxError)) break;
		const Choice next = choiceOf(levelA, levelB);
		if (next.pairs < fewest.pairs) fewest = next;
		if (next.meeting < slimmest.meeting) slimmest = next;
	}
	const Choice& best = slimmest.meeting < kFewer * fewest.meeting ? slimmest : fewest;
	return best.levels.isOfLeaves() || isAlone ? best.levels : BaseLevels{};
}
}  // namespace clod
