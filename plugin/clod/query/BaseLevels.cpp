// SPDX-License-Identifier: Zlib
#include "clod/query/BaseLevels.h"

#include <algorithm>

#include "clod/query/Constants.h"

namespace clod
{
namespace
{
bool keepLimit(const LevelBounds& a, const LevelBounds& b, double maxError)
{
	const double cover = double(a.cover) + double(b.cover), protrude = double(a.protrude) + double(b.protrude);
	return b.isWhole && std::max(cover, protrude) <= maxError;
}
}  // namespace

BaseLevels chooseBaseLevels(const QueryContext& context, double maxError, bool isAlone)
{
	const Hierarchy &a = context.a, &b = context.b;
	const TraversalTables &ofA = context.tablesA, &ofB = context.tablesB;
	struct Choice
	{
		BaseLevels levels;
		double pairs, meeting;
	};
	const auto choiceOf = [&](const BaseLevels& levels)
	{
		const double nodes = double(a.levels()[levels.a].nodeCount);
		return Choice{levels, nodes * double(b.levels()[levels.b].nodeCount),
					  meetingBoxes(ofA.bounds(levels.a), ofB.bounds(levels.b))};
	};
	Choice fewest = choiceOf({0, 0}), slimmest = fewest;
	std::uint32_t levelB = b.coarsestClodLevel();
	for (std::uint32_t levelA = 0; levelA <= a.coarsestClodLevel(); ++levelA)
	{
		if (!ofA.bounds(levelA).isWhole) continue;
		while (levelB > 0 && !keepLimit(ofA.bounds(levelA), ofB.bounds(levelB), maxError)) --levelB;
		if (!keepLimit(ofA.bounds(levelA), ofB.bounds(levelB), maxError)) break;
		const Choice next = choiceOf({levelA, levelB});
		if (next.pairs < fewest.pairs) fewest = next;
		if (next.meeting < slimmest.meeting) slimmest = next;
	}
	const Choice& best = slimmest.meeting < kFewer * fewest.meeting ? slimmest : fewest;
	return best.levels.isOfLeaves() || isAlone ? best.levels : BaseLevels{};
}
}  // namespace clod
