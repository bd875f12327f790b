// SPDX-License-Identifier: Zlib
#include "clod/bullet/btClodDynamicsWorld.h"

#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btQuickprof.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "clod/bullet/BodyState.h"
#include "clod/bullet/PairState.h"
#include "clod/bullet/btClodCollisionAlgorithm.h"
#include "clod/bullet/btClodDispatcher.h"

namespace
{
// Surprise (PairState::surprise), in skins, that a step may leave without being divided: 0.2 % of the smaller radius.
constexpr double kMostSurprise = 4;
// Contacts that give bodies energy are a surprise that takes as many parts as may be.
constexpr double kGain = std::numeric_limits<double>::infinity();

// A solver that leaves bodies by more skins beneath what contacts require (PairState::unmet) goes on, so often at most, each
// time for so many times as many iterations; less often once it was in vain in a step.
constexpr double kMostUnmet = 1;
constexpr int kMostMore = 4, kMoreInVain = 2, kLonger = 4;

template <class States>
void putAll(const States& states)
{
	for (const auto& state : states)
	{
		state.body->setWorldTransform(state.pose);
		state.body->setLinearVelocity(state.linear);
		state.body->setAngularVelocity(state.angular);
	}
}

template <class Visit>
void forEachPoint(btDispatcher& dispatcher, const Visit& visit)
{
	for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
	{
		btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
		for (int k = 0; k < manifold.getNumContacts(); ++k) visit(manifold.getContactPoint(k));
	}
}

}  // namespace

btClodDynamicsWorld::btClodDynamicsWorld(btDispatcher* dispatcher, btBroadphaseInterface* pairCache,
										 btConstraintSolver* solver, btCollisionConfiguration* configuration,
										 clod::Context* context)
	: btDiscreteDynamicsWorld(dispatcher, pairCache, solver, configuration), m_context(*context)
{
}

void btClodDynamicsWorld::solveConstraints(btContactSolverInfo& info)
{
	m_passes = 0;
	m_parts = 1;
	m_pairsAskedAgain = 0;
	m_mostMore = kMostMore;
	m_lastPart = 0;
	if (m_stepping == Stepping::kImpacts && m_mostParts > 1)
	{
		solveToImpacts(info);
		return;
	}
	if (m_expectedParts > 1)
	{
		solveInParts(info, m_expectedParts, true);
		return;
	}
	const int parts = partsFor(solveInPasses(info));
	if (parts == 1) return;
	putBack();
	solveInParts(info, parts, false);
}

// Into how many parts a step is to be divided that left so much surprise. What contacts miss of a motion grows with the
// square of the time.
int btClodDynamicsWorld::partsFor(double surprise) const
{
	int parts = 1;
	while (2 * parts <= m_mostParts && parts * parts * kMostSurprise < surprise) parts *= 2;
	return parts;
}

double btClodDynamicsWorld::solveInPasses(btContactSolverInfo& info)
{
	const int last = m_passes + m_mostPasses;
	remember(info.m_timeStep);
	solveOnce(info);
	if (++m_passes >= last && m_mostParts <= 1) return 0;
	solveOn(info);
	for (;;)
	{
		BT_PROFILE("btClodDynamicsWorld::pass");
		predictSolved(info.m_timeStep);
		const double surprise = findSurprised();
		if (m_surprised.empty() || m_passes >= last)
			return mayDivide() && givesEnergy(info.m_timeStep) ? kGain : surprise;
		putBack();
		askAgain();
		solveAgain(info);
		solveOn(info);
		++m_passes;
	}
}

// What was found since the dispatch began comes in its place, too.
void btClodDynamicsWorld::solveOnce(btContactSolverInfo& info)
{
	clod::SolverOrder::arrange(*getDispatcher());
	btDiscreteDynamicsWorld::solveConstraints(info);
}

// From where the step began, with the whole impulses of the solve before, as both are of the same step.
void btClodDynamicsWorld::solveAgain(btContactSolverInfo& info)
{
	calculateSimulationIslands();  // a solve uses them up
	const btScalar factor = std::exchange(info.m_warmstartingFactor, btScalar(1));
	solveOnce(info);
	info.m_warmstartingFactor = factor;
}

