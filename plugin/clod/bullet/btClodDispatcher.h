// SPDX-License-Identifier: Zlib
// A collision dispatcher that spends Context::budget over a whole step: every pair of btClodShapes is first brought to
// its coarsest valid answer, then one queue over all pairs refines where the metric is exceeded by the largest factor,
// then Bullet's dispatch makes the contacts. A budget of tests is never exceeded, unless the coarsest answers
// alone cost more, and gives the same contacts every time; a
// budget of time is compared with a clock, see Query.h, and steps that fit in without being refined are not
// (WholeStep.h). Without a budget it is a btCollisionDispatcher.
//
// Pairs are planned for the poses before dispatch. Not planned are shapes inside compounds and against Bullet's convex ones
// (which get shares by what they needed last, see Context), and what has no hierarchy. Continuous dispatch is not budgeted.
//
// Based on: Otaduy & Lin 2003, sec. 3.3 and 5.2.
#pragma once
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>

#include <cstdint>
#include <memory>

#include "clod/Export.h"
#include "clod/bullet/Context.h"

class CLOD_API btClodDispatcher : public btCollisionDispatcher
{
public:
	// The context must be the one registerAlgorithm is given for this dispatcher, and outlive it.
	btClodDispatcher(btCollisionConfiguration* configuration, clod::Context* context);
	~btClodDispatcher() override;

	void dispatchAllCollisionPairs(btOverlappingPairCache* pairCache, const btDispatcherInfo& info,
								   btDispatcher* dispatcher) override;

	// Pairs of nodes that answered in the last step under a budget: what its time is reckoned by.
	std::uint64_t answers() const { return m_answers; }

private:
	struct Step;
	void dispatchWhole(btOverlappingPairCache* pairCache, const btDispatcherInfo& info, btDispatcher* dispatcher);
	void plan(btOverlappingPairCache& pairCache, const btDispatcherInfo& info);
	// Returns how many pairs of nodes will answer.
	std::uint64_t refine(const clod::Budget& budget, double already);

	clod::Context& m_context;
	std::uint64_t m_answers = 0;
	std::unique_ptr<Step> m_step;
};
