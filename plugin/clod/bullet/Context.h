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

class btCollisionObject;
class btClodCollisionAlgorithm;
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
	// Returns true and fills the metric to decide a pair. Called once a pair and dispatch, twice under a budget, maybe
	// from several threads.
	std::function<bool(const btCollisionObject& a, const btCollisionObject& b, ContactMetric& metric)> pairMetric;
	// The eye of view metrics; none: a pair with a view metric is exact and warned of.
	std::optional<ViewCamera> camera;
	// What the queries of a step may cost together, tests or time; pairs of two shapes of ours only. btClodDispatcher
	// holds it over the whole step. Any other dispatcher lets each pair have a share by what it needed last, so that
	// the sum is near the budget, not under it. A budget that cannot be used is warned of and not used.
	Budget budget;
	// Search the signed gap of touching bodies too (PairReport::result then has it, certified). Costs a millisecond or
	// more.
	bool searchGap = false;
	// Bodies that overlap are moved apart no faster than this, in radii of the smaller body a second: a depth is taken
	// back at once where it is small, and never thrown out where it is large.
	double pushSpeed = 3;
	// Receives each warning once a pair and cause, with the bodies' world indices, user indices and files, and of each
	// cause the first kMostMessages; prints to stderr by default; empty = silent (lastStep() has it still). Called during
	// a dispatch, by one thread at a time. It may ask this context for lastStep() and its pairs,
	// unless a dispatch uses several threads: the pair at work is then half of this step, later ones are of the last.
	std::function<void(const std::string& message)> warn;

	static constexpr int kMostMessages = 10;

	// Of the budget of tests, what pairs that btClodDispatcher cannot plan will take.
	double unplannedShare() const;
	StepReport lastStep() const;
	// Visits the live pairs, oldest first. A visitor may call this context again, and may test for contacts; a pair
	// that it removes can keep a later one from being visited. Between dispatches, or on the only thread of one.
	void forEachPair(const std::function<void(const PairReport&)>& visit) const;

private:
	friend class PairState;
	friend class ::btClodCollisionAlgorithm;
	friend class ::btClodDynamicsWorld;
	// A pair's part of the budget; 0 <= demand: tests that it needed last.
	Budget shareOf(const PairReport& report) const;
	void setDemand(PairReport& report, double tests);
	void setPlanned(PairReport& report);  // by btClodDispatcher from now on
	void add(PairState* pair);
	void remove(PairState* pair);
	void say(unsigned cause, const std::string& message);
	static void noteRegistration();
	PairState* pairAt(std::size_t index) const;
	mutable std::mutex m_mutex;             // of pairs and demand; no function of the user's is called under it
	mutable std::recursive_mutex m_saying;  // one message at a time, but for those that a message's handler causes
	std::vector<PairState*> m_pairs;
	bool m_isSolved = false;  // contacts are asked for what the step's solver has made of the motion
	double m_demand = 0, m_unplannedDemand = 0;  // sums over the pairs; whole numbers
	std::map<unsigned, int> m_said;  // how often, of each cause
	ConvexPartners m_convexPartners;
	std::vector<std::unique_ptr<btCollisionAlgorithmCreateFunc>> m_createFunctions;  // one set a registration
};
}  // namespace clod
