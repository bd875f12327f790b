// SPDX-License-Identifier: Zlib
// Searches for the nearest of all accepted pairs, nearest pairs first: how far apart two bodies are, and how much
// motion two bodies that are apart have left.
#pragma once
#include <vector>

#include "clod/query/PairFront.h"
#include "clod/query/QueryContext.h"
#include "clod/query/StopRule.h"

namespace clod
{
struct ClosestPairScratch
{
	struct Candidate
	{
		double separation;  // of the culling volumes
		std::uint32_t a, b;
	};
	std::vector<Candidate> stack;
	VisitedPairs visited;
	std::uint32_t nearestA = kNone, nearestB = kNone;  // that clearMotion found last: tried first
};

// The smallest tolerance at which a traversal reports a contact: over all accepted pairs and the ways to them, the
// smallest max(hull distance, culling separations on the way). That is the smallest hull distance, but for pairs met
// through shared children only, whose parents' boxes need not enclose their hulls. Hull distances are upper ends of the
// certified bracket from the canonical start.
double closestDistance(const QueryContext& context, const StopRule& rule, bool paper, ClosestPairScratch& scratch,
					   QueryStats& stats);

// By how much the pair may move, sweep included (MotionBound.h), before a traversal can report a contact at this
// tolerance; at most `cap`. <= 0: it may already. Not in paper mode.
double clearMotion(const QueryContext& context, const StopRule& rule, double tolerance, double cap,
				   ClosestPairScratch& scratch, QueryStats& stats);
}  // namespace clod
