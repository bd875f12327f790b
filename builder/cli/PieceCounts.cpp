// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: see PieceCounts.h.
#include "builder/cli/PieceCounts.h"

#include <algorithm>
#include <limits>

namespace clod::builder
{
namespace
{
// The largest s among a node's parents; infinite where one of them never answers. s never falls towards the root, so
// all ancestors of a parent beyond a threshold are beyond it too.
std::vector<float> largestOfParents(const Hierarchy& hierarchy)
{
	constexpr float kNever = std::numeric_limits<float>::infinity();
	std::vector<float> largest(hierarchy.nodes().size, 0);
	largest[hierarchy.root()] = kNever;
	for (const Node& parent : hierarchy.nodes())
		for (const std::uint32_t child : hierarchy.children(parent))
			largest[child] = std::max(largest[child], (parent.flags & kClodNode) != 0 ? parent.deviation : kNever);
	return largest;
}
}  // namespace

std::vector<PieceCount> pieceCounts(const Hierarchy& hierarchy)
{
	const std::vector<float> ofParents = largestOfParents(hierarchy);
	std::vector<PieceCount> counts;
	for (const double share : kErrorShares)
	{
		const double limit = share * double(hierarchy.asset().radius);
		PieceCount count{share, 0, hierarchy.levels()[0].nodeCount, 0};
		for (std::uint32_t level = 0; level <= hierarchy.coarsestClodLevel(); ++level)
			if (double(hierarchy.levels()[level].maxDeviation) <= limit)
				count.level = level, count.pieces = hierarchy.levels()[level].nodeCount;
		for (std::uint32_t i = 0; i < hierarchy.nodes().size; ++i)
		{
			const Node& node = hierarchy.node(i);
			const bool isWithin = double(node.deviation) <= limit || node.level == 0;
			if ((node.flags & kClodNode) != 0 && isWithin && double(ofParents[i]) > limit) ++count.mixed;
		}
		counts.push_back(count);
	}
	return counts;
}
}  // namespace clod::builder
