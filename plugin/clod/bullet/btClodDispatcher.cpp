// SPDX-License-Identifier: Zlib
#include "clod/bullet/btClodDispatcher.h"

#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <thread>

#include "clod/bullet/Context.h"
#include "clod/bullet/PairState.h"
#include "clod/bullet/btClodCollisionAlgorithm.h"
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
btClodCollisionAlgorithm* oursOf(const btBroadphasePair& pair)
{
	return dynamic_cast<btClodCollisionAlgorithm*>(pair.m_algorithm);
}

bool isClod(const btCollisionShape& shape)
{
	return dynamic_cast<const btClodShape*>(&shape) != nullptr;
}
// Bullet reads its triangles or vertices without a trace.
bool isShared(const btCollisionShape& shape)
{
	const int type = shape.getShapeType();
	if (shape.isConvex()) return type != CUSTOM_POLYHEDRAL_SHAPE_TYPE && type != CUSTOM_CONVEX_SHAPE_TYPE;
	return isClod(shape) || type == STATIC_PLANE_PROXYTYPE || type == TRIANGLE_MESH_SHAPE_PROXYTYPE ||
		   type == SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE || type == TERRAIN_SHAPE_PROXYTYPE;
}
}  // namespace

struct btClodDispatcher::Step
{
	struct Job
	{
		btClodCollisionAlgorithm* algorithm;
		const btCollisionObject *object0, *object1;
	};
	clod::StepBudget budget;
	std::unique_ptr<clod::ThreadPool> pool = std::make_unique<clod::ThreadPool>(1);
	std::vector<btBroadphasePair*> pairs;
	std::vector<Job> jobs;
};

btClodDispatcher::btClodDispatcher(btCollisionConfiguration* configuration, clod::Context* context)
	: btCollisionDispatcher(configuration), m_context(*context), m_step(std::make_unique<Step>())
{
}
btClodDispatcher::~btClodDispatcher() = default;

void btClodDispatcher::setThreads(unsigned count)
{
	if (count == 0) count = std::max(1U, std::thread::hardware_concurrency());
	if (count != threads()) m_step->pool = std::make_unique<clod::ThreadPool>(count);
}
unsigned btClodDispatcher::threads() const
{
	return m_step->pool->threads();
}
clod::StepBudget& btClodDispatcher::stepBudget()
{
	return m_step->budget;
}

void btClodDispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* pairCache, const btDispatcherInfo& info,
												 btDispatcher* dispatcher)
{
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
}

void btClodDispatcher::dispatchPairs(const std::vector<btBroadphasePair*>& pairs, const btDispatcherInfo& info)
{
	listJobs(pairs, info);
	outline(info);
	prepare(info);
	for (btBroadphasePair* pair : pairs) getNearCallback()(*pair, *this, info);
}

void btClodDispatcher::beginBudget(const btDispatcherInfo& info)
{
	const bool isDiscrete = info.m_dispatchFunc == btDispatcherInfo::DISPATCH_DISCRETE;
	m_step->budget.begin(isDiscrete ? m_context.usableBudget() : clod::Budget{});
}

// What the coarsest answers of all pairs take, before any is answered.
void btClodDispatcher::outline(const btDispatcherInfo& info)
{
	BT_PROFILE("btClodDispatcher::outline");
	const auto outlineOne = [&](std::uint32_t i)
	{
		const Step::Job& job = m_step->jobs[i];
		job.algorithm->outline(wrapped(job.object0), wrapped(job.object1), info);
	};
	if (m_step->budget.isLimited()) m_step->pool->run(std::uint32_t(m_step->jobs.size()), outlineOne);
}

// What Bullet's dispatch will find done already.
void btClodDispatcher::prepare(const btDispatcherInfo& info)
{
	if (threads() == 1 || m_step->budget.isCounted()) return;
	BT_PROFILE("btClodDispatcher::prepare");
	const auto prepareOne = [&](std::uint32_t i)
	{
		const Step::Job& job = m_step->jobs[i];
		job.algorithm->prepare(wrapped(job.object0), wrapped(job.object1), info);
	};
	m_step->pool->run(std::uint32_t(m_step->jobs.size()), prepareOne);
}

// Pairs that Bullet's dispatch is sure to ask, and that several threads may.
void btClodDispatcher::listJobs(const std::vector<btBroadphasePair*>& pairs, const btDispatcherInfo& info)
{
	m_step->jobs.clear();
	if ((threads() == 1 && !m_step->budget.isLimited()) || info.m_dispatchFunc != btDispatcherInfo::DISPATCH_DISCRETE ||
		getNearCallback() != &btCollisionDispatcher::defaultNearCallback)
		return;
	for (btBroadphasePair* pair : pairs)
	{
		btCollisionObject *object0 = objectOf(pair->m_pProxy0), *object1 = objectOf(pair->m_pProxy1);
		const btCollisionShape &shape0 = *object0->getCollisionShape(), &shape1 = *object1->getCollisionShape();
		if (!isShared(shape0) || !isShared(shape1) || !(isClod(shape0) || isClod(shape1))) continue;
		if (!needsCollision(object0, object1)) continue;
		const btCollisionObjectWrapper body0 = wrapped(object0), body1 = wrapped(object1);
		if (!pair->m_algorithm) pair->m_algorithm = findAlgorithm(&body0, &body1, nullptr, BT_CONTACT_POINT_ALGORITHMS);
		if (btClodCollisionAlgorithm* algorithm = oursOf(*pair)) m_step->jobs.push_back({algorithm, object0, object1});
	}
}
