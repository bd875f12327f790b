// SPDX-License-Identifier: Zlib
#include "clod/bullet/TimeOfImpact.h"

#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "clod/bullet/BodyState.h"
#include "clod/bullet/PairState.h"
#include "clod/bullet/btClodCollisionAlgorithm.h"
#include "clod/bullet/btClodDynamicsWorld.h"
#include "clod/collide/MotionBound.h"

namespace clod
{
namespace
{
constexpr btScalar kThrough = btScalar(4e-3);  // of the smaller radius: an impact is over when what was left is passed
constexpr double kNear = 1e-3;   // of the smaller radius: nearer is met
constexpr double kBend = 1e-2;   // of the smaller radius: what bends less is swept as straight
constexpr int kMostSteps = 128;  // near each other; the last ones creep along a grazing way

// The way of a body, which turns evenly about an axis through its origin; or of a compound's child, which goes with the
// body.
struct Way
{
	btTransform from;
	std::optional<Transform> child;  // in the body
	btVector3 linear, axis;
	btScalar angle = 0;

	explicit Way(const btCollisionObjectWrapper& body) : from(body.getCollisionObject()->getWorldTransform())
	{
		if (body.m_parent) child = inverse(toTransform(from)) * toTransform(body.getWorldTransform());
		const btTransform& to = body.getCollisionObject()->getInterpolationWorldTransform();
		linear = to.getOrigin() - from.getOrigin();
		btTransformUtil::calculateDiffAxisAngle(from, to, axis, angle);
	}
	Transform at(double share) const
	{
		const btQuaternion turn(axis, angle * btScalar(share));
		const Transform body =
			toTransform(btTransform(turn * from.getRotation(), from.getOrigin() + btScalar(share) * linear));
		return child ? body * *child : body;
	}
	// The distance of the hierarchy's farthest point from the origin that the body turns about; world length.
	double reachOf(const Hierarchy& hierarchy, double scale) const
	{
		return (length(toVec3(hierarchy.asset().sphereCenter)) + double(hierarchy.asset().radius)) * scale +
			   (child ? length(child->translation) : 0);
	}
};

double gapToPlane(const Hierarchy& hierarchy, const Vec3& normal, double offset)
{
	const HullView hull = hierarchy.hull(hierarchy.node(hierarchy.root()));
	double lowest = std::numeric_limits<double>::infinity();
	for (std::uint32_t i = 0; i < hull.count; ++i) lowest = std::min(lowest, dot(normal, hull.vertex(i)) - offset);
	return lowest;
}

// The displacements of `then` to first order in how far it turns: exact at the center, and near it off by at most half
// the square of the turn times the distance.
Sweep straight(const Transform& then, const Vec3& center)
{
	const Mat3& r = then.rotation;
	const Vec3 turn = 0.5 * Vec3{r.row[2].y - r.row[1].z, r.row[0].z - r.row[2].x, r.row[1].x - r.row[0].y};
	return {then * center - center - cross(turn, center), turn};
}

// How far apart two bodies are on their way. Lengths are the world's.
class Approach
{
public:
	Approach(const PairPose& pose, const Metric& metric, PairCache& cache, ContactResult& result)
		: m_pose(pose), m_scale(pose.scale()), m_wayA(*pose.a), m_wayB(*pose.b), m_cache(cache), m_result(result)
	{
		m_settings.metric = metric;
		m_turns = std::abs(double(m_wayA.angle)) + std::abs(double(m_wayB.angle));
		const double reachA = m_wayA.reachOf(pose.hierarchyA(), m_scale);
		double reachB = 0;
		if (pose.isOfTwo()) reachB = m_wayB.reachOf(pose.hierarchyB(), m_scale);
		// The part of a plane that counts reaches as far as the body that it might meet.
		else if (m_wayB.angle != 0)
			reachB = double((m_wayA.from.getOrigin() - m_wayB.from.getOrigin()).length()) +
					 double(m_wayA.linear.length()) + reachA;
		m_length = double((m_wayA.linear - m_wayB.linear).length()) + std::abs(double(m_wayA.angle)) * reachA +
				   std::abs(double(m_wayB.angle)) * reachB;
	}
	bool isFinite() const { return std::isfinite(m_length); }
	// The further share of the way, from that one on, on which they do not meet; 0: they touch.
	double freeFrom(double share)
	{
		m_isNear = true;
		const Transform aFromB = aFromBAt(share);
		if (!m_pose.isOfTwo()) return freeFor(gapToPlaneAt(aFromB));
		// Most that meet on their way touch already: what else comes near on it need not be listed.
		if (isWithin(near(), {}, aFromB)) return 0;
		// Only what comes near counts, on a part of the way that bends so little that it is all but straight. A path
		// departs from the sweep by the square of the part, half of it by the turning of the path, half by that of the
		// body.
		const double bend = 2 * m_turns * m_length, most = kBend * m_pose.rules.length * m_scale;
		const double part = std::min(1 - share, bend > 0 ? std::sqrt(most / bend) : 1);
		const Sweep sweep = straight(aFromBAt(share + part) * inverse(aFromB), centerOfSmaller(aFromB));
		m_isNear = isWithin(near() + part * part * bend, sweep, aFromB);
		if (!m_isNear) return part;
		double nearest = std::numeric_limits<double>::infinity();
		for (const Contact& contact : m_result.contacts) nearest = std::min(nearest, contact.lower);
		return std::min(part, freeFor((nearest - m_pose.rules.radiusA - m_pose.rules.radiusB) * m_scale));
	}
	// Did something come near in the last answer, so that the next may be as short?
	bool isNear() const { return m_isNear; }

private:
	// Nearer than this is met.
	double near() const { return kNear * m_pose.rules.length * m_scale; }
	Transform aFromBAt(double share) const
	{
		Transform aFromB = inverse(m_wayA.at(share)) * m_wayB.at(share);
		aFromB.translation = (1 / m_scale) * aFromB.translation;
		return aFromB;
	}
	double freeFor(double gap) const
	{
		if (!(gap > near())) return 0;
		return std::max(gap - 0.5 * near(), 0.5 * near()) / std::max(m_length, 0.5 * near());
	}
	// In frame A: what is near both bodies is near it.
	Vec3 centerOfSmaller(const Transform& aFromB) const
	{
		const Asset &a = m_pose.hierarchyA().asset(), &b = m_pose.hierarchyB().asset();
		return a.radius < b.radius ? toVec3(a.sphereCenter) : aFromB * toVec3(b.sphereCenter);
	}
	double gapToPlaneAt(const Transform& aFromB) const
	{
		const auto& plane = static_cast<const btStaticPlaneShape&>(*m_pose.b->getCollisionShape());
		const Vec3 normal = aFromB.rotation * normalized(toVec3(plane.getPlaneNormal()));
		const double offset = double(plane.getPlaneConstant()) / m_scale + dot(normal, aFromB.translation);
		return (gapToPlane(m_pose.hierarchyA(), normal, offset) - m_pose.rules.radiusA) * m_scale;
	}
	// Lists what comes within that distance.
	bool isWithin(double distance, const Sweep& sweep, const Transform& aFromB)
	{
		m_settings.tolerance = distance / m_scale + m_pose.rules.radiusA + m_pose.rules.radiusB;
		m_settings.sweep = sweep;
		contacts(m_pose.hierarchyA(), m_pose.hierarchyB(), aFromB, m_settings, m_cache, m_result);
		return m_result.deep || !m_result.contacts.empty();
	}

