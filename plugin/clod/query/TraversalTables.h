// SPDX-License-Identifier: Zlib
// What traversals derive from a hierarchy (Hierarchy::derived): trees that jump over levels, and levels as a whole. Read
// only once made; O(nodes) to make.
#pragma once
#include <vector>

#include "clod/Export.h"
#include "clod/collide/BoxSeparation.h"
#include "clod/hierarchy/Hierarchy.h"

namespace clod
{
// One level of each body that answers all contacts of a query: what a certified limit, the same everywhere, is kept by.
// No node above them answers. Input surfaces: 0 and 0.
struct BaseLevels
{
	std::uint32_t a = kNone, b = kNone;
	bool isUsed() const { return a != kNone; }
	bool isOfLeaves() const { return a == 0 && b == 0; }
	bool operator==(const BaseLevels& other) const { return a == other.a && b == other.b; }
	bool operator!=(const BaseLevels& other) const { return !(*this == other); }
};

inline constexpr std::uint32_t kCollapsedChildren = kBoxLanes;  // as many as are compared at once

// A contact level as a whole.
struct LevelBounds
{
	float cover = 0, protrude = 0;  // the largest of its nodes
	bool isWhole = true;            // no child skips the level: whatever is above reaches the surface through it
	double boxes = 0, volume = 0, area = 0, edges = 0;  // its culling boxes, and three edges of each: numbers and sums
};
// Proportional to the pairs of culling boxes of two levels that meet when the bodies lie anywhere near each other: of
// two convex bodies the measure of all places where they do is V + V' + (S M' + M S') / (4 pi), and of a box M = pi
// (x + y + z) (the principal kinematic formula; Santalo, Integral Geometry and Geometric Probability, III.15.4).
inline double meetingBoxes(const LevelBounds& a, const LevelBounds& b)
{
	return b.boxes * a.volume + a.boxes * b.volume + 0.25 * (a.area * b.edges + a.edges * b.area);
}

class CLOD_API TraversalTables
{
public:
	explicit TraversalTables(const Hierarchy& hierarchy);

	// What stands for the primary children of a node above level `base` where no level above that may answer: its
	// primary descendants down to the base, the largest boxes opened first, as long as they are at most kCollapsedChildren.
	// Only nodes met on the way from the root have any.
	Span<std::uint32_t> collapsedChildren(std::uint32_t node, std::uint32_t base) const
	{
		const CollapsedTree& tree = m_collapsed[base];
		const Range range = tree.ranges[node - tree.firstNode];
		return {tree.children.data() + range.first, range.count};
	}
	const LevelBounds& bounds(std::uint32_t contactLevel) const { return m_bounds[contactLevel]; }
	std::uint32_t coarsestLevel() const { return std::uint32_t(m_bounds.size() - 1); }

private:
	struct Range
	{
		std::uint32_t first = 0, count = 0;
	};
	struct CollapsedTree
	{
		std::uint32_t firstNode = 0;  // above the base
		std::vector<Range> ranges;    // of each from there on
		std::vector<std::uint32_t> children;
	};
	static CollapsedTree collapse(const Hierarchy& hierarchy, std::uint32_t base);
	void boundLevels(const Hierarchy& hierarchy);

	std::vector<CollapsedTree> m_collapsed;  // one a contact level
	std::vector<LevelBounds> m_bounds;       // one a contact level
};

// Of the levels whose worst nodes keep the limit together those with the fewest pairs of nodes, unless of others far
// fewer boxes meet (meetingBoxes): those of long patches meet many that touch none. O(levels).
// isAlone: no threshold asks for finer nodes here and there; where one does, the input surfaces or none.
CLOD_API BaseLevels chooseBaseLevels(const TraversalTables& a, const TraversalTables& b, double maxError, bool isAlone);
}  // namespace clod
