// SPDX-License-Identifier: Zlib
// Two collision objects in a world of their own, with persistent algorithms and manifolds, as a simulation has them.
// Compiled once per Bullet precision. Lengths are Bullet's (scaled).
#pragma once
#include <btBulletCollisionCommon.h>

#include <functional>

namespace clod::demo
{
// A body where, and as fast as, it was recorded.
struct PlacedBody
{
	btTransform pose;
	btVector3 linear, angular;
};

class DispatchWorld
{
public:
	// The shapes outlive the world. `addAlgorithms` sees the dispatcher before the first pair exists.
	DispatchWorld(btCollisionShape& a, btCollisionShape& b,
				  const std::function<void(btCollisionDispatcher&)>& addAlgorithms);
	~DispatchWorld();
	DispatchWorld(const DispatchWorld&) = delete;
	DispatchWorld& operator=(const DispatchWorld&) = delete;

	// CPU microseconds of one whole dispatch.
	double dispatch(const PlacedBody& a, const PlacedBody& b, double dt);
	int points() const;
	// What dispatches have taken and hold: heap, and entries of Bullet's pools.
	double pairBytes();

	// Calls visit(point on B, normal from B to A, distance) for every point of every manifold, in the world.
	template <class Visit>
	void forEachPoint(const Visit& visit) const
	{
		for (int i = 0; i < m_dispatcher.getNumManifolds(); ++i)
		{
			const btPersistentManifold& manifold = *m_dispatcher.getManifoldByIndexInternal(i);
			const bool inOrder = manifold.getBody0() == &m_bodies[0];
			for (int k = 0; k < manifold.getNumContacts(); ++k)
			{
				const btManifoldPoint& point = manifold.getContactPoint(k);
				const btVector3 normal = inOrder ? point.m_normalWorldOnB : -point.m_normalWorldOnB;
				visit(inOrder ? point.getPositionWorldOnB() : point.getPositionWorldOnA(), normal, point.getDistance());
			}
		}
	}

private:
	btDefaultCollisionConfiguration m_configuration;
	mutable btCollisionDispatcher m_dispatcher;
	btDbvtBroadphase m_broadphase;
	btCollisionWorld m_world;
	btCollisionObject m_bodies[2];
	double m_heapBytes = 0;
};
}  // namespace clod::demo