	const PairPose& m_pose;
	const double m_scale;
	const Way m_wayA, m_wayB;
	ContactSettings m_settings;
	PairCache& m_cache;
	ContactResult& m_result;
	bool m_isNear = true;
	double m_turns = 0;   // radians
	double m_length = 0;  // no point of either goes farther relative to the other
};
}  // namespace

double timeOfImpact(const PairPose& pose, const Metric& metric, PairCache& cache, ContactResult& result)
{
	if (!pose.isOfTwo() && pose.partner != Partner::kPlane) return 1;
	Approach approach(pose, metric, cache, result);
	if (!approach.isFinite()) return 1;
	double share = 0;
	for (int steps = 0; steps < kMostSteps && share < 1; steps += approach.isNear())
	{
		const double free = approach.freeFrom(share);
		if (!(free > 0)) return share > 0 ? share : 1;
		share += free;
	}
	return std::min(share, 1.0);
}

btScalar shareOfImpact(const btCollisionObject& a, const btCollisionObject& b)
{
	btVector3 center;
	btScalar radiusA = 0, radiusB = 0;
	a.getCollisionShape()->getBoundingSphere(center, radiusA);
	b.getCollisionShape()->getBoundingSphere(center, radiusB);
	const btVector3 between = (a.getInterpolationWorldTransform().getOrigin() - a.getWorldTransform().getOrigin()) -
							  (b.getInterpolationWorldTransform().getOrigin() - b.getWorldTransform().getOrigin());
	return kThrough * btMin(radiusA, radiusB) / btMax(between.length(), SIMD_EPSILON);
}

Separation separationOf(const PairPose& pose, const Transform& aFromB, const Metric& metric, double most,
						PairCache& cache)
{
	thread_local ContactResult result;
	const double radii = pose.rules.radiusA + pose.rules.radiusB;
	ContactSettings settings;
	settings.metric = metric;
	settings.tolerance = most + radii;
	contacts(pose.hierarchyA(), pose.hierarchyB(), aFromB, settings, cache, result);
	Separation nearest = {result.deep ? 0 : most, {}, {}};
	for (const Contact& contact : result.contacts)
		if (const double distance = std::max(0.0, contact.lower - radii); distance < nearest.distance)
			nearest = {distance, contact.pointOnA, contact.normal};
	return nearest;
}

SwitchImpact impactOfSwitch(const PairPose& pose, const Transform& from, const Metric& used, const Metric& asked,
							GapCache& cache)
{
	// Whether two functions of the user's say the same nobody knows.
	if (!pose.isOfTwo() || used.own || asked.own || same(used, asked)) return {};
	// What touches already is left to its contacts, as by timeOfImpact().
	const double near = pose.rules.margin + pose.rules.resting;
	if (separationOf(pose, from, used, near, cache.pair).distance < near ||
		separationOf(pose, pose.aFromB, asked, near, cache.pair).distance > 0 ||
		!(separationOf(pose, pose.aFromB, used, near, cache.pair).distance > 0))
		return {};
	const Transform since = pose.aFromB * inverse(from);
	const double way =
		length(since * pose.center - pose.center) + turnBetween(from.rotation, pose.aFromB.rotation) * pose.radius;
	const double most = pose.rules.length + way;
	const double start = separationOf(pose, from, used, most, cache.pair).distance,
				 end = separationOf(pose, pose.aFromB, used, most, cache.pair).distance;
	thread_local GapResult result;
	GapSettings settings;
	settings.metric.exact = true;
	settings.tolerance = pose.rules.radiusA + pose.rules.radiusB;
	settings.distance = true;
	settings.gapError = kNear * pose.rules.length;
	signedGap(pose.hierarchyA(), pose.hierarchyB(), pose.aFromB, settings, cache, result);
	const double depth = settings.tolerance - result.minDistance;
	if (!(depth > 0)) return {};
	return {start / (start + depth), end + depth};
}

double PairState::timeOfImpact(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
							   const btDispatcherInfo& info)
{
	const PairPose pose = poseOf(body0, body1, info, Prediction::kFree, 0, m_context.m_convexPartners, m_convex);
	if (!pose.isAsked()) return 1;
	thread_local ContactResult result;
	return clod::timeOfImpact(pose, metricFor(pose), m_cache.pair, result);
}

double PairState::timeOfSwitch(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
							   const btDispatcherInfo& info)
{
	const PairPose pose = poseOf(body0, body1, info, Prediction::kFree, 0, m_context.m_convexPartners, m_convex);
	if (!pose.isOfTwo() || !pose.isAsked() || m_metric.holds() || !(m_seenA == seenA(pose) && m_seenB == seenB(pose)))
		return 1;
	const Metric used = m_report.metric;
	const SwitchImpact impact = impactOfSwitch(pose, m_report.aFromB, used, metricFor(pose), m_cache);
	if (impact.share < 1) m_metric.hold(used, impact);
	return impact.share;
}
}  // namespace clod

