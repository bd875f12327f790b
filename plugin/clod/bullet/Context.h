// SPDX-License-Identifier: Zlib
// The user's settings (accuracy of all pairs, a callback for single pairs, budget, camera) and access to the report of
// the last step (StepReport.h). There are no globals: the user owns a context for each world, or shares one between
// worlds. It must outlive the pairs of the dispatchers that it is registered with.
//
// Lengths are in the hierarchies' unit (before any shape scaling) unless a comment says otherwise.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "clod/Export.h"
#include "clod/bullet/Abi.h"
#include "clod/bullet/ConvexPartner.h"
#include "clod/bullet/SolverTerms.h"
#include "clod/bullet/StepReport.h"
#include "clod/query/Budget.h"
#include "clod/schedule/StepBudget.h"

class btCollisionObject;
class btDispatcher;
class btClodCollisionAlgorithm;
class btClodDispatcher;
class btClodDynamicsWorld;
struct btCollisionAlgorithmCreateFunc;

namespace clod
{
class PairState;
struct SavedContacts;

// Shapes of ours that were never registered with a dispatcher fall through each other. Calls that a world makes to
// shapes before any registration are counted, process-wide; after some steps one message goes to stderr. After a
// registration this costs one load.
void warnIfUnregistered();

class CLOD_API Context
{
public:
	Context();
	~Context();
	Context(const Context&) = delete;
	Context& operator=(const Context&) = delete;

	// The accuracy of pairs that neither the callback nor a shape sets: first comes pairMetric if it returns true, then
	// the stricter of the two shapes' own metrics, then this. All may change between steps. A metric that cannot be
	// used (contactMetricError) makes its pairs exact and causes a warning.
	ContactMetric worldMetric = ContactMetric::errorShare(0.005);
	// To decide a pair, fill the metric and return true. Called at most once for each pair and dispatch, possibly by
	// several threads at once.
	std::function<bool(const btCollisionObject& a, const btCollisionObject& b, ContactMetric& metric)> pairMetric;
	// The eye of view metrics, in world lengths. Without it a pair with a view metric is exact, with a warning.
	std::optional<ViewCamera> camera;
	// What one step may cost: tests of all its queries, or microseconds of its dispatch. Only pairs of two shapes of
	// ours are budgeted. To keep it, the metrics of all moving pairs are raised by one factor, chosen from the cost of
	// the last steps; what is left refines resting pairs. btClodDispatcher keeps a budget for each world. With any
	// other dispatcher, a step begins when a pair comes again, worlds that share a context share its budget, on one
	// thread, and pairs of a btPairCachingGhostObject have none: a character asks about them between the steps, too. A
	// budget that cannot be used causes a warning and is ignored. A budget of tests repeats bit for bit.
	Budget budget;
	// Also search the signed gap of touching bodies; PairReport::result then holds it with its certified bound. Costs a
	// millisecond or more for each pair.
	bool searchGap = false;
	// If true, two bodies that hardly move keep the contact points found before, with their distances updated. If
	// false, points are found anew whenever a body moves at all.
	bool keepPoints = true;
	// Overlapping bodies are moved apart no faster than this, in radii of the smaller body per second. Small depths are
	// corrected within a step; large ones do not throw bodies apart.
	double pushSpeed = 3;
	// The share of a gap within the skin, near rest two, that a point under load closes in each step (SolverTerms.h). It
	// should be at most 1 - WorldSettings::warmstartingFactor, as setUpWorld sets it; with 1, which closes the whole gap,
	// piles tremble. Where it is less, bodies that rock start from impulses that are not quite exact. Below 0.05 flats on
	// coarse levels leave an overlap of their skins as slowly.
	double closedShare = 0.15;
	// Receives warnings: one for each pair and cause, and at most kMostMessages for each cause. A message names the
	// bodies' world indices, user indices and files. By default it is printed to stderr; an empty function is silent
	// (lastStep() still has the warnings). Called during a dispatch, by one thread at a time. It may call lastStep()
	// and forEachPair(), except while a dispatch uses several threads; pairs not yet reached are then still those of
	// the last step.
	std::function<void(const std::string& message)> warn;