// Goes on where a solver's iterations were too few, as where a light body lies between heavy ones, for as long as that
// helps: rows that contradict each other, as rebounds may, only get larger impulses. Each solve takes more iterations than
// the last, as Bullet begins friction from nothing: after as many it ends where the last one did.
void btClodDynamicsWorld::solveOn(btContactSolverInfo& info)
{
	m_context.pairsOf(*getDispatcher(), m_pairs);
	const int iterations = info.m_numIterations;
	double left = mostUnmet();
	for (int more = 0; more < m_mostMore && left > kMostUnmet; ++more)
	{
		keepSolution();
		putBack();
		info.m_numIterations *= kLonger;
		solveAgain(info);
		const double now = mostUnmet();
		if (now >= left)
		{
			takeBackSolution();
			break;
		}
		left = now;
	}
	info.m_numIterations = iterations;
	if (left > kMostUnmet) m_mostMore = kMoreInVain;
}

double btClodDynamicsWorld::mostUnmet()
{
	double most = 0;
	for (const clod::PairState* pair : m_pairs)
		if (isSolved(pair->lastReport().objectA, pair->lastReport().objectB)) most = std::max(most, pair->unmet());
	return most;
}

void btClodDynamicsWorld::keepSolution()
{
	m_solved.clear();
	for (const Start& start : m_starts)
	{
		const btRigidBody& body = *start.body;
		m_solved.push_back({start.body, body.getWorldTransform(), body.getLinearVelocity(), body.getAngularVelocity()});
	}
	m_impulses.clear();
	forEachPoint(*getDispatcher(),
				 [this](btManifoldPoint& point)
				 {
					 for (const btScalar impulse : {point.m_appliedImpulse, point.m_appliedImpulseLateral1, point.m_appliedImpulseLateral2})
						 m_impulses.push_back(impulse);
				 });
}

void btClodDynamicsWorld::takeBackSolution()
{
	putAll(m_solved);
	auto impulse = m_impulses.begin();
	forEachPoint(*getDispatcher(),
				 [&](btManifoldPoint& point)
				 {
					 for (btScalar* to : {&point.m_appliedImpulse, &point.m_appliedImpulseLateral1, &point.m_appliedImpulseLateral2})
						 *to = *impulse++;
				 });
}

// Solves a part of the step. Joints correct their errors at the same rate as in a whole step: Bullet's share of the
// error in each part, however short, would throw bodies.
double btClodDynamicsWorld::solvePart(btContactSolverInfo& info, btScalar whole, bool isShortest)
{
	const btScalar erp = std::exchange(info.m_erp, info.m_erp * (info.m_timeStep / whole));
	const double surprise = solveInPasses(info);
	const bool gives = isShortest && (mayDivide() ? surprise == kGain : givesEnergy(info.m_timeStep));
	if (gives) solveWithoutRebounds(info);
	info.m_erp = erp;
	return surprise;
}

// isBegun: the contacts are those of the first part already. A part that leaves too much surprise is put back, and it and
// what follows are taken in shorter ones.
void btClodDynamicsWorld::solveInParts(btContactSolverInfo& info, int parts, bool isBegun)
{
	const btScalar whole = info.m_timeStep;
	noteKinematic();
	info.m_timeStep = whole / btScalar(parts);
	double surprise = 0;
	for (int part = 0; part < parts;)
	{
		if (!isBegun) beginPart(info.m_timeStep);
		isBegun = false;
		const double left = solvePart(info, whole, parts == m_mostParts);
		if (const int more = std::min(partsFor(left), m_mostParts / parts); more > 1)
		{
			putBack();
			part *= more;
			parts *= more;
			surprise /= more * more;
			info.m_timeStep = whole / btScalar(parts);
			continue;
		}
		surprise = std::max(surprise, left);
		if (++part < parts) goOn(info.m_timeStep, btScalar(part) * info.m_timeStep);
	}
	moveKinematic(0);
	m_parts = parts;
	m_expectedParts = std::max(partsFor(parts * parts * surprise), parts / 2);
	m_lastPart = info.m_timeStep;
	info.m_timeStep = getDispatchInfo().m_timeStep = whole;
}

void btClodDynamicsWorld::internalSingleStepSimulation(btScalar timeStep)
{
	m_expectedParts = m_stepping == Stepping::kImpacts ? 1 : std::min(m_expectedParts, m_mostParts);
	m_nextPart = m_expectedParts > 1 ? timeStep / btScalar(m_expectedParts) : 0;
	btDiscreteDynamicsWorld::internalSingleStepSimulation(timeStep);
}

void btClodDynamicsWorld::performDiscreteCollisionDetection()
{
	const btScalar part = std::exchange(m_nextPart, btScalar(0));
	if (part > 0)
	{
		predictFree(part);
		getDispatchInfo().m_timeStep = part;
	}
	bool& mayFollow = m_context.sharedIn(*getDispatcher()).mayFollow;
	mayFollow = m_mostPasses > 1;
	btDiscreteDynamicsWorld::performDiscreteCollisionDetection();
	mayFollow = false;
}

