// SPDX-License-Identifier: Zlib
// The smallest tolerance at which a traversal reports a contact: over all accepted pairs and the ways to them, the
// smallest max(hull distance, culling separations on the way). That is the smallest hull distance, but for pairs met
// through shared children only, whose parents' boxes need not enclose their hulls. Nearest pairs first.
#pragma once
#include <vector>

#include "clod/query/QueryContext.h"
#include "clod/query/StopRule.h"

namespace clod
{
struct ClosestPairScratch
{
	struct Candidate
	{
		double separation;  // largest on the way from the roots
		std::uint32_t a, b;
	};
	std::vector<Candidate> stack;
};

// Hull distances are upper ends of the certified bracket from the canonical start.
double closestDistance(const QueryContext& context, const StopRule& rule, bool paper, ClosestPairScratch& scratch,
					   QueryStats& stats);
}  // namespace clod