// The paper's 5.3: parts end at impacts.
void btClodDynamicsWorld::solveToImpacts(btContactSolverInfo& info)
{
	const btScalar whole = info.m_timeStep, threshold = info.m_restitutionVelocityThreshold;
	noteKinematic();
	btScalar left = whole, impact = 0;  // how long the one lasts that the last part ended at
	for (;; ++m_parts)
	{
		if (impact > 0 && impact < left)
		{
			info.m_timeStep = impact;
			impact = 0;
		}
		else
		{
			const Impact next = firstImpact(left);
			info.m_timeStep = next.at * left;
			impact = next.at < 1 ? next.lasts * left : 0;
		}
		if (m_parts >= m_mostParts && info.m_timeStep < left)
		{
			// The last part has no rebounds, so that what would bounce for ever comes to rest.
			info.m_timeStep = left;
			info.m_restitutionVelocityThreshold = BT_LARGE_FLOAT;
		}
		left = info.m_timeStep < left ? left - info.m_timeStep : 0;
		if (m_parts > 1 || left > 0) beginPart(info.m_timeStep);
		const double surprise = solvePart(info, whole, true);
		if (m_parts < m_mostParts)
		{
			const btScalar part = info.m_timeStep;
			const btScalar share =
				btMin(shareUntilSwitch(part, whole - left - part), btScalar(1) / btScalar(partsFor(surprise)));
			info.m_timeStep = share * part;
			left += part - info.m_timeStep;
			if (share < 1) impact = 0;
		}
		if (!(left > 0)) break;
		goOn(info.m_timeStep, whole - left);
	}
	moveKinematic(0);
	m_lastPart = info.m_timeStep;
	info.m_timeStep = getDispatchInfo().m_timeStep = whole;
	info.m_restitutionVelocityThreshold = threshold;
}

