// SPDX-License-Identifier: Zlib
#include "clod/bullet/SolverTerms.h"

#include <BulletCollision/CollisionShapes/btCollisionShape.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btThreads.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "clod/bullet/BodyState.h"
#include "clod/bullet/Manifolds.h"
#include "clod/manifold/Facet.h"
#include "clod/manifold/PairSolve.h"

namespace clod
{
namespace
{
constexpr double kDepthStep = 1.0 / 240;  // s: a step in which kTakenBackShare of a depth is taken back; as much a second
										  // in longer ones,
constexpr double kMostDepthShare = 0.6;   // but no more than this
constexpr double kFarthestClosed = 2;     // skins: gaps of what carries that close slowly near rest
constexpr double kShareOfPiles = 0.05;    // closed in a step: with less, overlapping skins of coarse levels are left so,
constexpr int kOfFlat = 3;                // too, by flats: so many points of one normal carry
// In skins: a body that merely lies on a kinematic one is less deep in it than the first, and yields wholly when it is
// deeper by the second.
constexpr double kUnyielding = 20, kYielding = 200;

// The restitution to give Bullet so that bodies part with e times the speed at which they touch, wherever in the step
// that is. speed: at which they close now; pull: by how much forces raise it a second; distance: what is left to go.
double restitutionOf(double e, double speed, double pull, double distance, double dt)
{
	if (!(e > 0 && speed > 0)) return e;
	const double d = std::max(0.0, distance);
	const double later = e * e * (speed * speed + 2 * pull * d + pull * speed * dt) - 2 * pull * d;
	const double inside = 0.25 * pull * pull * dt * dt + later;
	const double rebound = inside > 0 ? -0.5 * pull * dt + std::sqrt(inside) : 0;
	return std::max(0.0, (rebound + d / dt) / speed);
}

void setRestitution(const ContactPoint& ofPoint, const WorldFrame& frame, double row, btManifoldPoint& point)
{
	if (!(point.m_combinedRestitution > 0)) return;
	const btCollisionObject *first = (frame.aIsFirst ? frame.a : frame.b)->getCollisionObject(),
							*second = (frame.aIsFirst ? frame.b : frame.a)->getCollisionObject();
	const Vec3 normal = toVec3(point.m_normalWorldOnB), onA = toVec3(point.m_positionWorldOnA),
			   onB = toVec3(point.m_positionWorldOnB);
	const auto closing = [&](double dt)
	{ return -dot(normal, worldMotion(*first, dt).velocity(onA) - worldMotion(*second, dt).velocity(onB)); };
	const double now = closing(0), then = closing(frame.timeStep);
	const double e = double(point.m_combinedRestitution);
	// On a coarse surface points of one side may be at different heights that are at one on the surface it stands for. They
	// are met together, as else the first of them would turn the body.
	double met = row;
	if (frame.points)
		for (const HeldPoint& held : frame.points->points())
		{
			const double other = frame.scale * velocityRow(held.point.height, held.point.bend);
			if (other < met && row <= other + frame.alike && dot(held.point.normal, ofPoint.normal) > kSameNormal) met = other;
		}
	const bool isMet = then * frame.timeStep >= met;
	point.m_combinedRestitution =
		btScalar(isMet ? restitutionOf(e, now, (then - now) / frame.timeStep, row, frame.timeStep) : 0);
}

// A kinematic body goes on whatever it meets. Where a floor leaves a body no room, the two push it against each other,
// and the one that the solver looks at last would win. So what is deep in a kinematic body yields to it: points are
// softened, at most by the body's inverse mass; their impulse is then at most what stops the body. But a plane is a floor
// itself, and so is what bears the body against its force: it carries what lies on the body, too.
void setYielding(const WorldFrame& frame, double depth, btManifoldPoint& point)
{
	const double share = std::min(1.0, depth / (kYielding * frame.restingGap) - kUnyielding / kYielding);
	if (!(share > 0)) return;
	const auto *a = btRigidBody::upcast(frame.a->getCollisionObject()), *b = btRigidBody::upcast(frame.b->getCollisionObject());
	if (!a || !b || a->isKinematicObject() == b->isKinematicObject()) return;
	const btRigidBody &kinematic = a->isKinematicObject() ? *a : *b, &body = a->isKinematicObject() ? *b : *a;
	const bool isFirst = (&body == a) == frame.aIsFirst;
	const Vec3 onto = (isFirst ? 1.0 : -1.0) * toVec3(point.m_normalWorldOnB), pull = toVec3(body.getTotalForce());
	if (dot(pull, onto) < -kHolds * length(pull)) return;
	if (kinematic.getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE) return;
	point.m_contactPointFlags |= BT_CONTACT_FLAG_HAS_CONTACT_CFM;
	point.m_contactCFM = btScalar(share * double(body.getInvMass()) * frame.timeStep);
}

// Do at least so many points carry that have its normal? Those are of one flat, or of small flats of a coarse surface.
bool carryBeside(const ContactPoint& point, const WorldFrame& frame, int count)
{
	if (!frame.points || !frame.isNearRest) return false;
	for (const HeldPoint& held : frame.points->points())
		if (held.impulse > 0 && dot(held.point.normal, point.normal) > kSameNormal && --count == 0) return true;
	return false;
}

void setErp(double erp, btManifoldPoint& point)
{
	point.m_contactPointFlags |= BT_CONTACT_FLAG_HAS_CONTACT_ERP;
	point.m_contactERP = btScalar(erp);
}

// A spring and damper that is pressed in so far: the row that Bullet makes of it where impulses are not split. It takes
// the place of the two numbers in the point. Before it is pressed in, what the path bends into it is met like any other.
void setSpring(double depth, double dt, btManifoldPoint& point)
{
	const double pull = dt * double(point.m_combinedContactStiffness1);
	const double sum = std::max(pull + double(point.m_combinedContactDamping1), double(SIMD_EPSILON));
	point.m_distance1 = btScalar(-kTokenOverlap);
	setErp(pull / sum * depth / kTokenOverlap, point);
	point.m_contactPointFlags |= BT_CONTACT_FLAG_HAS_CONTACT_CFM;
	point.m_contactCFM = btScalar(1 / sum);
}

// Moves on whatever it meets.
bool isDriver(const btCollisionObject& object)
{
	const RelativeMotion motion = worldMotion(object, 0);
	return object.isKinematicObject() && lengthSquared(motion.linear) + lengthSquared(motion.angular) > 0;
}
}  // namespace

void setSolverTerms(const ContactPoint& point, const WorldFrame& frame, btManifoldPoint& written)
{
	const double dt = frame.timeStep, height = point.height * frame.scale, bend = point.bend * frame.scale;
	if (!(dt > 0)) return;
	const double slow = point.slowOverlap * frame.scale;
	double row = velocityRow(height + slow, bend);
	if (row > 0 && (written.m_appliedImpulse > 0 || carryBeside(point, frame, 1)))
	{
		const double near = std::min(row, (frame.isNearRest ? kFarthestClosed : 1) * frame.restingGap);
		row -= near - std::max(frame.closedShare * near, std::min(near, frame.switchSpeed * dt));
	}
	// An overlap is left by positions (split impulse) if they take back more of it than the path bends into it.
	// Otherwise velocities answer for both, with at most twice what the bend itself asks for.
	const bool mayBeOfPile = height < 0 && frame.closedShare < kShareOfPiles && frame.alike > frame.restingGap;
	const bool isOfPile = mayBeOfPile && carryBeside(point, frame, kOfFlat);
	const double ofSkin = isOfPile ? std::max(0.0, std::min(-height - slow, frame.restingGap)) : 0;
	const bool isDepth = height < 0 && -bend < kTakenBackShare * (-height - ofSkin) + frame.closedShare * ofSkin;
	if (height < 0 && (written.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING) != 0)
		setSpring(std::max(0.0, -height - slow), dt, written);
	else if (isDepth)
	{
		// The share is such that as much is taken back a second whatever the step.
		const double share =
			std::max(kTakenBackShare, std::min(kMostDepthShare, 1 - std::pow(1 - kTakenBackShare, dt / kDepthStep)));
		written.m_distance1 = btScalar(height);
		const double taken = share * (-height - slow - ofSkin) + frame.closedShare * ofSkin;
		const double left = std::min(taken, frame.pushSpeed * dt);
		setErp((left + std::min(slow, frame.switchSpeed * dt)) / -height, written);
		setYielding(frame, -height, written);
	}
	else if (row >= 0)
		written.m_distance1 = btScalar(row);
	else
	{
		written.m_distance1 = btScalar(-kTokenOverlap);
		setErp(-row / kTokenOverlap, written);
	}
	if (point.rebounds)
		setRestitution(point, frame, row, written);
	else
		written.m_combinedRestitution = 0;
}

double unmetWay(const btPersistentManifold& manifold, double timeStep)
{
	const RelativeMotion first = worldMotion(*manifold.getBody0(), 0), second = worldMotion(*manifold.getBody1(), 0);
	double most = 0;
	for (int i = 0; i < manifold.getNumContacts(); ++i)
	{
		const btManifoldPoint& point = manifold.getContactPoint(i);
		const Vec3 apart = first.velocity(toVec3(point.m_positionWorldOnA)) - second.velocity(toVec3(point.m_positionWorldOnB));
		most = std::max(most, timeStep * (speedOf(point, timeStep) - dot(apart, toVec3(point.m_normalWorldOnB))));
	}
	return most;
}

void SolverOrder::enter(btDispatcher& dispatcher, std::uint64_t& last)
{
	if (btThreadsAreRunning()) return;
	if (last == m_step)
	{
		++m_step;
		arrange(dispatcher);
	}
	last = m_step;
}

void SolverOrder::arrange(btDispatcher& dispatcher)
{
	const auto keyOf = [](const btPersistentManifold& manifold)
	{
		const int first = manifold.getBody0()->getWorldArrayIndex(), second = manifold.getBody1()->getWorldArrayIndex();
		return std::tuple(manifold.m_companionIdA, first, second, manifold.m_index1a);  // the last breaks ties
	};
	const auto isBefore = [&keyOf](const btPersistentManifold* l, const btPersistentManifold* r)
	{ return keyOf(*l) < keyOf(*r); };
	btPersistentManifold** const manifolds = dispatcher.getInternalManifoldPointer();
	const int count = dispatcher.getNumManifolds();
	if (std::is_sorted(manifolds, manifolds + count, isBefore)) return;  // as in most steps
	std::sort(manifolds, manifolds + count, isBefore);
	for (int i = 0; i < count; ++i) manifolds[i]->m_index1a = i;  // where the dispatcher finds it
}

bool isPushing(const btPersistentManifold& manifold)
{
	for (int i = 0; i < manifold.getNumContacts(); ++i)
		if (manifold.getContactPoint(i).m_appliedImpulse != 0) return true;
	return false;
}

bool isDriving(const btPersistentManifold& manifold)
{
	const btCollisionObject &first = *manifold.getBody0(), &second = *manifold.getBody1();
	if (isDriver(first) || isDriver(second) || first.getRestitution() * second.getRestitution() > 1) return true;
	for (int i = 0; i < manifold.getNumContacts(); ++i)
	{
		const btManifoldPoint& point = manifold.getContactPoint(i);
		if ((point.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING) != 0 || point.m_contactMotion1 != 0 ||
			point.m_contactMotion2 != 0)
			return true;
	}
	return false;
}

double speedOf(const btManifoldPoint& point, double timeStep)
{
	const double distance = double(point.m_distance1);
	if (distance < -2 * kTokenOverlap) return 0;  // of positions
	return -distance / timeStep * (distance > 0 ? 1 : double(point.m_contactERP));
}
}  // namespace clod
