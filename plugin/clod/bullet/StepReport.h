// SPDX-License-Identifier: Zlib
// What dispatches say of themselves: a pair's report, and the sums of a step.
//
// Lengths are in the hierarchies' unit (before any shape scaling).
#pragma once
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "clod/Export.h"
#include "clod/query/ContactMetric.h"
#include "clod/query/Query.h"

class btCollisionObject;

namespace clod
{
struct GapResult;    // distance/SignedGap.h
class HeldClusters;  // manifold/ContactPoints.h

// What one dispatch says of a pair. Empty where nothing could be asked.
struct DispatchReport
{
	const Hierarchy* hierarchyA = nullptr;
	const Hierarchy* hierarchyB = nullptr;  // null: a plane or an engine's own mesh
	Metric metric;                          // as used; exact where the user's could not be used
	std::string metricError;                // empty, or why the user's metric could not be used
	double tolerance = 0;                   // contact distance used, hierarchy unit
	double motion = 0;                      // bound on the relative motion of one step, hierarchy unit
	// How far the nodes of the coarsest contact may be from the surfaces they stand for, both bodies together
	// (StopRule.h, certifiedErrorApart). While their hulls are apart the true gap there is within it of the hulls'
	// distance; of a depth it says nothing. The certified gap is result's, with Context::searchGap.
	double contactError = 0;
	// Contacts found, and points chosen of them, in so many manifolds.
	std::uint32_t candidates = 0, points = 0, clusterCount = 0;
	std::uint32_t finestLevel = 0, coarsestLevel = 0;
	bool deep = false;  // an overlap of which the points tell no more than a way out
	bool fast = false;               // one step moves the bodies farther than the thinnest wall
	bool loose = false;              // contactError exceeds the thinnest wall
	bool kept = false;               // nothing has changed: manifolds were left as the last dispatch wrote them
	double queryMicroseconds = 0;    // up to the contact list,
	double contactMicroseconds = 0;  // and from there to its points, before they are written
};

// What lasts of a query's result: of contacts their nodes alone. Against a plane node B is 0, of an engine's own mesh the
// number of the triangle among those near.
struct HeldResult : ContactSummary
{
	std::vector<AcceptedPair> pairs;
	double minDistance = std::numeric_limits<double>::infinity(), errorBound = 0;  // as GapResult's
	void hold(const GapResult& result);
};

// A pair as of its last dispatch. Valid until the next dispatch.
struct PairReport : DispatchReport
{
	const btCollisionObject* objectA = nullptr;
	const btCollisionObject* objectB = nullptr;
	const HeldResult* result = nullptr;      // accepted node pairs,
	const HeldClusters* clusters = nullptr;  // and points; frame A, hierarchy unit:
	Transform aFromB;                        // of the dispatch that found them
	std::string notFinite;                 // empty, or what is not finite: the pair then has no contacts
	std::uint32_t coarsestTests = 0;       // of its last query under a budget, see Outline
	std::uint32_t vainTests = 0;           // and besides its result's those of a finer answer that was not paid for
};

// Contacts, evaluated again; those with a plane or an engine's own mesh have nodes only. And all of the result.
CLOD_API void contactsOf(const PairReport& pair, std::vector<Contact>& contacts);
CLOD_API GapResult resultOf(const PairReport& pair);

// Sums over all live pairs, each as of its last dispatch.
struct CLOD_API StepReport
{
	std::uint32_t pairs = 0, pairsInContact = 0;
	std::uint32_t nodePairs = 0, candidates = 0, points = 0, clusters = 0;
	std::uint32_t front = 0, hullTests = 0, boxTests = 0;
	std::uint32_t pending = 0;      // contacts coarser than asked, for want of budget
	double excess = 0;              // by which factor the worst of them exceeds its metric
	std::uint32_t keptPairs = 0, deepPairs = 0, fastPairs = 0, loosePairs = 0;
	double queryMicroseconds = 0, contactMicroseconds = 0;

	// One sentence a pair and cause. Nothing is written out before it is asked for.
	std::vector<std::string> warnings() const;

	struct Warned
	{
		std::uint32_t pair = 0;
		bool deep = false, fast = false, loose = false;
		std::string notFinite, metricError;
	};
	std::vector<Warned> warned;  // the pairs that have something to say
};
void addTo(StepReport& sum, const PairReport& pair);
}  // namespace clod
