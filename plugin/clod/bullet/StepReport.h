// SPDX-License-Identifier: Zlib
// What dispatches report: on each pair, and summed over a step.
//
// Lengths are in the hierarchies' unit (before any shape scaling).
#pragma once
#include <LinearMath/btVector3.h>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "clod/Export.h"
#include "clod/query/ContactMetric.h"
#include "clod/query/Query.h"

class btCollisionObject;
class btIDebugDraw;

namespace clod
{
struct GapResult;    // distance/SignedGap.h
class HeldClusters;  // manifold/ContactPoints.h

// What one dispatch reports on a pair. Empty if the pair could not be queried.
struct DispatchReport
{
	const Hierarchy* hierarchyA = nullptr;
	const Hierarchy* hierarchyB = nullptr;  // null: a plane or an engine's own mesh
	Metric metric;                          // as used; exact where the user's could not be used
	std::string metricError;                // empty, or why the user's metric could not be used
	double tolerance = 0;                   // contact distance used, hierarchy unit
	double motion = 0;                      // bound on the relative motion of one step, hierarchy unit
	// How far the nodes of the coarsest contact may be from the surfaces they stand for, both bodies together
	// (StopRule.h, certifiedErrorApart). While their hulls are apart, the true gap differs from the hulls' distance by
	// no more than this; it does not bound a depth. With Context::searchGap, PairReport::result has the certified gap.
	double contactError = 0;
	// Contacts found, points chosen from them, and manifolds that hold the points.
	std::uint32_t candidates = 0, points = 0, clusterCount = 0;
	std::uint32_t finestLevel = 0, coarsestLevel = 0;
	bool deep = false;               // an overlap too deep to measure: the points only tell a way out
	bool fast = false;               // one step moves the bodies farther than the thinnest wall
	bool loose = false;              // contactError exceeds the thinnest wall
	bool kept = false;               // nothing had changed: manifolds were left as the last dispatch wrote them
	double queryMicroseconds = 0;    // time up to the contact list
	double contactMicroseconds = 0;  // time from there to the points, before they are written
};

// What is kept of a query's result; of contacts only their nodes. Against a plane, node B is 0; against an engine's own
// mesh it is the number of the triangle among those near.
struct HeldResult : ContactSummary
{
	std::vector<AcceptedPair> pairs;
	double minDistance = std::numeric_limits<double>::infinity(), errorBound = 0;  // as GapResult's
	void hold(const GapResult& result);
};

// A pair in its last dispatch. Valid until the next dispatch.
struct PairReport : DispatchReport
{
	const btCollisionObject* objectA = nullptr;
	const btCollisionObject* objectB = nullptr;
	const HeldResult* result = nullptr;      // accepted node pairs
	const HeldClusters* clusters = nullptr;  // points, in frame A and the hierarchy's unit
	Transform aFromB;                        // in the dispatch that found them,
	Transform worldFromA;                    // world lengths, and
	double unit = 1;                         // the world length of the hierarchies' unit there
	std::string notFinite;                   // what is not finite, or empty; if set, the pair has no contacts
	std::uint32_t coarsestTests = 0;         // tests that the coarsest answer takes, under a budget (see Outline)
	std::uint32_t vainTests = 0;             // further tests, for answers that were not taken
};

// The contacts of a pair, evaluated again (with a plane or an engine's own mesh only their nodes), and the whole
// result. Each takes about the time of a query's last phase.
CLOD_API void contactsOf(const PairReport& pair, std::vector<Contact>& contacts);
CLOD_API GapResult resultOf(const PairReport& pair);

// Draws the patches in contact, each along the edges of its faces in the colour of its level. O(those edges).
CLOD_API void drawLevels(const PairReport& pair, btIDebugDraw& drawer);
// Red, green and blue, 0 to 1: from violet, the finest level, over green to yellow, the coarsest.
CLOD_API btVector3 colorOf(std::uint32_t level, const Hierarchy& hierarchy);

// Sums over all live pairs, each in its last dispatch.
struct CLOD_API StepReport
{
	std::uint32_t pairs = 0, pairsInContact = 0;
	std::uint32_t nodePairs = 0, candidates = 0, points = 0, clusters = 0;
	std::uint32_t front = 0, hullTests = 0, boxTests = 0;
	std::uint32_t pending = 0;  // contacts that the budget left coarser than the metric asks
	double excess = 0;          // the factor by which the worst of them exceeds its metric
	std::uint32_t keptPairs = 0, deepPairs = 0, fastPairs = 0, loosePairs = 0;
	double queryMicroseconds = 0, contactMicroseconds = 0;

	// One sentence for each pair and cause, made when this is called.
	std::vector<std::string> warnings() const;

	struct Warned
	{
		std::uint32_t pair = 0;
		bool deep = false, fast = false, loose = false;
		std::string notFinite, metricError;
	};
	std::vector<Warned> warned;  // the pairs that have a warning
};
void addTo(StepReport& sum, const PairReport& pair);
}  // namespace clod
