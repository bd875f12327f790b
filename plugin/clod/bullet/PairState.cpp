// SPDX-License-Identifier: Zlib
// The course of a dispatch, and its first step: which bodies meet, and what is asked about them.
#include "clod/bullet/PairState.h"

#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "clod/bullet/BodyState.h"
#include "clod/collide/MotionBound.h"

namespace clod
{
namespace
{
constexpr double kAlone = 0.1, kStaysAlone = 0.3;  // of its weight, by which the load may differ
constexpr std::uint32_t kLongStill = 16;  // dispatches that ask nothing, until what queries remember is given back
constexpr double kNearRestShare = 4e-3;  // of the length: who moves no farther in a step may come to rest where it is
constexpr double kStillShare = 3e-4;  // of the length, more than half of the skin: points found so little motion ago serve

// All fields, for comparison. A field that is added does not compile before it is named here.
auto fieldsOf(const PairBody& body)
{
	const auto& [inverseMass, inverseInertia, center, linear, angular, force, isPoint] = body;
	return std::tie(inverseMass, inverseInertia.row[0], inverseInertia.row[1], inverseInertia.row[2], center, linear,
					angular, force, isPoint);
}
bool sameRules(const PointRules& l, const PointRules& r)
{
	const auto fields = [](const PointRules& rules)
	{
		const auto& [size, resting, margin, ofA, ofB, nearest, a, b, friction, dt, held, shove, alone, once] = rules;
		return std::tuple_cat(std::tie(size, resting, margin, ofA, ofB, nearest, friction, dt, held, shove, alone, once),
							  fieldsOf(a), fieldsOf(b));
	};
	return fields(l) == fields(r);
}
}  // namespace

PairState::PairState(Context& context, btDispatcher& dispatcher, btPersistentManifold* shared, bool isClosestPoints,
					 StepBudget* budget, const btCollisionObject& object0, const btCollisionObject& object1)
	: m_context(context),
	  m_shared(context.sharedIn(dispatcher)),
	  m_manifolds(dispatcher, shared),
	  m_isClosestPoints(isClosestPoints),
	  m_objects{&object0, &object1},
	  m_budget(budget)
{
	m_report.result = &m_result;
	m_report.clusters = &m_clusters;
	m_context.add(this);
	for (std::size_t i = 0; i < 2 && !m_isClosestPoints; ++i) m_pairsOf[i] = &m_context.enlist(*m_objects[i], this);
}

PairState::~PairState()
{
	if (!m_hasContext) return;
	for (std::size_t i = 0; i < 2 && !m_isClosestPoints; ++i) m_context.strike(*m_objects[i], this);
	m_context.remove(this);
}

// How much of last step's impulses a pair starts from: loads are as its masses, which a program may have lowered.
double PairState::carriedShare(const PointRules& then, const PointRules& now)
{
	const auto ofBody = [](const PairBody& l, const PairBody& r)
	{ return l.inverseMass > 0 && r.inverseMass > l.inverseMass ? l.inverseMass / r.inverseMass : 1; };
	return std::min(ofBody(then.a, now.a), ofBody(then.b, now.b));
}

PairState::Seen PairState::seenA(const PairPose& pose)
{
	return {pose.shapeA, pose.hierarchyA().contentHash(), pose.shapeA->revision()};
}

PairState::Seen PairState::seenB(const PairPose& pose)
{
	const btCollisionShape* const shape = pose.b->getCollisionShape();
	if (!pose.isOfTwo() || !pose.isAsked()) return {shape, 0, 0};
	return {shape, pose.hierarchyB().contentHash(), pose.shapeB ? pose.shapeB->revision() : 0};
}

bool PairState::same(const Question& l, const Question& r)
{
	return l.aFromB == r.aFromB && sameRules(l.rules, r.rules) &&
		   clod::same(l.settings, r.settings) && l.withGap == r.withGap;
}

// Do the points found last still serve, because the bodies have hardly moved since then and move slowly?
bool PairState::isStill(const PairPose& pose, const Question& question) const
{
	if (!m_context.keepPoints || pose.prediction != Prediction::kFree || m_facets.isMadeIn) return false;
	if (!m_answered || m_clusters.isEmpty()) return false;
	const Question& then = *m_answered;
	const double most = kStillShare * question.rules.length;
	if (question.withGap || then.withGap || std::max(question.way, then.way) > most) return false;
	const Transform since = question.aFromB * inverse(then.aFromB);
	const double moved = length(since * pose.center - pose.center) +
						 turnBetween(then.aFromB.rotation, question.aFromB.rotation) * pose.radius;
	if (moved > most) return false;
	// Bodies that are lifted slowly out of another level tilt, and other points carry.
	if (m_facets.levels.overlap > most && !(m_followed * question.rules.timeStep < kIdle)) return false;
	// The forces are almost the same, and so is the question but for the motion.
	const auto isForcedAlike = [&](const PairBody& l, const PairBody& r)
	{ return l.inverseMass == r.inverseMass && length(l.force - r.force) * question.rules.timeStep < most; };
	PointRules rules = question.rules;
	const bool isNearer = rules.heldReach > then.rules.heldReach || rules.shove > then.rules.shove;
	if (isNearer || !isForcedAlike(rules.a, then.rules.a) || !isForcedAlike(rules.b, then.rules.b)) return false;
	rules.a = then.rules.a;
	rules.b = then.rules.b;
	rules.heldReach = then.rules.heldReach;
	rules.shove = then.rules.shove;
	GapSettings settings = question.settings;
	settings.tolerance = then.settings.tolerance;
	settings.sweep = then.settings.sweep;
	return sameRules(rules, then.rules) && question.plane == then.plane && clod::same(settings, then.settings) &&
		   (pose.partner != Partner::kConcave || (m_mesh && m_mesh->isAsItWas(pose)));
}

// Drops everything kept where one of the shapes is another than in the last dispatch.
void PairState::noticeShapes(const PairPose& pose)
{
	if (m_convex != pose.convex) m_convex = pose.convex;  // in use: what looks the same may have been made anew
	const Seen a = seenA(pose), b = seenB(pose);
	if (m_seenA == a && m_seenB == b) return;
	m_cache.clear();
	m_clusters = {};
	m_answered.reset();
	m_facets = {};
	m_mesh.reset();
	m_metric.letGo();
	m_heldError = kOff;
	m_points = m_ofCoarsest = 0;
	m_seenA = a;
	m_seenB = b;
	m_asked = pose.asked;  // held: the caches are of them
}

// The one asked for, or a stricter one where levels have jammed.
Metric PairState::metricFor(const PairPose& pose)
{
	Metric metric = m_metric.resolve(m_context, pose);
	metric.maxError = std::min(metric.maxError, m_heldError);
	return metric;
}

PairPose PairState::begin(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
						  const btDispatcherInfo& info, double closestPoints)
{
	const Prediction prediction = m_isClosestPoints	   ? Prediction::kStill
								  : m_shared.isFurther ? Prediction::kSolved
													   : Prediction::kFree;
	PairPose pose = poseOf(body0, body1, info, prediction, closestPoints, m_context.m_convexPartners, m_convex);
	m_report.notFinite = pose.notFinite;
	if (pose.partner == Partner::kOther) return pose;
	noticeShapes(pose);
	m_children = {childOf(*pose.a), childOf(*pose.b)};
	m_report.objectA = pose.a->getCollisionObject();
	m_report.objectB = pose.b->getCollisionObject();
	for (const btClodShape* shape : {pose.shapeA, pose.shapeB})
		if (shape && !shape->scalingError().empty()) sayOnce(64, "a shape keeps its last scale: " + shape->scalingError());
	if (!pose.notFinite.empty())
	{
		sayOnce(32, "a pair has no contacts: " + pose.notFinite);
		return pose;
	}
	if (prediction == Prediction::kFree && pose.isOfTwo())
	{
		// Bodies that carry each other are held together; further passes know who holds whom.
		const bool carry = m_manifolds.carry();
		if (!carry) pose.expectHolding();
		// A pair that met little may meet more if others turn its motion, and looking for that costs little.
		if (m_result.pairs.size() <= kFewPairs) pose.lookAside(carry);
	}
	if (prediction == Prediction::kFree && !m_shared.mayFollow) pose.expectShove(shoveOf(pose));  // passes know who shoves
	if (prediction == Prediction::kFree) m_grown = m_metric.goOnHolding(pose, m_cache.pair);
	pose.rules.margin += m_grown;
	pose.tolerance += m_grown;
	m_report.motion = pose.motion;
	m_report.tolerance = pose.tolerance;
	m_report.metric = metricFor(pose);
	m_report.metricError = m_metric.error();
	const std::string badBudget = m_budget ? budgetError(m_context.budget) : std::string();
	if (!badBudget.empty()) sayOnce(16, "the budget cannot be used: " + badBudget);
	if (!m_metric.error().empty())
		sayOnce(8, "a pair's metric cannot be used, its contacts are exact: " + m_metric.error());
	m_report.hierarchyA = &pose.hierarchyA();
	m_report.hierarchyB = pose.isOfTwo() ? &pose.hierarchyB() : nullptr;
	const std::string lacking = levelsError(*m_report.hierarchyA, m_report.hierarchyB, m_report.metric);
	if (!lacking.empty()) m_report.metricError = lacking;
	return pose;
}

// Judged by the load on the points: it is that of the body alone, as forces accelerate it along the load. On a slope
// friction bears the rest.
bool PairState::liesAlone(const PairPose& pose) const
{
	const PairBody &a = pose.rules.a, &b = pose.rules.b;
	if (m_clusters.isEmpty() || (a.inverseMass > 0) == (b.inverseMass > 0)) return false;
	const PairBody& body = a.inverseMass > 0 ? a : b;
	const Vec3 impulse = transposed(pose.worldFromA.rotation) * m_manifolds.impulse();
	const double weight = std::abs(dot(body.force, normalized(impulse))) / body.inverseMass;
	const double load = length(impulse) / pose.scale();
	const double most = m_answered && m_answered->rules.liesAlone ? kStaysAlone : kAlone;  // not to and fro
	if (!(weight > 0 && std::abs(load - weight) <= most * weight)) return false;
	const JoinedBodies& joined = joinedBodies(pose);
	return (a.inverseMass > 0 ? joined.toB : joined.toA).empty();  // it lies on these, too
}

PairState::Question PairState::questionOf(const PairPose& pose)
{
	Question question;
	question.aFromB = pose.aFromB;
	question.settings.metric = m_report.metric;
	question.settings.tolerance = pose.tolerance;
	question.settings.sweep = pose.sweep();
	question.settings.signsOnly = true;
	question.rules = pose.rules;
	question.rules.liesAlone = liesAlone(pose);
	question.rules.foundOnce = !m_shared.mayFollow;
	question.way = pose.seenMotion.speedWithin(pose.center, pose.radius) * pose.rules.timeStep;
	question.withGap = m_context.searchGap && !pose.isRound();
	if (pose.partner == Partner::kPlane)
	{
		const auto& plane = static_cast<const btStaticPlaneShape&>(*pose.b->getCollisionShape());
		const Vec3 normal = toVec3(plane.getPlaneNormal());
		question.plane = {normal.x, normal.y, normal.z, double(plane.getPlaneConstant())};
	}
	if (m_budget && pose.isOfTwo()) question.settings.metric.coarsening = m_context.enterStep(*m_budget, m_step);
	return question;
}

// For a dispatch that asks nothing: neither the points nor the report of the dispatch before hold any longer.
void PairState::forget()
{
	m_clusters = {};
	m_result = {};
	m_heldError = kOff;
	m_points = m_ofCoarsest = 0;
	m_answered.reset();
	static_cast<DispatchReport&>(m_report) = {};
}

void PairState::open(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
					 const btDispatcherInfo& info, double closestPoints, Prepared& next)
{
	next.pose = begin(body0, body1, info, closestPoints);
	next.aIsFirst = next.pose.a == &body0;
	if (next.pose.isAsked())
	{
		next.question = questionOf(next.pose);
		double& coarsening = next.question.settings.metric.coarsening;
		const double asked = coarsening;
		// An answer that lies still is kept: one finer than the budget buys now costs nothing, and a coarser one is
		// refined with what the budget leaves. Where a budget buys nothing, answers are the coarsest.
		const bool isRefined = isRefinable(next.pose, next.question);
		if (m_answered && (isRefined || asked < kOff))
		{
			const double before = m_answered->settings.metric.coarsening;
			coarsening = isRefined && before < kOff ? before : std::min(asked, before);
		}
		// At the very same pose the question counts as the same although lookAside() may set another tolerance by how
		// much was found.
		const double tolerance = next.question.settings.tolerance;
		if (m_answered) next.question.settings.tolerance = m_answered->settings.tolerance;
		if (m_answered) next.carriedShare = carriedShare(m_answered->rules, next.question.rules);
		next.isKept = next.pose.isOfTwo() && m_answered && same(*m_answered, next.question);
		if (!next.isKept) next.question.settings.tolerance = tolerance;
		next.isStill = !next.isKept && isStill(next.pose, next.question);
		// What has to be asked after all is known before a budget is spent.
		if (next.isStill && m_budget && m_budget->isLimited())
			next.isStill = m_manifolds.isAsLeft(worldFrame(next, closestPoints), btManifoldResult(&body0, &body1));
		if (!next.isKept && !next.isStill) coarsening = asked;
	}
}

// A pair that found nothing of a resting plane, and is as it was, costs no more than a bound of its motion.
bool PairState::staysOverPlane(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
							   const btDispatcherInfo& info)
{
	const bool wasNear = !m_clusters.isEmpty() || !m_result.pairs.empty() || m_report.fast;
	const bool complains = !m_report.notFinite.empty() || !m_report.metricError.empty();
	if (wasNear || complains || m_seenB.shape == nullptr || m_isClosestPoints || m_shared.isFurther) return false;
	const bool planeIsFirst = body0.getCollisionShape() == m_seenB.shape;
	const btCollisionObject &plane = *(planeIsFirst ? body0 : body1).getCollisionObject(),
							&body = *(planeIsFirst ? body1 : body0).getCollisionObject();
	// Neither of the two may be a compound's child.
	if (plane.getCollisionShape() != m_seenB.shape || body.getCollisionShape() != m_seenA.shape || !isFixed(plane) ||
		plane.getCollisionShape()->getShapeType() != STATIC_PLANE_PROXYTYPE)
		return false;
	const auto* shape = dynamic_cast<const btClodShape*>(m_seenA.shape);
	if (!shape || shape->revision() != m_seenA.revision || shape->hierarchy().contentHash() != m_seenA.contentHash)
		return false;
	const double timeStep = double(info.m_timeStep);
	const RelativeMotion motion = worldMotion(body, timeStep);
	if (!(spareOverPlane(body, plane, motion, timeStep) > 0)) return false;
	m_report.queryMicroseconds = m_report.contactMicroseconds = 0;
	m_foreseen.timeStep = timeStep;
	m_foreseen.worldFromA = toTransform(body.getWorldTransform());
	m_foreseen.motion = relativeMotion(motion, {}, m_foreseen.worldFromA, m_foreseen.scale, timeStep);
	return true;
}

PairState::Prepared& PairState::ahead(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
									  const btDispatcherInfo& info)
{
	if (!m_ahead) m_ahead = std::make_unique<Prepared>();
	if (!std::exchange(m_isAhead, true)) open(body0, body1, info, 0, *m_ahead);
	m_ahead->holdWrappers(body0, body1);
	return *m_ahead;
}

void PairState::outline(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
						const btDispatcherInfo& info)
{
	if (staysOverPlane(body0, body1, info)) return;
	outline(ahead(body0, body1, info));
	m_held = {m_outline.answering, m_outline.answering > 0 ? ofCoarsest() : 0};
	if (m_budget) m_budget->hold(m_held);
}

void PairState::outline(Prepared& prepared)
{
	if (std::exchange(prepared.isOutlined, true)) return;
	m_outline = {};
	m_report.vainTests = 0;
	const PairPose& pose = prepared.pose;
	if (!m_budget || !m_budget->isLimited() || !pose.isAsked() || !pose.isOfTwo() || prepared.isKept || prepared.isStill)
		return;
	m_outline =
		outlineCoarsest(pose.hierarchyA(), pose.hierarchyB(), pose.aFromB, prepared.question.settings, m_cache.pair);
	m_budget->list(m_outline.listing);
}

// What the points of the coarsest answer to come are worth: as the last ones were, or as many pairs of nodes as it may have.
std::uint32_t PairState::ofCoarsest() const
{
	return m_ofCoarsest > 0 ? m_ofCoarsest : worthOfPoints(m_outline.answering, 0);
}

void PairState::expect(StepBudget& budget)
{
	if (&budget != m_budget || m_isAhead) return;
	m_held = {};  // of a step in which it was not dispatched
	if (m_step + 1 != budget.step()) return;
	m_held = {m_report.coarsestTests, m_ofCoarsest};
	budget.hold(m_held);
}

void PairState::prepare(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
						const btDispatcherInfo& info)
{
	if (m_isAhead || !staysOverPlane(body0, body1, info)) complete(ahead(body0, body1, info));
}

void PairState::complete(Prepared& prepared)
{
	if (std::exchange(prepared.isAnswered, true)) return;
	outline(prepared);
	if (!prepared.pose.isAsked())
	{
		m_foreseen = {};
		m_manifolds.readImpulses(m_clusters);
		forget();
	}
	else if (!prepared.isKept && !prepared.isStill)
	{
		m_manifolds.readImpulses(m_clusters);
		answer(prepared.pose, prepared.question);
	}
	if (m_budget && (m_held.tests > 0 || m_held.points > 0)) m_budget->release(std::exchange(m_held, {}));
}

bool PairState::process(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
						const btDispatcherInfo& info, btManifoldResult& out)
{
	if (!m_isClosestPoints && !m_shared.isFurther) m_shared.order.enter(m_manifolds.dispatcher(), m_lastOrder);
	if (!m_isAhead && staysOverPlane(body0, body1, info)) return true;
	const double closestPoints = double(out.m_closestPointDistanceThreshold);
	Prepared now;
	const bool wasAhead = std::exchange(m_isAhead, false);
	if (wasAhead)
		now = std::exchange(*m_ahead, {});
	else
		open(body0, body1, info, closestPoints, now);
	now.holdWrappers(body0, body1);
	complete(now);
	if (!wasAhead) refine(now);
	const PairPose& pose = now.pose;
	for (const auto& [cause, message] : std::exchange(m_toSay, {})) m_context.say(cause, message);
	m_report.kept = false;
	if (!pose.isAsked())
	{
		const auto noParts = [](const ContactPoint&) { return ManifoldSet::Parts{}; };
		m_manifolds.write(m_clusters, {}, noParts, out);
		tell({});
		return pose.partner != Partner::kOther;
	}
	WorldFrame frame = worldFrame(now, closestPoints);
	if (now.isKept)
	{
		m_report.queryMicroseconds = m_report.contactMicroseconds = 0;
		m_report.kept = m_manifolds.keep(m_clusters, frame, out);
		if (m_report.kept) return true;
		m_manifolds.readImpulses(m_clusters);
		m_clusters.linkToThemselves();
		m_result.stats.boxTests = m_result.stats.hullTests = 0;
	}
	else if (now.isStill)
	{
		if (follow(pose, frame, out)) return true;
		m_manifolds.readImpulses(m_clusters);
		answer(pose, now.question);
	}
	write(pose, frame, out);
	return true;
}

bool PairState::follow(const PairPose& pose, const WorldFrame& frame, btManifoldResult& out)
{
	m_report.kept = m_manifolds.follow(m_clusters, frame, out);
	if (!m_report.kept) return false;
	m_report.queryMicroseconds = m_report.contactMicroseconds = 0;
	m_facets.levels.passStep(pose.rules);
	foresee(pose);
	m_foreseen.motion = {{}, {}, pose.rules.timeStep};
	if (++m_followed == kLongStill) m_cache.pair.giveBack();
	return true;
}

void PairState::foresee(const PairPose& pose)
{
	m_foreseen = {pose.worldFromA,
				  pose.scale(),
				  pose.rules.timeStep,
				  pose.tolerance,
				  kSkinShare * pose.rules.length,
				  pose.radius,
				  pose.center,
				  pose.rules.motion(),
				  pose.rules.b.isPoint,
				  std::numeric_limits<double>::infinity(),
				  0};
}

WorldFrame PairState::worldFrame(const Prepared& prepared, double closestPoints) const
{
	const PairPose& pose = prepared.pose;
	WorldFrame frame;
	frame.a = pose.a;
	frame.b = pose.b;
	frame.aIsFirst = prepared.aIsFirst;
	frame.worldFromA = pose.worldFromA;
	frame.scale = pose.scale();
	frame.timeStep = pose.rules.timeStep;
	frame.pushSpeed = m_context.pushSpeed * pose.rules.length * frame.scale;
	frame.switchSpeed = switchSpeed(pose.rules) * frame.scale;
	frame.slowOverlap = m_facets.levels.overlap * frame.scale;
	frame.restingGap = kSkinShare * pose.rules.length * frame.scale;
	frame.closedShare = std::min(1.0, std::max(0.0, m_context.closedShare));
	frame.carriedShare = prepared.carriedShare;
	frame.breakingThreshold = kBreakingShare * pose.rules.length * frame.scale + closestPoints;
	frame.points = &m_clusters;
	frame.alike = frame.scale * m_report.contactError;
	const PointRules& rules = prepared.question.rules;
	frame.isNearRest = prepared.question.way <= kNearRestShare * rules.length;
	frame.rocks = rules.liesAlone && prepared.question.way > kStillShare * rules.length;
	return frame;
}

void PairState::write(const PairPose& pose, WorldFrame& frame, btManifoldResult& out)
{
	const bool isClod = pose.partner == Partner::kClod;
	const auto partsOf = [&](const ContactPoint& point) -> ManifoldSet::Parts
	{
		return {pose.hierarchyA().node(point.nodeA).level,
				isClod ? pose.hierarchyB().node(point.nodeB).level : point.nodeB};
	};
	m_manifolds.write(m_clusters, frame, partsOf, out);
	noteSides(pose);
}
}  // namespace clod
