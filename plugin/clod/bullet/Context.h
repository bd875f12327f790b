// SPDX-License-Identifier: Zlib
// The user's settings and window on the plugin: thresholds for all pairs, a callback for single pairs, statistics and
// warnings of the last step. No globals: one object a world, owned by the user, alive as long as the dispatcher's
// pairs.
//
// Lengths are in the hierarchies' unit (before any shape scaling).
#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "clod/bullet/Abi.h"
#include "clod/distance/SignedGap.h"
#include "clod/manifold/ContactMemory.h"
#include "clod/query/ContactMetric.h"
#include "clod/query/Query.h"

class btCollisionObject;
class btClodCollisionAlgorithm;
struct btCollisionAlgorithmCreateFunc;

namespace clod
{
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
	// Points that were looked at (pairs that cannot give one to choose are not clipped), and chosen; in so many
	// manifolds; dropped as leaks.
	std::uint32_t candidates = 0, points = 0, clusterCount = 0, leaks = 0;
	std::uint32_t finestLevel = 0, coarsestLevel = 0;
	std::uint32_t searchTests = 0;   // of a depth searched, as hulls overlapped and no point answered; not in `result`
	bool deep = false;               // penetration beyond what the contacts can prove
	bool fast = false;               // one step moves the bodies farther than the thinnest wall
	bool loose = false;              // contactError exceeds the thinnest wall
	bool kept = false;               // nothing has changed: manifolds were left as the last dispatch wrote them
	double queryMicroseconds = 0;    // up to the contact list,
	double contactMicroseconds = 0;  // and from there to its points, before they are written
};

// A pair as of its last dispatch. Valid until the next dispatch.
struct PairReport : DispatchReport
{
	const btCollisionObject* objectA = nullptr;
	const btCollisionObject* objectB = nullptr;
	const GapResult* result = nullptr;   // accepted node pairs; empty against a plane or an engine's own mesh
	const ClusterSet* clusters = nullptr;  // frame A, hierarchy unit
	std::string notFinite;                 // empty, or what is not finite: the pair then has no contacts
	double demand = 0;                     // tests that it took, or would have with a larger budget, as a guess
	bool isPlanned = false;                // by btClodDispatcher
};

// Sums over all live pairs, each as of its last dispatch.
struct StepStatistics
{
	std::uint32_t pairs = 0, pairsInContact = 0;
	std::uint32_t nodePairs = 0, candidates = 0, points = 0, clusters = 0, leaks = 0;
	std::uint32_t front = 0, hullTests = 0, boxTests = 0;
	std::uint32_t searchTests = 0;  // besides, see PairReport
	std::uint32_t pending = 0;      // node pairs that answered coarser than asked, for want of budget
	double excess = 0;              // by which factor the worst of them exceeds its metric
	std::uint32_t keptPairs = 0, deepPairs = 0, fastPairs = 0, loosePairs = 0;
	double queryMicroseconds = 0, contactMicroseconds = 0;
	std::vector<std::string> warnings;  // one sentence a pair and cause
};

class Context
{
public:
	Context();
	~Context();
	Context(const Context&) = delete;
	Context& operator=(const Context&) = delete;

	// Precedence: the pair callback if it answers, else the stricter of the shapes' own metrics, else the world's. All
	// may change between steps. A metric that cannot be used (contactMetricError) makes its pairs exact and is warned
	// of.
	ContactMetric worldMetric = ContactMetric::errorShare(0.005);
	// Returns true and fills the metric to decide a pair. Called once a pair and dispatch, twice under a budget, maybe
	// from several threads.
	std::function<bool(const btCollisionObject& a, const btCollisionObject& b, ContactMetric& metric)> pairMetric;
	// The eye of view metrics; none: a pair with a view metric is exact and warned of.
	std::optional<ViewCamera> camera;
	// What the queries of a step may cost together, tests or time; pairs of two shapes of ours only. btClodDispatcher
	// holds it over the whole step. Any other dispatcher lets each pair have a share by what it needed last, so that
	// the sum is near the budget, not under it. A depth that has to be searched (PairReport::searchTests) is paid for
	// first. A budget that cannot be used is warned of and not used.
	Budget budget;
	// Search the signed gap of touching bodies too (PairReport::result then has it, certified). Costs a millisecond or
	// more.
	bool searchGap = false;
	// Receives each warning once a pair and cause; prints to stderr by default; empty = silent (lastStep() has it
	// still). Called during a dispatch, by one thread at a time. It may ask this context for lastStep() and its pairs,
	// unless a dispatch uses several threads: the pair at work is then half of this step, later ones are of the last.
	std::function<void(const std::string& message)> warn;

	// Of the budget of tests, what pairs that btClodDispatcher cannot plan will take.
	double unplannedShare() const;
	StepStatistics lastStep() const;
	// Visits the live pairs, oldest first. A visitor may call this context again, and may test for contacts; a pair
	// that it removes can keep a later one from being visited. Between dispatches, or on the only thread of one.
	void forEachPair(const std::function<void(const PairReport&)>& visit) const;

private:
	friend class PairState;
	friend class ::btClodCollisionAlgorithm;
	// A pair's part of the budget; 0 <= demand: tests that it needed last.
	Budget shareOf(const PairReport& report) const;
	void setDemand(PairReport& report, double tests);
	void setPlanned(PairReport& report);  // by btClodDispatcher from now on
	void add(const PairReport* report);
	void remove(const PairReport* report);
	void say(const std::string& message) const;
	const PairReport* pairAt(std::size_t index) const;
	mutable std::mutex m_mutex;             // of pairs and demand; no function of the user's is called under it
	mutable std::recursive_mutex m_saying;  // one message at a time, but for those that a message's handler causes
	std::vector<const PairReport*> m_pairs;
	double m_demand = 0, m_unplannedDemand = 0;  // sums over the pairs; whole numbers
	std::vector<std::unique_ptr<btCollisionAlgorithmCreateFunc>> m_createFunctions;  // one set a registration
};
}  // namespace clod
