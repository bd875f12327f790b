// SPDX-License-Identifier: Zlib
#include "clod/bullet/PairState.h"

#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btTriangleCallback.h>

#include <algorithm>
#include <utility>

#include "clod/bullet/BodyState.h"

namespace clod
{
namespace
{
constexpr double kSameScale = 1e-6;  // scales whose ratio differs by less are equal

Vec3 sphereCenter(const Hierarchy& hierarchy)
{
	const float* c = hierarchy.asset().sphereCenter;
	return {double(c[0]), double(c[1]), double(c[2])};
}

// Hands an engine mesh's triangles to the clipper, in A's frame and unit.
struct TriangleSink : btTriangleCallback
{
	ForeignClipper& clipper;
	const Hierarchy& hierarchy;
	const Metric& metric;
	const PointRules& rules;
	Transform aFromB;
	double unit;
	std::vector<ContactPoint>& points;
	ForeignStats& stats;
	TriangleSink(ForeignClipper& c, const Hierarchy& h, const Metric& m, const PointRules& r, const Transform& t,
				 double u, std::vector<ContactPoint>& p, ForeignStats& s)
		: clipper(c), hierarchy(h), metric(m), rules(r), aFromB(t), unit(u), points(p), stats(s)
	{
	}
	void processTriangle(btVector3* corners, int part, int index) override
	{
		Triangle triangle;
		for (std::size_t i = 0; i < 3; ++i) triangle[i] = aFromB * ((1 / unit) * toVec3(corners[i]));
		clipper.clipTriangle(hierarchy, triangle, std::uint32_t(part), std::uint32_t(index), metric, rules, points,
							 stats);
	}
};
}  // namespace

PairState::PairState(Context& context, btDispatcher& dispatcher, btPersistentManifold* shared, bool isClosestPoints)
	: m_context(context), m_manifolds(dispatcher, shared), m_isClosestPoints(isClosestPoints)
{
	m_own = [this](const Place& place) { return (*m_ownThreshold)(inWorld(place, m_frame)) * m_frame.radius; };
	m_context.add(&m_report);
}

PairState::~PairState()
{
	m_context.remove(&m_report);
}

PairState::Seen PairState::seen(const btCollisionShape& shape, const btClodShape* ours)
{
	if (!ours) return {&shape, 0, 0};
	return {&shape, ours->hierarchy().contentHash(), ours->revision()};
}

// Which body is A? The one whose content hashes lower, so that Bullet's order of a pair changes nothing but signs.
bool PairState::chooseBodies(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1)
{
	const auto* shape0 = dynamic_cast<const btClodShape*>(body0.getCollisionShape());
	const auto* shape1 = dynamic_cast<const btClodShape*>(body1.getCollisionShape());
	if (!shape0 && !shape1) return false;
	const bool bothClod = shape0 && shape1;
	const bool firstIsA =
		bothClod ? shape0->hierarchy().contentHash() <= shape1->hierarchy().contentHash() : shape0 != nullptr;
	m_a = firstIsA ? &body0 : &body1;
	m_b = firstIsA ? &body1 : &body0;
	m_shapeA = firstIsA ? shape0 : shape1;
	m_shapeB = firstIsA ? shape1 : shape0;
	const btCollisionShape* partner = m_b->getCollisionShape();
	const bool sameScale = bothClod && std::abs(m_shapeA->scale() / m_shapeB->scale() - 1) < kSameScale;
	m_partner = sameScale                                           ? Partner::Clod
				: partner->getShapeType() == STATIC_PLANE_PROXYTYPE ? Partner::Plane
				: partner->isConcave()                              ? Partner::Concave
																	: Partner::None;
	const Seen seenA = seen(*m_shapeA, m_shapeA), seenB = seen(*partner, m_shapeB);
	if (!(m_seenA == seenA && m_seenB == seenB))
	{
		m_cache.clear();
		m_clusters.clear();
		m_hasQuestion = m_wasUnanswered = false;
		m_seenA = seenA;
		m_seenB = seenB;
	}
	return m_partner != Partner::None;
}

// A metric that cannot be used makes the pair exact, and is warned of.
void PairState::chooseMetric()
{
	const ViewCamera* camera = m_context.camera ? &*m_context.camera : nullptr;
	const btClodShape* partner = m_partner == Partner::Clod ? m_shapeB : nullptr;
	const bool hasA = m_shapeA->metric().has_value(), hasB = partner && partner->metric().has_value();
	ContactMetric metric = m_context.worldMetric;
	if (hasA || hasB) metric = hasA ? *m_shapeA->metric() : *partner->metric();
	std::string error = contactMetricError(metric, camera);
	if (hasA && hasB)
	{
		if (error.empty()) error = contactMetricError(*partner->metric(), camera);
		metric = stricter(metric, *partner->metric());
	}
	ContactMetric answer;
	if (m_context.pairMetric && m_context.pairMetric(*m_a->getCollisionObject(), *m_b->getCollisionObject(), answer))
	{
		metric = answer;
		error = contactMetricError(metric, camera);
	}
	m_frame.radius = m_rules.length;
	m_frame.scale = m_shapeA->scale();
	m_frame.worldFromA = m_worldFromA;
	m_frame.camera = camera;
	if (error.empty()) error = metricError(m_report.metric = resolve(metric, m_frame));
	m_ownThreshold = metric.own;
	if (error.empty() && metric.own) m_report.metric.own = &m_own;
	m_report.metricError = error;
	if (error.empty()) return;
	sayOnce(8, "a pair's metric cannot be used, its contacts are exact: " + error);
	m_report.metric = Metric{};
	m_report.metric.exact = true;
}

// Motion of the step, resting height and margins, and how far apart two bodies may be to need contacts.
void PairState::setMotion(double timeStep, double closestPoints)
{
	const double scale = m_shapeA->scale();
	const double predicted = m_isClosestPoints ? 0 : timeStep;
	const RelativeMotion a = worldMotion(*m_a->getCollisionObject(), predicted),
						 b = worldMotion(*m_b->getCollisionObject(), predicted);
	const RelativeMotion world{a.linear - b.linear, a.angular - b.angular, 0};
	m_rules.motion = inFrame(world, m_worldFromA);
	m_rules.motion.linear = (1 / scale) * m_rules.motion.linear;
	m_rules.motion.timeStep = predicted;
	// What is seen to move does so already; a body at rest gains speed from gravity in every step, and loses it again.
	const RelativeMotion nowA = worldMotion(*m_a->getCollisionObject(), 0),
						 nowB = worldMotion(*m_b->getCollisionObject(), 0);
	m_frame.motion = inFrame({nowA.linear - nowB.linear, nowA.angular - nowB.angular, 0}, m_worldFromA);
	m_frame.motion.linear = (1 / scale) * m_frame.motion.linear;
	m_frame.motion.timeStep = predicted;

	m_rules.margin = double(m_shapeA->getMargin()) / scale;
	if (m_shapeB) m_rules.margin += double(m_shapeB->getMargin()) / scale;
	if (!m_isClosestPoints) m_rules.margin += kSkinShare * m_rules.length;
	m_rules.resting = std::max(kRestingShare * m_rules.length, closestPoints / scale);

	const bool bIsSmaller =
		m_partner == Partner::Clod && m_shapeB->hierarchy().asset().radius < m_shapeA->hierarchy().asset().radius;
	const Hierarchy& smaller = bIsSmaller ? m_shapeB->hierarchy() : m_shapeA->hierarchy();
	const Vec3 center = bIsSmaller ? m_aFromB * sphereCenter(smaller) : sphereCenter(smaller);
	const double speed =
		length(m_rules.motion.velocity(center)) + length(m_rules.motion.angular) * double(smaller.asset().radius);
	m_report.motion = speed * m_rules.motion.timeStep;
	// A query of two hierarchies looks ahead along the motion (sweepOfStep); other shapes are met in all directions.
	m_report.tolerance = m_rules.margin + m_rules.resting;
	if (m_partner != Partner::Clod) m_report.tolerance += kPredictionSlack * m_report.motion;
}

// B's motion relative to A in the step, as far ahead as speculative points may lie.
Sweep PairState::sweepOfStep() const
{
	const double ahead = -kPredictionSlack * m_rules.motion.timeStep;
	return {ahead * m_rules.motion.linear, ahead * m_rules.motion.angular};
}

bool PairState::prepare(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
						const btDispatcherInfo& info, double closestPoints)
{
	m_report.notFinite.clear();
	m_report.result = &m_result;
	m_report.clusters = &m_clusters;
	if (!chooseBodies(body0, body1)) return false;
	m_report.objectA = m_a->getCollisionObject();
	m_report.objectB = m_b->getCollisionObject();
	const double scale = m_shapeA->scale();
	m_worldFromA = toTransform(m_a->getWorldTransform());
	m_aFromB = inverse(m_worldFromA) * toTransform(m_b->getWorldTransform());
	m_aFromB.translation = (1 / scale) * m_aFromB.translation;
	m_rules.length = double(m_shapeA->hierarchy().asset().radius);
	if (m_partner == Partner::Clod)
		m_rules.length = std::min(m_rules.length, double(m_shapeB->hierarchy().asset().radius));
	setMotion(double(info.m_timeStep), closestPoints);
	if (!isFinite(m_a->getWorldTransform()) || !isFinite(m_b->getWorldTransform()) || !isFinite(m_aFromB) ||
		!isFinite(m_rules.motion))
	{
		m_report.notFinite = whatIsNotFinite(m_rules.motion.timeStep);
		sayOnce(32, "a pair has no contacts: " + m_report.notFinite);
		return false;
	}
	chooseMetric();
	m_report.hierarchyA = &m_shapeA->hierarchy();
	m_report.hierarchyB = m_partner == Partner::Clod ? &m_shapeB->hierarchy() : nullptr;
	return true;
}

std::string PairState::whatIsNotFinite(double timeStep) const
{
	for (const btCollisionObjectWrapper* body : {m_a, m_b})
	{
		const btCollisionObject& object = *body->getCollisionObject();
		const bool hasPose = isFinite(body->getWorldTransform());
		if (hasPose && isFinite(worldMotion(object, timeStep))) continue;
		return std::string(hasPose ? "the velocity of, or a force on," : "the pose of") + " the body of world index " +
			   std::to_string(object.getWorldArrayIndex()) + " (user index " + std::to_string(object.getUserIndex()) +
			   ") is not finite";
	}
	return "the motion of its bodies relative to each other is not finite";
}

// Nothing was asked: of the dispatch before, neither points nor report hold any longer.
void PairState::forget()
{
	m_clusters.clear();
	m_result.clear();
	m_hasQuestion = false;
	static_cast<DispatchReport&>(m_report) = {};
}

void PairState::clipForeign()
{
	const Hierarchy& hierarchy = m_shapeA->hierarchy();
	const double scale = m_shapeA->scale();
	m_result.clear();
	m_foreignStats = {};
	std::vector<ContactPoint>& points = m_pool.startWithPoints();
	if (m_partner == Partner::Plane)
	{
		const auto& plane = static_cast<const btStaticPlaneShape&>(*m_b->getCollisionShape());
		const Vec3 local = toVec3(plane.getPlaneNormal());
		const Vec3 onPlane = m_aFromB * ((double(plane.getPlaneConstant()) / scale) * local);
		const Vec3 normal = normalized(m_aFromB.rotation * local);
		m_foreign.clipPlane(hierarchy, normal, dot(normal, onPlane), m_report.metric, m_rules, points, m_foreignStats);
	}
	else
	{
		const auto& concave = static_cast<const btConcaveShape&>(*m_b->getCollisionShape());
		TriangleSink sink(m_foreign, hierarchy, m_report.metric, m_rules, m_aFromB, scale, points, m_foreignStats);
		const btTransform bFromA = m_b->getWorldTransform().inverse() * m_a->getWorldTransform();
		btVector3 low, high;
		m_shapeA->getAabb(bFromA, low, high);
		const btScalar grow = btScalar(m_report.tolerance * scale);
		concave.processAllTriangles(&sink, low - btVector3(grow, grow, grow), high + btVector3(grow, grow, grow));
	}
	m_result.errorBound = m_foreignStats.errorBound;
	m_result.stats.boxTests = m_foreignStats.boxTests;
	m_result.stats.finestLevel = m_foreignStats.nodes ? m_foreignStats.finestLevel : 0;
	m_result.stats.coarsestLevel = m_foreignStats.coarsestLevel;
	for (const ContactPoint& point : points)
		m_result.minDistance = std::min(m_result.minDistance, point.height + m_rules.margin);
}

GapSettings PairState::querySettings() const
{
	GapSettings settings;
	settings.metric = m_report.metric;
	settings.tolerance = m_report.tolerance;
	settings.sweep = sweepOfStep();
	return settings;
}

// Has this dispatch one? What is asked by contactTest and the like is answered in full.
bool PairState::checkBudget()
{
	const std::string error = m_isClosestPoints ? std::string() : budgetError(m_context.budget);
	if (!error.empty()) sayOnce(16, "the budget cannot be used: " + error);
	return m_hasBudget = !m_isClosestPoints && error.empty() && m_context.budget.isLimited();
}

// A planned query has spent its part already; else a depth searched is paid for first.
Budget PairState::chooseBudget()
{
	const bool hasPlan = std::exchange(m_hasPlan, false);
	if (!checkBudget())
	{
		m_report.searchTests = 0;
		return {};
	}
	if (hasPlan) return kSpent;
	const Clock::time_point start = Clock::now();
	searchAhead();
	Budget share = m_context.shareOf(m_report);
	share.tests = std::max(0.0, share.tests - m_report.searchTests);
	share.microseconds = std::max(0.0, share.microseconds - microsecondsSince(start));
	return share;
}

std::optional<PairPlan> PairState::plan(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
										const btDispatcherInfo& info)
{
	if (m_isClosestPoints || !prepare(body0, body1, info, 0) || m_partner != Partner::Clod) return {};
	m_context.setPlanned(m_report);
	m_hasPlan = true;
	checkBudget();
	searchAhead();
	GapSettings settings = querySettings();
	settings.budget = kSpent;
	return PairPlan{QueryPlan(m_shapeA->hierarchy(), m_shapeB->hierarchy(), m_aFromB, settings, m_cache.pair),
					m_rules.length, m_report.searchTests};
}

WorldFrame PairState::worldFrame(bool aIsFirst, double closestPoints) const
{
	WorldFrame frame;
	frame.a = m_a;
	frame.b = m_b;
	frame.aIsFirst = aIsFirst;
	frame.worldFromA = m_worldFromA;
	frame.scale = m_shapeA->scale();
	frame.breakingThreshold = kBreakingShare * m_rules.length * frame.scale + closestPoints;
	return frame;
}

void PairState::process(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
						const btDispatcherInfo& info, btManifoldResult& out)
{
	const bool isAsked = prepare(body0, body1, info, double(out.m_closestPointDistanceThreshold));
	const bool isSame = isAsked && answersAgain();
	const WorldFrame frame =
		isAsked ? worldFrame(m_a == &body0, double(out.m_closestPointDistanceThreshold)) : WorldFrame{};
	if (isSame) m_report.queryMicroseconds = m_report.contactMicroseconds = 0;
	m_report.kept = isSame && m_manifolds.keep(m_clusters, frame, out);
	if (m_report.kept) return;
	m_manifolds.readImpulses(m_clusters);
	if (isSame)
		linkToThemselves();
	else if (isAsked)
		answer();
	else
		forget();
	const auto levelOf = [this](const ContactPoint& point, std::uint32_t& levelA, std::uint32_t& levelB)
	{
		levelA = m_shapeA->hierarchy().node(point.nodeA).level;
		levelB = m_partner == Partner::Clod ? m_shapeB->hierarchy().node(point.nodeB).level : point.nodeB;
	};
	m_manifolds.write(m_clusters, frame, levelOf, out);
}
}  // namespace clod
