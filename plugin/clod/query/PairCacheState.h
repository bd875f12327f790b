// SPDX-License-Identifier: Zlib
// What a pair's cache holds between queries.
#pragma once
#include <memory>

#include "clod/query/InsideTest.h"
#include "clod/query/PairFront.h"
#include "clod/query/Query.h"
#include "clod/query/SeparationCache.h"

namespace clod
{
struct PairCache::State
{
	const Hierarchy* a = nullptr;
	const Hierarchy* b = nullptr;
	std::uint64_t hashA = 0, hashB = 0;
	bool filled = false;
	double threshold = 0, maxError = 0;  // of the rule that the front was made with: constantThreshold, maxError
	BaseLevels base;                     // StopRule::base
	RelativePose pose;  // that the fronts have followed to,
	Sweep sweep;        // with this motion from there
	PairFront front;
	std::unique_ptr<PairFront> outline;  // of the coarsest valid answer, its pairs listed only; where there are budgets
	std::uint32_t quietFor = 0;  // queries that found nothing, one after the other
	std::uint32_t calmFor = kCalm;  // queries that moved by little, one after the other
	double lastMove = 0;  // of front.motion, what came since the last query
	double lastApproach = 0;  // approachBound since then
	SeparationCache separation;
	InsideProbes probesA, probesB;

	void clearFronts()
	{
		front.clear();
		separation.forget();
		probesA.clear();
		probesB.clear();
	}
};
}  // namespace clod
