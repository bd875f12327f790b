// SPDX-License-Identifier: Zlib
// A collision dispatcher for many bodies: it keeps Context::budget over whole steps, and makes the contacts of all pairs on
// several threads. Without either it is a btCollisionDispatcher.
//
// Threads. Queries and contact points of pairs with a btClodShape concern nothing but the pair: they are made on
// a pool of our own, whatever Bullet was built with, and then written by Bullet's dispatch in Bullet's order. The
// same bits for any number of threads, clock budgets excepted. One pair after the other as before are met: compounds
// within compounds; shapes that are not known to be read by several threads (a program's own, GImpact); pairs whose budget is
// counted in tests, as what is left to one is what those before it took; and all, where the program has set a near
// callback of its own, or continuous dispatch.
//
// Budgets. Of tests: what the coarsest answers take is found first and held back, so a step exceeds its budget only where
// they alone do (those of compounds within compounds, and of all pairs with a near callback of a program's own, are held back
// as they were in the step before); repeats bit for bit. Of time: compared with a clock (StepBudget.h), of the whole dispatch. Continuous dispatch is not budgeted.
#pragma once
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>

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
	// The context must be the one registerAlgorithm is given for this dispatcher, and outlive it.
	btClodDispatcher(btCollisionConfiguration* configuration, clod::Context* context);
	~btClodDispatcher() override;

	// 1 at first, as the functions that a program gives a context (pairMetric, own thresholds) are then called by no
	// other thread; with more they are called by several at once. 0: as many as the machine has cores.
	void setThreads(unsigned count);
	unsigned threads() const;

	void dispatchAllCollisionPairs(btOverlappingPairCache* pairCache, const btDispatcherInfo& info,
								   btDispatcher* dispatcher) override;
	// The same for some pairs, in this order, once more within a step: of that step's budget.
	void dispatchPairs(const std::vector<btBroadphasePair*>& pairs, const btDispatcherInfo& info);

	clod::StepBudget& stepBudget();

private:
	struct Step;
	void beginBudget(const btDispatcherInfo& info);
	void listJobs(const std::vector<btBroadphasePair*>& pairs, const btDispatcherInfo& info);
	void outline(const btDispatcherInfo& info);
	void prepare(const btDispatcherInfo& info);
	void refine();

	clod::Context& m_context;
	std::unique_ptr<Step> m_step;
};