void btClodDynamicsWorld::integrateTransforms(btScalar timeStep)
{
	btDiscreteDynamicsWorld::integrateTransforms(m_lastPart > 0 ? m_lastPart : timeStep);
}

// To the end of a part. gone: the time since the step began.
void btClodDynamicsWorld::goOn(btScalar timeStep, btScalar gone)
{
	btDiscreteDynamicsWorld::integrateTransforms(timeStep);
	moveKinematic(gone);
}

void btClodDynamicsWorld::noteKinematic()
{
	m_kinematic.clear();
	for (int i = 0; i < m_collisionObjects.size(); ++i)
		if (btRigidBody* body = btRigidBody::upcast(m_collisionObjects[i]); body && body->isKinematicObject())
			m_kinematic.push_back({body, body->getWorldTransform(), body->getInterpolationWorldTransform()});
}

// Kinematic bodies go on from where the step began by their velocities, which is also what the solver and whole steps
// assume. They stay there for all passes of a part. gone: the time since then; 0 puts them back.
void btClodDynamicsWorld::moveKinematic(btScalar gone)
{
	for (const Kinematic& kinematic : m_kinematic)
	{
		btRigidBody& body = *kinematic.body;
		body.setWorldTransform(kinematic.pose);
		if (gone > 0) body.predictIntegratedTransform(gone, body.getWorldTransform());
		body.setInterpolationWorldTransform(gone > 0 ? body.getWorldTransform() : kinematic.interpolation);
	}
}

// Finds the contacts for a part of the step.
void btClodDynamicsWorld::beginPart(btScalar timeStep)
{
	m_nextPart = timeStep;
	performDiscreteCollisionDetection();
	calculateSimulationIslands();
}

void btClodDynamicsWorld::remember(btScalar timeStep)
{
	m_starts.clear();
	for (int i = 0; i < m_nonStaticRigidBodies.size(); ++i)
	{
		btRigidBody* body = m_nonStaticRigidBodies[i];
		if (body->isStaticOrKinematicObject()) continue;
		m_starts.push_back({{body, body->getWorldTransform(), body->getLinearVelocity(), body->getAngularVelocity()},
							clod::kineticEnergy(*body, 0), clod::kineticEnergy(*body, double(timeStep))});
	}
}

// Sets the interpolation transforms to where the bodies would come without contacts.
void btClodDynamicsWorld::predictFree(btScalar timeStep)
{
	for (int i = 0; i < m_nonStaticRigidBodies.size(); ++i)
	{
		btRigidBody& body = *m_nonStaticRigidBodies[i];
		if (clod::isMoving(body)) body.predictIntegratedTransform(timeStep, body.getInterpolationWorldTransform());
	}
}

// Puts the motion as solved into the interpolation velocities and transforms, where pairs look for it (BodyState.h).
// Bullet sets them anew at the end of the step.
void btClodDynamicsWorld::predictSolved(btScalar timeStep)
{
	for (const Start& start : m_starts)
	{
		btRigidBody& body = *start.body;
		if (!clod::isMoving(body)) continue;
		btTransform then;
		btTransformUtil::integrateTransform(start.pose, body.getLinearVelocity(), body.getAngularVelocity(), timeStep, then);
		body.setInterpolationWorldTransform(then);
		body.setInterpolationLinearVelocity(body.getLinearVelocity());
		body.setInterpolationAngularVelocity(body.getAngularVelocity());
	}
}

void btClodDynamicsWorld::putBack()
{
	putAll(m_starts);
}

// Does the solver move a pair's bodies, and by its contacts?
bool btClodDynamicsWorld::isSolved(const btCollisionObject* a, const btCollisionObject* b)
{
	return a && b && (clod::isMoving(*a) || clod::isMoving(*b)) && getDispatcher()->needsResponse(a, b);
}

