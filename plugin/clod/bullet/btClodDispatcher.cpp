// SPDX-License-Identifier: Zlib
#include "clod/bullet/btClodDispatcher.h"

#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <tuple>
#include <vector>

#include "clod/bullet/PairState.h"
#include "clod/bullet/WholeStep.h"
#include "clod/bullet/btClodCollisionAlgorithm.h"
#include "clod/query/AnswerCost.h"
#include "clod/query/Clock.h"

namespace
{
using clod::Clock;
using clod::microsecondsSince;

// Takes a context's budget away for a while.
class WithoutBudget
{
public:
	explicit WithoutBudget(clod::Context& context) : m_context(context), m_budget(context.budget)
	{
		context.budget = clod::Budget{};
	}
	~WithoutBudget() { m_context.budget = m_budget; }
	WithoutBudget(const WithoutBudget&) = delete;
	WithoutBudget& operator=(const WithoutBudget&) = delete;

private:
	clod::Context& m_context;
	const clod::Budget m_budget;
};

bool isClod(const btCollisionObject& object)
{
	return dynamic_cast<const btClodShape*>(object.getCollisionShape()) != nullptr;
}
btCollisionObject* objectOf(const btBroadphaseProxy* proxy)
{
	return static_cast<btCollisionObject*>(proxy->m_clientObject);
}

struct Planned
{
	int low, high;  // broadphase ids: Bullet's order of pairs is not always the same
	clod::PairPlan plan;
	// The heap's front is the worst; ties by s* over the radius, then by id.
	static bool isBetter(const Planned& l, const Planned& r)
	{
		const auto key = [](const Planned& p)
		{ return std::make_tuple(p.plan.query.excess(), p.plan.query.deviation() / p.plan.radius, -p.low, -p.high); };
		return key(l) < key(r);
	}
};
}  // namespace

struct btClodDispatcher::Step
{
	std::vector<Planned> planned;
	std::vector<std::uint32_t> queue;  // a heap of indices into planned
	clod::AnswerCost answerCost{10};   // of dispatches after planning, an answer is a pair of nodes
	clod::WholeStep whole;
};

btClodDispatcher::btClodDispatcher(btCollisionConfiguration* configuration, clod::Context* context)
	: btCollisionDispatcher(configuration), m_context(*context), m_step(std::make_unique<Step>())
{
}
btClodDispatcher::~btClodDispatcher() = default;

void btClodDispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* pairCache, const btDispatcherInfo& info,
												 btDispatcher* dispatcher)
{
	const clod::Budget budget = m_context.budget;
	if (!budget.isLimited() || !clod::budgetError(budget).empty() ||
		info.m_dispatchFunc != btDispatcherInfo::DISPATCH_DISCRETE)
	{
		btCollisionDispatcher::dispatchAllCollisionPairs(pairCache, info, dispatcher);
		return;
	}
	const bool isOfTime = budget.microseconds < clod::kOff && !(budget.tests < clod::kOff);
	if (isOfTime && m_step->whole.isDue(budget.microseconds))
	{
		dispatchWhole(pairCache, info, dispatcher);
		return;
	}
	const Clock::time_point start = Clock::now();
	m_step->planned.clear();
	plan(*pairCache, info);
	m_answers = refine(budget, microsecondsSince(start));
	const double excess = m_step->queue.empty() ? 0 : m_step->planned[m_step->queue.front()].plan.query.excess();
	if (isOfTime) m_step->whole.observeRefined(excess, budget.microseconds);
	const Clock::time_point answering = Clock::now();
	btCollisionDispatcher::dispatchAllCollisionPairs(pairCache, info, dispatcher);
	m_step->answerCost.observe(m_answers, microsecondsSince(answering));
	m_step->planned.clear();
}

void btClodDispatcher::dispatchWhole(btOverlappingPairCache* pairCache, const btDispatcherInfo& info,
									 btDispatcher* dispatcher)
{
	const double budget = m_context.budget.microseconds;
	const WithoutBudget unlimited(m_context);
	const Clock::time_point start = Clock::now();
	btCollisionDispatcher::dispatchAllCollisionPairs(pairCache, info, dispatcher);
	m_step->whole.observeWhole(microsecondsSince(start), budget);
}

// Every pair of two shapes of ours at its coarsest valid answer.
void btClodDispatcher::plan(btOverlappingPairCache& pairCache, const btDispatcherInfo& info)
{
	BT_PROFILE("btClodDispatcher::plan");
	btBroadphasePair* pairs = pairCache.getOverlappingPairArrayPtr();
	for (int i = 0; i < pairCache.getNumOverlappingPairs(); ++i)
	{
		btBroadphasePair& pair = pairs[i];
		btCollisionObject *object0 = objectOf(pair.m_pProxy0), *object1 = objectOf(pair.m_pProxy1);
		if (!isClod(*object0) || !isClod(*object1) || !needsCollision(object0, object1)) continue;
		const btCollisionObjectWrapper body0(nullptr, object0->getCollisionShape(), object0,
											 object0->getWorldTransform(), -1, -1);
		const btCollisionObjectWrapper body1(nullptr, object1->getCollisionShape(), object1,
											 object1->getWorldTransform(), -1, -1);
		if (!pair.m_algorithm) pair.m_algorithm = findAlgorithm(&body0, &body1, nullptr, BT_CONTACT_POINT_ALGORITHMS);
		auto* algorithm = dynamic_cast<btClodCollisionAlgorithm*>(pair.m_algorithm);
		if (!algorithm) continue;
		if (auto plan = algorithm->plan(body0, body1, info))
			m_step->planned.push_back({std::min(pair.m_pProxy0->m_uniqueId, pair.m_pProxy1->m_uniqueId),
								 std::max(pair.m_pProxy0->m_uniqueId, pair.m_pProxy1->m_uniqueId), *plan});
	}
}

// The worst pair of nodes of all pairs, again and again, as long as the budget pays for it and for all answers.
std::uint64_t btClodDispatcher::refine(const clod::Budget& budget, double already)
{
	BT_PROFILE("btClodDispatcher::refine");
	const Clock::time_point start = Clock::now();
	const auto isBetter = [this](std::uint32_t l, std::uint32_t r)
	{ return Planned::isBetter(m_step->planned[l], m_step->planned[r]); };
	const double tests = budget.tests - m_context.unplannedShare();
	std::uint64_t committed = 0, answers = 0;
	m_step->queue.clear();
	for (std::uint32_t i = 0; i < m_step->planned.size(); ++i)
	{
		const clod::PairPlan& plan = m_step->planned[i].plan;
		committed += plan.query.committed();
		answers += plan.query.answers();
		if (plan.query.excess() > 0) m_step->queue.push_back(i);
	}
	std::make_heap(m_step->queue.begin(), m_step->queue.end(), isBetter);
	while (!m_step->queue.empty())
	{
		clod::QueryPlan& plan = m_step->planned[m_step->queue.front()].plan.query;
		if (double(committed + plan.cost()) > tests) return answers;
		if (budget.microseconds < clod::kOff)
		{
			const double answer = m_step->answerCost.estimate(double(answers) + 0.5 * double(plan.cost()));
			if (already + microsecondsSince(start) + answer > budget.microseconds) return answers;
		}
		committed -= plan.committed();
		answers -= plan.answers();
		std::pop_heap(m_step->queue.begin(), m_step->queue.end(), isBetter);
		plan.refine();
		committed += plan.committed();
		answers += plan.answers();
		if (plan.excess() > 0)
			std::push_heap(m_step->queue.begin(), m_step->queue.end(), isBetter);
		else
			m_step->queue.pop_back();
	}
	return answers;
}