	static constexpr int kMostMessages = 10;

	StepReport lastStep() const;
	// Visits the live pairs, oldest first. The visitor may call this context again and may test for contacts; if it
	// removes a pair, a later one may not be visited. Call it between dispatches, or on the only thread of one.
	void forEachPair(const std::function<void(const PairReport&)>& visit) const;

	// What the pairs of a dispatcher keep from step to step: points with their impulses, what they answer and what went
	// in where. Between two steps a program may save it and later, with its bodies, joints and solver as they were
	// then, put it back. Pairs that were not there begin anew; the program's data at points are dropped. Returns how
	// many pairs with manifolds are no longer there: Bullet ends those whose boxes part, and begins them anew. If none,
	// a world at rest goes on as it did, to the bit, with btDispatcherInfo::m_deterministicOverlappingPairs, islands that
	// are not split (Bullet makes them of boxes that have a history), and without a budget, which goes on learning. One
	// that falls may go another way after some steps: which pairs come depends on such boxes, too. Cost: a copy of the
	// points.
	std::shared_ptr<const SavedContacts> saveContacts(const btDispatcher& dispatcher) const;
	std::size_t restoreContacts(const btDispatcher& dispatcher, const SavedContacts& saved);

private:
	friend class PairState;
	friend class ::btClodCollisionAlgorithm;
	friend class ::btClodDynamicsWorld;
	friend class ::btClodDispatcher;
	// The budget, or none if it cannot be used.
	Budget usableBudget() const { return budgetError(budget).empty() ? budget : Budget{}; }
	// The dispatcher's own if it is a btClodDispatcher, else this context's.
	StepBudget* budgetOf(btDispatcher& dispatcher, bool isOfGhost);
	// Returns the coarsening of this step. lastStep is the step that the pair was last in; if it is this one, a new
	// step begins, unless the dispatcher tells when steps begin.
	double enterStep(StepBudget& budget, std::uint64_t& lastStep);
	// Counts a pair whose coarsest answer is not known yet.
	void expect(StepBudget& budget);
	void add(PairState* pair);
	// The pairs of a body, of those that last: one that is listed may look at the list in any dispatch, as pairs of its
	// world come and go between these only.
	const std::vector<PairState*>& enlist(const btCollisionObject& body, PairState* pair);
	void strike(const btCollisionObject& body, PairState* pair);
	void remove(PairState* pair);
	void say(unsigned cause, const std::string& message);
	static void noteRegistration();
	PairState* pairAt(std::size_t index) const;
	// Oldest first. Pairs of other dispatchers may come and go meanwhile, if their worlds run on other threads.
	void pairsOf(const btDispatcher& dispatcher, std::vector<PairState*>& pairs) const;
	// What the pairs of a dispatcher share. Of contacts that btClodDynamicsWorld finds: will they be found again as bodies
	// are solved, and is that so now? Which dispatch it is, of a btClodDispatcher's; between two it is that to come.
	struct Shared
	{
		bool mayFollow = false, isFurther = false;
		std::uint64_t dispatch = 0;
		SolverOrder order;
	};
	Shared& sharedIn(const btDispatcher& dispatcher) const;
	mutable std::mutex m_mutex;             // of all that worlds share; no function of the user's is called under it
	mutable std::recursive_mutex m_saying;  // one message at a time, but for those that a message's handler causes
	std::vector<PairState*> m_pairs;
	std::unordered_map<const btCollisionObject*, std::vector<PairState*>> m_ofBody;
	mutable std::map<const btDispatcher*, Shared> m_shared;
	std::map<unsigned, int> m_said;  // how often, of each cause
	ConvexPartners m_convexPartners;
	StepBudget m_stepBudget;  // of dispatchers that have none
	std::vector<std::unique_ptr<btCollisionAlgorithmCreateFunc>> m_createFunctions;  // one set a registration
};

// Of all that later steps depend on: the same for the same steps, in any process and by any number of threads.
CLOD_API std::uint64_t hashOf(const SavedContacts& contacts);
}  // namespace clod
