// SPDX-License-Identifier: Zlib
#include "clod/bullet/btClodDispatcher.h"

#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <functional>
#include <thread>

#include "clod/bullet/Context.h"
#include "clod/bullet/PairState.h"
#include "clod/bullet/btClodCollisionAlgorithm.h"
#include "clod/bullet/btClodCompoundAlgorithm.h"
#include "clod/schedule/StepBudget.h"
#include "clod/schedule/ThreadPool.h"

namespace
{
btCollisionObject* objectOf(const btBroadphaseProxy* proxy)
{
	return static_cast<btCollisionObject*>(proxy->m_clientObject);
}
btCollisionObjectWrapper wrapped(const btCollisionObject* object)
{
	return {nullptr, object->getCollisionShape(), object, object->getWorldTransform(), -1, -1};
}
bool isClod(const btCollisionShape& shape)
{
	return dynamic_cast<const btClodShape*>(&shape) != nullptr;
}
// May several threads read this shape at once? Yes where Bullet reads its triangles or vertices without changing it.
bool isShared(const btCollisionShape& shape)
{
	const int type = shape.getShapeType();
	if (type == UNIFORM_SCALING_SHAPE_PROXYTYPE)
		return isShared(*static_cast<const btUniformScalingShape&>(shape).getChildShape());
	if (shape.isConvex()) return type != CUSTOM_POLYHEDRAL_SHAPE_TYPE && type != CUSTOM_CONVEX_SHAPE_TYPE;
	return isClod(shape) || type == STATIC_PLANE_PROXYTYPE || type == TRIANGLE_MESH_SHAPE_PROXYTYPE ||
		   type == SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE || type == TERRAIN_SHAPE_PROXYTYPE;
}
// A first look at a shape: may its pairs be ours? Whether they are, is decided when they are asked.
bool mayBeOurs(const btCollisionShape& shape)
{
	return shape.isCompound() || isClod(shape);
}
// Is this no world's, but the cache of a ghost? A character has it dispatched between the steps.
bool isOfGhost(btOverlappingPairCache& cache)
{
	if (cache.getNumOverlappingPairs() == 0) return false;
	const btBroadphasePair& first = cache.getOverlappingPairArrayPtr()[0];
	for (const btBroadphaseProxy* proxy : {first.m_pProxy0, first.m_pProxy1})
		if (auto* ghost = dynamic_cast<btPairCachingGhostObject*>(objectOf(proxy)))
			if (ghost->getOverlappingPairCache() == &cache) return true;
	return false;
}
}  // namespace

struct btClodDispatcher::Step
{
	// A body, or a compound's child, as it was listed.
	struct Side
	{
		const btCollisionObject* object;
		const btCollisionShape* shape;
		btTransform pose;
		int child;
		bool isChild;
		explicit Side(const btCollisionObjectWrapper& body)
			: object(body.getCollisionObject()),
			  shape(body.getCollisionShape()),
			  pose(body.getWorldTransform()),
			  child(body.m_index),
			  isChild(body.m_parent != nullptr)
		{
		}
		btCollisionObjectWrapper in(const btCollisionObjectWrapper& whole) const
		{
			return {isChild ? &whole : nullptr, shape, object, pose, -1, child};
		}
	};
	struct Job
	{
		clod::PairState* pair;
		Side side0, side1;
	};
	using Act = void (clod::PairState::*)(const btCollisionObjectWrapper&, const btCollisionObjectWrapper&,
										  const btDispatcherInfo&);
	// Does `act` for all jobs: on all threads, or one after the other in their order, as counted budgets need it.
	void run(Act act, const btDispatcherInfo& info, bool isInOrder = false)
	{
		const auto runOne = [&](std::uint32_t i)
		{
			const Job& job = jobs[i];
			const btCollisionObjectWrapper whole0 = wrapped(job.side0.object), whole1 = wrapped(job.side1.object);
			(job.pair->*act)(job.side0.in(whole0), job.side1.in(whole1), info);
		};
		if (isInOrder)
			for (std::uint32_t i = 0; i < jobs.size(); ++i) runOne(i);
		else
			pool->run(std::uint32_t(jobs.size()), std::ref(runOne));  // which needs no memory
	}
	clod::StepBudget budget;
	std::unique_ptr<clod::ThreadPool> pool = std::make_unique<clod::ThreadPool>(1);
	std::vector<btBroadphasePair*> pairs;
	std::vector<Job> jobs;
	std::vector<std::pair<double, std::size_t>> wants;  // and how many jobs there are from theirs on
};

btClodDispatcher::btClodDispatcher(btCollisionConfiguration* configuration, clod::Context* context)
	: btCollisionDispatcher(configuration),
	  m_context(*context),
	  m_dispatch(context->sharedIn(*this).dispatch),
	  m_step(std::make_unique<Step>())
{
	m_dispatch = 1;
}
btClodDispatcher::~btClodDispatcher()
{
	m_dispatch = 0;  // another may come to live there
}

void btClodDispatcher::setThreads(unsigned count)
{
	if (count == 0) count = std::max(1U, std::thread::hardware_concurrency());
	count = std::min(count, clod::ThreadPool::kMostThreads);
	if (count != threads()) m_step->pool = std::make_unique<clod::ThreadPool>(count);
}
unsigned btClodDispatcher::threads() const
{
	return m_step->pool->threads();
}
clod::StepBudget* btClodDispatcher::stepBudget()
{
	return m_isBetweenSteps ? nullptr : &m_step->budget;
}

void btClodDispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* pairCache, const btDispatcherInfo& info,
												 btDispatcher* dispatcher)
{
	m_isBetweenSteps = isOfGhost(*pairCache);
	if (m_isBetweenSteps || pairCache->getNumOverlappingPairs() == 0)  // what holds no pairs needs no budget
	{
		btCollisionDispatcher::dispatchAllCollisionPairs(pairCache, info, dispatcher);
		m_isBetweenSteps = false;
		return;
	}
	btBroadphasePair* all = pairCache->getOverlappingPairArrayPtr();
	m_step->pairs.clear();
	for (int i = 0; i < pairCache->getNumOverlappingPairs(); ++i) m_step->pairs.push_back(&all[i]);
	beginBudget(info);
	listJobs(m_step->pairs, info);
	outline(info);
	m_context.expect(m_step->budget);
	prepare(info);
	btCollisionDispatcher::dispatchAllCollisionPairs(pairCache, info, dispatcher);
	m_step->budget.end();
	++m_dispatch;
}

void btClodDispatcher::dispatchPairs(const std::vector<btBroadphasePair*>& pairs, const btDispatcherInfo& info)
{
	listJobs(pairs, info);
	outline(info);
	prepare(info);
	for (btBroadphasePair* pair : pairs) getNearCallback()(*pair, *this, info);
	++m_dispatch;
}

void btClodDispatcher::beginBudget(const btDispatcherInfo& info)
{
	const bool isDiscrete = info.m_dispatchFunc == btDispatcherInfo::DISPATCH_DISCRETE;
	m_step->budget.begin(isDiscrete ? m_context.usableBudget() : clod::Budget{});
}

// Finds the coarsest answers of all pairs, so that what they cost is known before any pair is answered.
void btClodDispatcher::outline(const btDispatcherInfo& info)
{
	BT_PROFILE("btClodDispatcher::outline");
	if (m_step->budget.isLimited()) m_step->run(&clod::PairState::outline, info);
}

// Prepares the answers of all pairs ahead of Bullet's dispatch, which then only writes them.
void btClodDispatcher::prepare(const btDispatcherInfo& info)
{
	if (threads() == 1 && !m_step->budget.isLimited()) return;
	BT_PROFILE("btClodDispatcher::prepare");
	m_step->run(&clod::PairState::prepare, info, m_step->budget.isCounted());
	if (m_step->budget.isLimited()) refine();
}

// Spends what the budget has left on pairs that lie still, the worst first.
void btClodDispatcher::refine()
{
	const std::vector<Step::Job>& jobs = m_step->jobs;
	auto& wants = m_step->wants;
	wants.clear();
	for (std::size_t i = 0; i < jobs.size(); ++i)
		if (const std::optional<double> want = jobs[i].pair->want()) wants.emplace_back(*want, jobs.size() - i);
	std::sort(wants.begin(), wants.end(), std::greater<>());
	m_step->budget.noneToCome();
	for (const auto& [want, from] : wants) jobs[jobs.size() - from].pair->refine();
}

// Lists the pairs that Bullet's dispatch is sure to ask and that several threads may work on. Makes all of ours, as pairs
// go by which others there are, in whatever order they are asked.
void btClodDispatcher::listJobs(const std::vector<btBroadphasePair*>& pairs, const btDispatcherInfo& info)
{
	m_step->jobs.clear();
	if (info.m_dispatchFunc != btDispatcherInfo::DISPATCH_DISCRETE ||
		getNearCallback() != &btCollisionDispatcher::defaultNearCallback)
		return;
	const bool areJobs = threads() > 1 || m_step->budget.isLimited();
	const auto listOne = [&](btCollisionAlgorithm& algorithm, const btCollisionObjectWrapper& body0,
							 const btCollisionObjectWrapper& body1)
	{
		if (!areJobs) return;
		const btCollisionShape &shape0 = *body0.getCollisionShape(), &shape1 = *body1.getCollisionShape();
		if (!isShared(shape0) || !isShared(shape1)) return;
		if (auto* ours = dynamic_cast<btClodCollisionAlgorithm*>(&algorithm))
			m_step->jobs.push_back({&ours->state(), Step::Side(body0), Step::Side(body1)});
	};
	for (btBroadphasePair* pair : pairs)
	{
		if (!areJobs && pair->m_algorithm && !dynamic_cast<btClodCompoundAlgorithm*>(pair->m_algorithm)) continue;  // is made
		btCollisionObject *object0 = objectOf(pair->m_pProxy0), *object1 = objectOf(pair->m_pProxy1);
		const btCollisionShape &shape0 = *object0->getCollisionShape(), &shape1 = *object1->getCollisionShape();
		if (!(mayBeOurs(shape0) || mayBeOurs(shape1)) || !needsCollision(object0, object1)) continue;
		const btCollisionObjectWrapper body0 = wrapped(object0), body1 = wrapped(object1);
		if (!pair->m_algorithm) pair->m_algorithm = findAlgorithm(&body0, &body1, nullptr, BT_CONTACT_POINT_ALGORITHMS);
		if (auto* compound = dynamic_cast<btClodCompoundAlgorithm*>(pair->m_algorithm))
			compound->open(body0, body1, info, listOne);
		else if (pair->m_algorithm)
			listOne(*pair->m_algorithm, body0, body1);
	}
}
