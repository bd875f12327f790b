// SPDX-License-Identifier: Zlib
// The user's settings: thresholds for all pairs, a callback for single pairs, budget, camera; and the way to the last
// step's report (StepReport.h). No globals: one object a world, owned by the user, alive as long as the dispatcher's
// pairs.
//
// Lengths are in the hierarchies' unit (before any shape scaling).
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "clod/Export.h"
#include "clod/bullet/Abi.h"
#include "clod/bullet/ConvexPartner.h"
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

// Bodies of ours that no dispatcher knows fall through each other. What a world asks of shapes before any registration is
// counted, process-wide, and after some steps' worth one message goes to stderr. Once there is one it costs a load.
void warnIfUnregistered();

class CLOD_API Context
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
	// Returns true and fills the metric to decide a pair. Called once a pair and dispatch at most, maybe from several
	// threads.
	std::function<bool(const btCollisionObject& a, const btCollisionObject& b, ContactMetric& metric)> pairMetric;
	// The eye of view metrics; none: a pair with a view metric is exact and warned of.
	std::optional<ViewCamera> camera;
	// What the queries of a step may cost together, or its dispatch, tests or time; pairs of two shapes of ours only.
	// It is kept by one coarsening of the metrics of all that move, chosen from what the last steps cost; what is left
	// refines what lies still. btClodDispatcher keeps one budget a world; with any other, a step begins where a pair
	// comes again, and worlds share it, on one thread. A budget that cannot be used is warned of and not used.
	Budget budget;
	// Search the signed gap of touching bodies too (PairReport::result then has it, certified). Costs a millisecond or
	// more.
	bool searchGap = false;
	// Two bodies that hardly move keep the points found before, with the distances that these have now. False: every
	// dispatch of what moves at all finds them anew.
	bool keepPoints = true;
	// Bodies that overlap are moved apart no faster than this, in radii of the smaller body a second: a depth is taken
	// back at once where it is small, and never thrown out where it is large.
	double pushSpeed = 3;
	// Of a gap within the skin, what a point that carries closes a step: 1 less WorldSettings::warmstartingFactor or less
	// (SolverTerms.h), which setUpWorld sees to. 1: all of it; piles tremble.
	double closedShare = 0.15;
	// Receives each warning once a pair and cause, with the bodies' world indices, user indices and files, and of each
	// cause the first kMostMessages; prints to stderr by default; empty = silent (lastStep() has it still). Called during
	// a dispatch, by one thread at a time. It may ask this context for lastStep() and its pairs,
	// unless a dispatch uses several threads: the pair at work is then half of this step, later ones are of the last.
	std::function<void(const std::string& message)> warn;

	static constexpr int kMostMessages = 10;

	StepReport lastStep() const;
	// Visits the live pairs, oldest first. A visitor may call this context again, and may test for contacts; a pair
	// that it removes can keep a later one from being visited. Between dispatches, or on the only thread of one.
	void forEachPair(const std::function<void(const PairReport&)>& visit) const;

private:
	friend class PairState;
	friend class ::btClodCollisionAlgorithm;
	friend class ::btClodDynamicsWorld;
	friend class ::btClodDispatcher;
	// None where it cannot be used.
	Budget usableBudget() const { return budgetError(budget).empty() ? budget : Budget{}; }
	// That of btClodDispatcher, or this context's.
	StepBudget& budgetOf(btDispatcher& dispatcher);
	// The coarsening of this step. lastStep: the one a pair was last in; where that is this one a new step begins, unless
	// its dispatcher says so.
	double enterStep(StepBudget& budget, std::uint64_t& lastStep);
	// Of pairs whose coarsest answers are not known yet.
	void expect(StepBudget& budget);
	void add(PairState* pair);
	void remove(PairState* pair);
	void say(unsigned cause, const std::string& message);
	static void noteRegistration();
	PairState* pairAt(std::size_t index) const;
	// Oldest first. Those of other dispatchers come and go meanwhile, where their worlds have threads of their own.
	void pairsOf(const btDispatcher& dispatcher, std::vector<PairState*>& pairs) const;
	// Whether contacts are asked for what the step's solver has made of the motion.
	bool& isSolvedIn(const btDispatcher& dispatcher);
	mutable std::mutex m_mutex;             // of all that worlds share; no function of the user's is called under it
	mutable std::recursive_mutex m_saying;  // one message at a time, but for those that a message's handler causes
	std::vector<PairState*> m_pairs;
	std::map<const btDispatcher*, bool> m_isSolved;
	std::map<unsigned, int> m_said;  // how often, of each cause
	ConvexPartners m_convexPartners;
	StepBudget m_stepBudget;  // of dispatchers that have none
	std::vector<std::unique_ptr<btCollisionAlgorithmCreateFunc>> m_createFunctions;  // one set a registration
};
}  // namespace clod