// The first impact in the time given, with the bodies as they move now.
btClodDynamicsWorld::Impact btClodDynamicsWorld::firstImpact(btScalar timeStep)
{
	predictFree(timeStep);
	for (const Kinematic& kinematic : m_kinematic)
		kinematic.body->predictIntegratedTransform(timeStep, kinematic.body->getInterpolationWorldTransform());
	const Earliest first = earliest(&btClodPairAlgorithm::timeOfImpact);
	return {first.at, first.at < 1 ? clod::shareOfImpact(*first.a, *first.b) : 0};
}

btClodDynamicsWorld::Earliest btClodDynamicsWorld::earliest(TimeOf timeOf)
{
	Earliest first;
	btBroadphasePairArray& pairs = getPairCache()->getOverlappingPairArray();
	for (int i = 0; i < pairs.size(); ++i)
	{
		auto* algorithm = dynamic_cast<btClodPairAlgorithm*>(pairs[i].m_algorithm);
		if (!algorithm) continue;
		const auto* a = static_cast<const btCollisionObject*>(pairs[i].m_pProxy0->m_clientObject);
		const auto* b = static_cast<const btCollisionObject*>(pairs[i].m_pProxy1->m_clientObject);
		if (!isSolved(a, b)) continue;
		const btCollisionObjectWrapper ofA(nullptr, a->getCollisionShape(), a, a->getWorldTransform(), -1, -1);
		const btCollisionObjectWrapper ofB(nullptr, b->getCollisionShape(), b, b->getWorldTransform(), -1, -1);
		const btScalar at = (algorithm->*timeOf)(ofA, ofB, getDispatchInfo());
		if (at < first.at) first = {at, a, b};
	}
	return first;
}

// The share of a part, as solved, after which there is an impact that only the levels see that are asked for at its
// end.
btScalar btClodDynamicsWorld::shareUntilSwitch(btScalar timeStep, btScalar gone)
{
	// Not from where the part began: solvers move bodies, too, where overlaps are corrected by positions.
	std::vector<btTransform> solved;
	for (const Start& start : m_starts)
	{
		btTransform then = start.body->getWorldTransform();
		solved.push_back(then);
		if (clod::isMoving(*start.body)) start.body->predictIntegratedTransform(timeStep, then);
		start.body->setWorldTransform(then);
	}
	moveKinematic(gone + timeStep);
	const btScalar share = earliest(&btClodPairAlgorithm::timeOfSwitch).at;
	m_context.pairsOf(*getDispatcher(), m_pairs);
	for (clod::PairState* pair : m_pairs) pair->dropSwitchesAfter(double(share));
	for (std::size_t i = 0; i < m_starts.size(); ++i) m_starts[i].body->setWorldTransform(solved[i]);
	moveKinematic(gone);
	return share;
}
