// SPDX-License-Identifier: Zlib
// The smallest hull distance over all accepted pairs, at any separation: nearest pairs first. The number is the same
// whatever the search starts from; only the work differs.
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
		double separation;
		std::uint32_t a, b;
	};
	std::vector<Candidate> stack;
	std::uint32_t lastA = kNone, lastB = kNone;  // the closest pair of the last search: a first upper bound
	void clear() { lastA = lastB = kNone; }
};

// Upper end of the certified bracket, evaluated from the canonical start.
double closestDistance(const QueryContext& context, const StopRule& rule, bool paper, ClosestPairScratch& scratch,
					   QueryStats& stats);
}  // namespace clod
