// SPDX-License-Identifier: Zlib
// btClodDynamicsWorld: do contacts of a solved step give bodies energy, and what is done about it where no shorter parts help.
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>

#include "clod/bullet/BodyState.h"
#include "clod/bullet/PairState.h"
#include "clod/bullet/SolverTerms.h"
#include "clod/bullet/btClodDynamicsWorld.h"
#include "clod/manifold/ContactPoints.h"

namespace
{
constexpr double kMostGain = 0.02;  // of the kinetic energy: rounding, and what rows leave
}

// Did bodies gain energy as they pushed each other? Contacts only take energy: of what bodies have with the forces of the
// step, or in a rebound of what they had; then forces act along the way as solved. What moves a body by a skin is not
// counted. Bodies are left out that something else may have given energy: joints with their motors and springs, too.
bool btClodDynamicsWorld::givesEnergy(btScalar timeStep)
{
	findIslands();
	for (const Start& start : m_starts)
	{
		const btRigidBody& body = *start.body;
		btVector3 center;
		btScalar radius = 0;
		body.getCollisionShape()->getBoundingSphere(center, radius);
		const double skin = clod::kSkinShare * double(radius / timeStep), least = 0.5 * skin * skin / double(body.getInvMass());
		const btScalar work = timeStep * (body.getTotalForce().dot(body.getLinearVelocity()) +
										  body.getTotalTorque().dot(body.getAngularVelocity()));
		Island& island = islandOf(body);
		island.before += start.energy + double(work) + least;
		island.free += start.freeEnergy + least;
		island.after += clod::kineticEnergy(body, 0);
	}
	return std::any_of(m_islands.begin(), m_islands.end(), [](const Island& island) { return island.gain() > kMostGain; });
}

// Where the shortest part still gives bodies energy rebounds contradict each other, as those of a ball that two plates hold:
// there they are left out, and the impulses so far.
void btClodDynamicsWorld::solveWithoutRebounds(btContactSolverInfo& info)
{
	putBack();
	for (int i = 0; i < getDispatcher()->getNumManifolds(); ++i)
	{
		btPersistentManifold& manifold = *getDispatcher()->getManifoldByIndexInternal(i);
		if (!(std::max(islandOf(*manifold.getBody0()).gain(), islandOf(*manifold.getBody1()).gain()) > kMostGain)) continue;
		for (int k = 0; k < manifold.getNumContacts(); ++k)
		{
			btManifoldPoint& point = manifold.getContactPoint(k);
			point.m_combinedRestitution = point.m_appliedImpulse = point.m_appliedImpulseLateral1 = point.m_appliedImpulseLateral2 = 0;
		}
	}
	solveAgain(info);
	++m_passes;
}

void btClodDynamicsWorld::findIslands()
{
	const int none = m_collisionObjects.size();
	m_touching.reset(none + 1);
	m_islands.assign(std::size_t(none + 1), {});
	const auto forEachPush = [&](const auto& visit)
	{
		for (int i = 0; i < getDispatcher()->getNumManifolds(); ++i)
			if (const btPersistentManifold& manifold = *getDispatcher()->getManifoldByIndexInternal(i);
				clod::isPushing(manifold))
				visit(manifold, *manifold.getBody0(), *manifold.getBody1());
	};
	forEachPush(
		[&](const btPersistentManifold&, const btCollisionObject& a, const btCollisionObject& b)
		{
			if (rootOf(a) != none && rootOf(b) != none) m_touching.unite(rootOf(a), rootOf(b));
		});
	forEachPush([&](const btPersistentManifold& manifold, const btCollisionObject& a, const btCollisionObject& b)
				{ if (clod::isDriving(manifold)) islandOf(a).isDriven = islandOf(b).isDriven = true; });
	for (int i = 0; i < m_constraints.size(); ++i)
		if (const btTypedConstraint& joint = *m_constraints[i]; joint.isEnabled())
			islandOf(joint.getRigidBodyA()).isDriven = islandOf(joint.getRigidBodyB()).isDriven = true;
	for (const clod::PairState* pair : m_pairs)
		if (const clod::PairReport& report = pair->lastReport(); report.objectA && report.objectB)
			islandOf(*report.objectA).isOurs = islandOf(*report.objectB).isOurs = true;
}

// The last one of all is that of what no impulse moves, and of what is not in this world.
int btClodDynamicsWorld::rootOf(const btCollisionObject& object)
{
	const int index = object.getWorldArrayIndex(), none = m_collisionObjects.size();
	const bool isNone = object.isStaticOrKinematicObject() || index < 0 || index >= none || m_collisionObjects[index] != &object;
	return isNone ? none : m_touching.find(index);
}
