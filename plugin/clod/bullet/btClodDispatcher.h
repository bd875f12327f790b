// SPDX-License-Identifier: Zlib
// A collision dispatcher for many bodies. It keeps Context::budget over whole steps and makes the contacts of all
// pairs on several threads. Without a budget and with one thread it behaves as btCollisionDispatcher.
//
// Threads. Queries and contact points of a pair with a btClodShape depend on nothing but the pair. They are made on a
// thread pool of our own, however Bullet was built, and then written by Bullet's dispatch in Bullet's order. The bits
// are the same for any number of threads, except under a budget of time: pairs read of each other what was so before the
// dispatch (with Bullet's own dispatcher, what those asked before have found). Pairs are handled one after the other if
// their shapes may not be read by several threads (the program's own, GImpact), if the budget counts tests (what is left
// for one pair depends on those before it), and all of them if the program has set a near callback of its own or
// continuous dispatch.
//
// Budgets. Of tests: the cost of all coarsest answers is found first and held back, so a step exceeds its budget only
// if these alone do, and results repeat bit for bit. (If the program has a near callback of its own, the cost in the last
// step is held back.) Of time: the clock of the whole dispatch decides (StepBudget.h). Continuous dispatch is not
// budgeted.
#pragma once
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "clod/Export.h"

namespace clod
{
class Context;
class StepBudget;
}  // namespace clod

class CLOD_API btClodDispatcher : public btCollisionDispatcher
{
public:
	// The context must be the one given to registerAlgorithm for this dispatcher, and outlive it.
	btClodDispatcher(btCollisionConfiguration* configuration, clod::Context* context);
	~btClodDispatcher() override;

	// How many threads make contacts: 1 at first; 0 means as many as the machine has cores; at most 1,024. With several,
	// what a program gives a context (pairMetric, own thresholds) or Bullet (combined friction) is called by several at
	// once.
	void setThreads(unsigned count);
	unsigned threads() const;

	void dispatchAllCollisionPairs(btOverlappingPairCache* pairCache, const btDispatcherInfo& info,
								   btDispatcher* dispatcher) override;
	// Dispatches some pairs again within a step, in this order and from that step's budget.
	void dispatchPairs(const std::vector<btBroadphasePair*>& pairs, const btDispatcherInfo& info);

	// None while a character asks between the steps what its ghost touches.
	clod::StepBudget* stepBudget();

private:
	struct Step;
	void beginBudget(const btDispatcherInfo& info);
	void listJobs(const std::vector<btBroadphasePair*>& pairs, const btDispatcherInfo& info);
	void outline(const btDispatcherInfo& info);
	void prepare(const btDispatcherInfo& info);
	void refine();

	clod::Context& m_context;
	std::uint64_t& m_dispatch;  // that comes, or is on
	std::unique_ptr<Step> m_step;
	bool m_isBetweenSteps = false;
};
