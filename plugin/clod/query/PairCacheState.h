// SPDX-License-Identifier: Zlib
// What a pair's cache holds between queries. Included by Query.cpp and Evaluation.h only.
#pragma once
#include <optional>
#include <vector>

#include "clod/query/AnswerCost.h"
#include "clod/query/Clearance.h"
#include "clod/query/InsideTest.h"
#include "clod/query/PairFront.h"
#include "clod/distance/Penetration.h"
#include "clod/query/Query.h"
#include "clod/query/Refinement.h"

namespace clod
{
struct PairCache::State
{
	const Hierarchy* a = nullptr;
	const Hierarchy* b = nullptr;
	std::uint64_t hashA = 0, hashB = 0;
	bool filled = false;
	Transform aFromB;
	Settings settings;
	double threshold = 0, maxError = 0;  // of the rule that the front was made with; StopRule::constantThreshold
	BaseLevels base;                     // StopRule::base
	RelativePose pose;
	PairFront front;
	double lastMove = 0;  // of front.motion, what came by the last query
	Clearance clearance;
	InsideProbes probesA, probesB;
	ClosestPairScratch closest;
	PenetrationScratch penetration;
	Refinement refinement;                // of a query under a budget
	std::optional<QueryContext> planned;  // of a plan that no query has finished yet: aFromB and settings are its own
	AnswerCost answerCost{1};             // from the end of refinement to the end of the query
	std::vector<Contact> near;            // the pairs of leaves that an overlap's depth is searched in
	struct Ordered
	{
		std::uint64_t nodes;  // both of a contact
		std::uint32_t contact;
		bool operator<(const Ordered& other) const { return nodes < other.nodes; }
	};
	std::vector<Ordered> order;
	std::vector<Contact> unsorted;
	QueryResult last;

	void clearFronts()
	{
		front.clear();
		clearance.forget();
		probesA.clear();
		probesB.clear();
	}
};
}  // namespace clod
