// SPDX-License-Identifier: Zlib
// Whole dispatches of one pair.
#include "demos/peers/DispatchWorld.h"

#include <LinearMath/btPoolAllocator.h>

#include "demos/runner/HeapBytes.h"
#include "demos/scenes/Stopwatch.h"

namespace clod::demo
{
DispatchWorld::DispatchWorld(btCollisionShape& a, btCollisionShape& b,
							 const std::function<void(btCollisionDispatcher&)>& addAlgorithms)
	: m_dispatcher(&m_configuration), m_world(&m_dispatcher, &m_broadphase, &m_configuration)
{
	addAlgorithms(m_dispatcher);
	btCollisionShape* shapes[2] = {&a, &b};
	for (int i = 0; i < 2; ++i)
	{
		m_bodies[i].setCollisionShape(shapes[i]);
		m_bodies[i].setCollisionFlags(0);
		m_world.addCollisionObject(&m_bodies[i]);
	}
}

DispatchWorld::~DispatchWorld()
{
	for (btCollisionObject& body : m_bodies) m_world.removeCollisionObject(&body);
}

double DispatchWorld::dispatch(const PlacedBody& a, const PlacedBody& b, double dt)
{
	const PlacedBody* placed[2] = {&a, &b};
	for (int i = 0; i < 2; ++i)
	{
		m_bodies[i].setWorldTransform(placed[i]->pose);
		m_bodies[i].setInterpolationLinearVelocity(placed[i]->linear);
		m_bodies[i].setInterpolationAngularVelocity(placed[i]->angular);
	}
	m_world.updateAabbs();
	m_world.computeOverlappingPairs();
	btDispatcherInfo& info = m_world.getDispatchInfo();
	info.m_timeStep = btScalar(dt);
	const double before = heapBytes();
	const Stopwatch watch(TimedBy::thread);
	m_dispatcher.dispatchAllCollisionPairs(m_broadphase.getOverlappingPairCache(), info, &m_dispatcher);
	const double time = watch.microseconds();
	m_heapBytes += heapBytes() - before;
	return time;
}

double DispatchWorld::pairBytes()
{
	double bytes = m_heapBytes;
	for (btPoolAllocator* pool : {m_configuration.getPersistentManifoldPool(), m_configuration.getCollisionAlgorithmPool()})
		bytes += double(pool->getUsedCount()) * pool->getElementSize();
	return bytes;
}

int DispatchWorld::points() const
{
	int count = 0;
	for (int i = 0; i < m_dispatcher.getNumManifolds(); ++i)
		count += m_dispatcher.getManifoldByIndexInternal(i)->getNumContacts();
	return count;
}
}  // namespace clod::demo