// Lists the pairs that move otherwise than their contacts expect. Returns the largest surprise, in skins of its pair.
double btClodDynamicsWorld::findSurprised()
{
	double largest = 0;
	m_surprised.clear();
	m_context.pairsOf(*getDispatcher(), m_pairs);
	for (const clod::PairState* pair : m_pairs)
	{
		const btCollisionObject *a = pair->lastReport().objectA, *b = pair->lastReport().objectB;
		if (!isSolved(a, b)) continue;
		const double surprise = pair->surprise();
		if (!(surprise > 1)) continue;
		btBroadphaseProxy* low = const_cast<btBroadphaseProxy*>(a->getBroadphaseHandle());
		btBroadphaseProxy* high = const_cast<btBroadphaseProxy*>(b->getBroadphaseHandle());
		if (!low || !high) continue;
		largest = std::max(largest, surprise);
		if (low->m_uniqueId > high->m_uniqueId) std::swap(low, high);
		m_surprised.push_back({low, high});
	}
	// All pairs of a compound's children are one pair of bodies here.
	const auto key = [](const Surprised& s) { return std::make_pair(s.low->m_uniqueId, s.high->m_uniqueId); };
	std::sort(m_surprised.begin(), m_surprised.end(),
			  [&](const Surprised& l, const Surprised& r) { return key(l) < key(r); });
	m_surprised.erase(std::unique(m_surprised.begin(), m_surprised.end(),
								  [&](const Surprised& l, const Surprised& r) { return key(l) == key(r); }),
					  m_surprised.end());
	return largest;
}

void btClodDynamicsWorld::updateAabbs()
{
	btDiscreteDynamicsWorld::updateAabbs();
	const btScalar timeStep = getDispatchInfo().m_timeStep;
	const bool meetsImpacts = m_mostPasses > 1 || m_mostParts > 1;
	for (int i = 0; i < m_collisionObjects.size(); ++i)
	{
		const btCollisionObject& body = *m_collisionObjects[i];
		const bool goesOn = body.isKinematicObject() ? body.isActive() : meetsImpacts && clod::isMoving(body);
		if (!goesOn) continue;
		const clod::RelativeMotion motion = clod::worldMotion(body, double(timeStep));
		const btTransform& pose = body.getWorldTransform();
		const btVector3 linear = clod::toBullet(motion.velocity(clod::toVec3(pose.getOrigin()))), angular = clod::toBullet(motion.angular);
		if (linear.fuzzyZero() && angular.fuzzyZero()) continue;
		btTransform then;
		btTransformUtil::integrateTransform(pose, linear, angular, timeStep, then);
		btVector3 center;
		btScalar radius = 0;
		body.getCollisionShape()->getBoundingSphere(center, radius);
		const btScalar halfTurn = btScalar(0.5) * timeStep * angular.length();
		widenBox(body, then, (radius + center.length()) * (1 - btCos(btMin(halfTurn, SIMD_PI))));
	}
}

void btClodDynamicsWorld::widenBox(const btCollisionObject& object, const btTransform& then, btScalar bend)
{
	btBroadphaseProxy* proxy = const_cast<btBroadphaseProxy*>(object.getBroadphaseHandle());
	btVector3 low, high, oldLow, oldHigh;
	object.getCollisionShape()->getAabb(then, low, high);
	const btScalar beside = gContactBreakingThreshold + bend;
	low -= btVector3(beside, beside, beside);
	high += btVector3(beside, beside, beside);
	getBroadphase()->getAabb(proxy, oldLow, oldHigh);
	low.setMin(oldLow);
	high.setMax(oldHigh);
	if (low != oldLow || high != oldHigh) getBroadphase()->setAabb(proxy, low, high, getDispatcher());
}

void btClodDynamicsWorld::askAgain()
{
	for (const Surprised& pair : m_surprised)
		for (const btBroadphaseProxy* proxy : {pair.low, pair.high})
		{
			const auto& object = *static_cast<const btCollisionObject*>(proxy->m_clientObject);
			if (clod::isMoving(object)) widenBox(object, object.getInterpolationWorldTransform());
		}
	computeOverlappingPairs();
	btOverlappingPairCache& cache = *getBroadphase()->getOverlappingPairCache();
	m_asked.clear();
	for (const Surprised& asked : m_surprised)
		if (btBroadphasePair* pair = cache.findPair(asked.low, asked.high)) m_asked.push_back(pair);
	m_pairsAskedAgain += int(m_asked.size());
	btBroadphasePair* pairs = cache.getOverlappingPairArrayPtr();
	for (int i = 0; i < cache.getNumOverlappingPairs(); ++i)
		if (!pairs[i].m_algorithm) m_asked.push_back(&pairs[i]);
	clod::Context::Shared& shared = m_context.sharedIn(*getDispatcher());
	shared.mayFollow = shared.isFurther = true;
	if (auto* ours = dynamic_cast<btClodDispatcher*>(getDispatcher()))
		ours->dispatchPairs(m_asked, getDispatchInfo());
	else
	{
		auto& dispatcher = static_cast<btCollisionDispatcher&>(*getDispatcher());
		for (btBroadphasePair* pair : m_asked) dispatcher.getNearCallback()(*pair, dispatcher, getDispatchInfo());
	}
	shared.mayFollow = shared.isFurther = false;
}
