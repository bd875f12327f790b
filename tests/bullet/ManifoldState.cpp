// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bullet/ManifoldState.h"

#include <cstring>

namespace clod::test
{
namespace
{
void append(Bits& bits, double value)
{
	bits.emplace_back();
	std::memcpy(&bits.back(), &value, sizeof value);
}
void append(Bits& bits, const btVector3& v)
{
	for (int i = 0; i < 3; ++i) append(bits, double(v[i]));
}

void append(Bits& bits, const btManifoldPoint& p)
{
	for (const btVector3& v :
		 {p.m_localPointA, p.m_localPointB, p.m_positionWorldOnA, p.m_positionWorldOnB, p.m_normalWorldOnB})
		append(bits, v);
	for (const btScalar value : {p.m_distance1, p.m_combinedFriction, p.m_combinedRollingFriction,
								 p.m_combinedSpinningFriction, p.m_combinedRestitution, p.m_appliedImpulse, p.m_prevRHS,
								 p.m_appliedImpulseLateral1, p.m_appliedImpulseLateral2, p.m_contactMotion1,
								 p.m_contactMotion2, p.m_contactCFM, p.m_contactERP, p.m_frictionCFM})
		append(bits, double(value));
	for (const int value : {p.m_partId0, p.m_partId1, p.m_index0, p.m_index1, p.m_contactPointFlags, p.m_lifeTime,
							int(p.m_userPersistentData != nullptr)})
		append(bits, value);
}
}  // namespace

std::vector<btPersistentManifold*> manifoldsOf(BulletWorld& scene)
{
	std::vector<btPersistentManifold*> manifolds;
	for (int i = 0; i < scene.dispatcher.getNumManifolds(); ++i)
		manifolds.push_back(scene.dispatcher.getManifoldByIndexInternal(i));
	return manifolds;
}

Bits stateOf(BulletWorld& scene)
{
	Bits bits;
	for (const auto& body : scene.bodies)
	{
		append(bits, body->getWorldTransform().getOrigin());
		for (int i = 0; i < 3; ++i) append(bits, body->getWorldTransform().getBasis()[i]);
		append(bits, body->getLinearVelocity());
		append(bits, body->getAngularVelocity());
	}
	for (btPersistentManifold* manifold : manifoldsOf(scene))
	{
		append(bits, double(manifold->getContactBreakingThreshold()));
		append(bits, manifold->getNumContacts());
		for (int k = 0; k < manifold->getNumContacts(); ++k) append(bits, manifold->getContactPoint(k));
	}
	scene.context.forEachPair(
		[&bits](const PairReport& report)
		{
			for (const HeldPoint& held : report.clusters->points()) append(bits, held.impulse);
		});
	return bits;
}

double impulseOf(BulletWorld& scene)
{
	double sum = 0;
	for (btPersistentManifold* manifold : manifoldsOf(scene))
		for (int k = 0; k < manifold->getNumContacts(); ++k)
			sum += double(manifold->getContactPoint(k).m_appliedImpulse);
	return sum;
}
}  // namespace clod::test
