// SPDX-License-Identifier: Zlib
// The second and third step of a dispatch: the query, and the points made of what it accepted. Two bodies that stay
// where they are cost no more than writing their manifolds does.
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <array>
#include <limits>

#include "clod/bullet/BodyState.h"
#include "clod/bullet/PairState.h"
#include "clod/collide/Room.h"

namespace clod
{
namespace
{
constexpr double kFiner = 2;         // by so much a trial is finer than what missed: levels differ by about that
constexpr double kLeastOfTrial = 4;  // of what the coarsest answer takes: a finer one takes more
constexpr double kWide = 0.1;        // of the length: so far aside of a way there may be all of a body
constexpr double kRoundings = 2 * double(std::numeric_limits<btScalar>::epsilon());  // of two bodies' places and corners
constexpr double kThrown = 3;       // times as far as masses tell: an impact turns what it hits
constexpr double kLively = 0.3;     // restitution: who bounces off by less loses a tenth of its energy if it does not
constexpr double kStricter = 0.25;  // of the error of contacts that hold a body between them

// What a thread needs while it answers a pair.
struct Scratch
{
	FacetContacts facets;
	ClusterSet previous, next;
	PartnerContacts partner;
	JoinedBodies joined;
	NearTriangles triangles;          // of a mesh
	GapResult result, trial;          // of a query: a pair keeps no more room than its own contacts take
};
Scratch& scratch()
{
	thread_local Scratch buffers;
	return buffers;
}

std::uint32_t testsOf(const QueryStats& stats)
{
	return stats.boxTests + stats.hullTests;
}
}  // namespace

// Asks the query. The gap is searched only where it is asked for, as that costs a search of the input surfaces.
void PairState::ask(const PairPose& pose, const Question& question, bool isAsked)
{
	const Question* const before = m_answered.get();
	if (isAsked)
		take(question);
	else if (before && before->withGap == question.withGap && before->aFromB == question.aFromB &&
		clod::same(before->settings, question.settings))
	{
		contactsOf(m_report, scratch().result.contacts);
		m_result.stats.boxTests = m_result.stats.hullTests = 0;
	}
	else
		query(pose, question);
}

// What the query found is the pair's.
void PairState::take(const Question& question)
{
	m_result.hold(scratch().result);
	if (!question.withGap) m_result.minDistance = m_result.errorBound = std::numeric_limits<double>::infinity();
}

// Asks what the pair can do without. False where a budget does not allow it: it then has the result that it had.
bool PairState::askIfAllowed(const PairPose& pose, const Question& question)
{
	if (!m_budget || !m_budget->isLimited() || question.withGap)  // a gap cannot be tried
	{
		ask(pose, question);
		return true;
	}
	ContactSettings settings = static_cast<const ContactSettings&>(question.settings);
	settings.budget = m_budget->next({}, m_points);  // what this pair's coarsest answer takes stays held back
	std::uint32_t tests = 0;
	if (!attempt(pose, settings, tests))
	{
		m_budget->list(tests);
		return false;
	}
	m_budget->spend(tests, false);
	take(question);
	return true;
}

bool PairState::attempt(const PairPose& pose, ContactSettings& settings, std::uint32_t& tests)
{
	settings.isTrial = true;
	GapResult& result = scratch().trial;
	contacts(pose.hierarchyA(), pose.hierarchyB(), pose.aFromB, settings, m_cache.pair, result);
	tests = testsOf(result.stats);
	const bool isCut = result.stats.cutShort > 0;
	if (isCut)
		m_report.vainTests += tests;
	else
		std::swap(scratch().result, result);
	return !isCut;
}

// A body that goes about its own size in a step has all of a near one aside of its way (PairPose::lookAside): millions
// of pairs of nodes. It looks there only where few are on the way itself, or that cannot be told.
void PairState::askAside(const PairPose& pose, Question& question, bool isAsked)
{
	const PointRules& rules = pose.rules;
	const double tolerance = question.settings.tolerance, ofWay = rules.margin + rules.resting + rules.heldReach;
	const bool isWide = !isAsked && tolerance - ofWay > kWide * rules.length;
	if (!isWide) return ask(pose, question, isAsked);
	m_report.tolerance = question.settings.tolerance = ofWay;
	if (askIfAllowed(pose, question))
	{
		if (m_result.pairs.size() > kFewPairs) return;
		m_report.vainTests += testsOf(m_result.stats);
	}
	m_report.tolerance = question.settings.tolerance = tolerance;
	query(pose, question);
}

void PairState::query(const PairPose& pose, const Question& question)
{
	GapSettings settings = question.settings;
	if (m_budget) settings.budget = m_budget->next(std::exchange(m_held, {}), m_points);
	GapResult& result = scratch().result;
	if (question.withGap)
		signedGap(pose.hierarchyA(), pose.hierarchyB(), pose.aFromB, settings, m_cache, result);
	else
		contacts(pose.hierarchyA(), pose.hierarchyB(), pose.aFromB, settings, m_cache.pair, result);
	take(question);
	if (m_budget) m_budget->spend(testsOf(result.stats), result.stats.cutShort > 0);
}

// May the pair's own answer serve until the budget leaves enough for a finer one? Not where a gap is asked for, too.
bool PairState::isRefinable(const PairPose& pose, const Question& question) const
{
	return m_budget && m_budget->isLimited() && m_budget->buysAnything() && pose.isOfTwo() && !question.withGap;
}

// The coarsening to ask next for an answer that misses its metric: that of the pairs that move, or finer.
double PairState::finerCoarsening() const
{
	return std::min(m_budget->coarsening(), std::max(1.0, m_result.excess / kFiner));
}

std::optional<double> PairState::want(const Prepared& prepared) const
{
	if (!(prepared.isKept || prepared.isStill) || !isRefinable(prepared.pose, prepared.question)) return std::nullopt;
	const bool isMissed = m_result.excess > 0 && finerCoarsening() < prepared.question.settings.metric.coarsening;
	return isMissed ? std::optional<double>(m_result.excess) : std::nullopt;
}

std::optional<double> PairState::want() const
{
	return m_isAhead ? want(*m_ahead) : std::nullopt;
}

void PairState::refine()
{
	refine(*m_ahead);
}

// Refines an answer that lies still. Where what is left of the budget is not enough the answer it has goes on to serve,
// and other pairs have their turn first from then on.
void PairState::refine(Prepared& prepared)
{
	if (!want(prepared) || !m_refining.isOver()) return;
	const PairPose& pose = prepared.pose;
	Question& question = prepared.question;
	ContactSettings settings = static_cast<const ContactSettings&>(question.settings);  // no gap is asked for
	settings.metric.coarsening = finerCoarsening();
	const bool isFirst = m_budget->isWholeSpare();
	settings.budget = m_budget->spare();
	const bool isEnough = settings.budget.tests > kLeastOfTrial * m_report.coarsestTests;
	if (!isEnough || settings.budget.microseconds == 0) return;
	std::uint32_t tests = 0;
	const bool isFound = attempt(pose, settings, tests);
	m_budget->spendSpare(tests);
	if (!isFound)
	{
		if (isFirst) m_refining.fail();
	}
	else
	{
		m_refining.succeed();
		question.settings.metric.coarsening = settings.metric.coarsening;
		prepared.isKept = prepared.isStill = false;
		m_manifolds.readImpulses(m_clusters);
		answer(pose, question, true);
	}
	m_budget->endSpare();
}

// Asks about planes and meshes. They have no hierarchy: what is near of a mesh is gathered.
void PairState::askPartner(const PairPose& pose)
{
	if (pose.partner == Partner::kConcave)
	{
		if (!m_mesh) m_mesh = std::make_unique<NearMesh>();
		bool& isOther = m_facets.levels.isOther = m_answered != nullptr;
		if (!m_mesh->list(pose, m_result.pairs.empty(), scratch().triangles, isOther)) m_partnerSurface.reset();
	}
	answerPartner(pose);
}

void PairState::answerPartner(const PairPose& pose)
{
	const bool isAlone = m_result.pairs.empty() && pose.prediction != Prediction::kStill;  // as it was, and asked again
	GapResult& result = scratch().result;
	result.clear();
	m_partnerStats = {};
	const Hierarchy& hierarchy = pose.hierarchyA();
	const btCollisionShape& shape = *pose.b->getCollisionShape();
	if (pose.partner == Partner::kPlane)
	{
		const auto& plane = static_cast<const btStaticPlaneShape&>(shape);
		const Vec3 normal = normalized(toVec3(plane.getPlaneNormal()));
		const double offset = double(plane.getPlaneConstant()) / pose.scale();
		m_partnerSurface = std::make_shared<ContactSurface>(
			normal, offset, inverse(pose.aFromB) * toVec3(hierarchy.asset().sphereCenter), double(hierarchy.asset().radius));
		const Vec3 inA = pose.aFromB.rotation * normal;
		scratch().partner.withHalfSpace(hierarchy, inA, offset + dot(inA, pose.aFromB.translation), m_report.metric,
										pose.tolerance, result.contacts, m_partnerStats);
	}
	else
	{
		const NearTriangles& triangles = scratch().triangles;
		const Vec3 way = pose.aFromB.rotation * m_facets.through;
		const auto sideOf = [&](const Vec3& normal, double offset)
		{ return SheetCrossing::sideOf(pose.rules, normal, offset, way); };
		PartnerContacts& partner = scratch().partner;
		const auto compare = [&](const NearTriangles& with)
		{
			partner.withTriangles(hierarchy, with, pose.aFromB, sideOf, 2 * double(hierarchy.asset().radius),
								  m_report.metric, pose.tolerance, result.contacts, m_partnerStats);
		};
		const NearTriangles& unknown =
			isAlone ? m_mesh->unknown(pose, m_report.metric, triangles, partner, m_partnerStats) : triangles;
		compare(unknown);
		if (&unknown != &triangles && !result.contacts.empty())
		{
			result.contacts.clear();
			compare(triangles);
		}
		if (result.contacts.empty())
			m_partnerSurface.reset();
		else if (!m_partnerSurface)
			m_partnerSurface = std::make_shared<ContactSurface>(triangles.corners, pose.rules.length);
	}
	result.errorBound = m_partnerStats.errorBound;
	result.stats.boxTests = m_partnerStats.boxTests;
	result.stats.finestLevel = m_partnerStats.nodes ? m_partnerStats.finestLevel : 0;
	result.stats.coarsestLevel = m_partnerStats.coarsestLevel;
	m_result.hold(result);
}

// Where a body is held or pressed between contacts that err, asks again with a quarter of that error: the play is about
// as small as the margins, and contacts that err by more jam. It stays so as long as the pair is near, as coarser ones
// would jam again.
bool PairState::refineHeld(const PairPose& pose, Question& question)
{
	if (m_result.stats.coarsestLevel == 0) return false;
	const bool canMove = pose.rules.a.inverseMass > 0 || pose.rules.b.inverseMass > 0;
	const bool isCoarse = pose.hierarchyA().isCoarse() || (pose.isOfTwo() && pose.hierarchyB().isCoarse());
	Metric& metric = question.settings.metric;
	if (pose.prediction != Prediction::kFree || !canMove || isCoarse || metric.coarsening > 1) return false;
	const double stricter = kStricter * errorOfContacts(pose);
	if (!(stricter < metric.maxError) || !scratch().facets.jamBetween()) return false;
	m_heldError = stricter;
	const double before = std::exchange(metric.maxError, stricter);
	m_report.metric.maxError = stricter;
	if (!pose.isOfTwo())
		answerPartner(pose);
	else
	{
		const std::uint32_t tests = testsOf(m_result.stats);
		if (!askIfAllowed(pose, question))
		{
			metric.maxError = m_report.metric.maxError = before;  // the next dispatch asks for it again
			return false;
		}
		m_report.vainTests += tests;
	}
	return true;
}

// Answers the question. A pair that was and is apart costs as little as possible: nothing is copied, and the clock is
// not read again.
void PairState::answer(const PairPose& pose, Question& question, bool isAsked)
{
	const Clock::time_point start = Clock::now();
	bool goesOn = pose.prediction == Prediction::kSolved && m_followed == 0;
	m_followed = 0;
	if (pose.isOfTwo())
		askAside(pose, question, isAsked);
	else if (!goesOn || pose.tolerance > m_foreseen.tolerance)
	{
		askPartner(pose);
		goesOn = goesOn && pose.partner == Partner::kPlane;  // a mesh's features are numbered as they are gathered
	}
	else
		contactsOf(m_report, scratch().result.contacts);
	const Clock::time_point asked = Clock::now();
	m_report.queryMicroseconds = microsecondsBetween(start, asked);
	const bool staysEmpty = m_result.pairs.empty() && !m_result.deep && m_clusters.isEmpty();
	foresee(pose);
	m_report.candidates = 0;
	m_points = 0;
	if (!staysEmpty)
		findPoints(pose, question, goesOn);
	else
		m_result.pairs.shrink_to_fit();
	if (pose.isOfTwo() && !isAsked)
	{
		m_result.stats.boxTests += m_outline.listing;
		m_report.coarsestTests = m_outline.listing + m_outline.answering;
	}
	m_report.aFromB = pose.aFromB;
	m_report.worldFromA = pose.worldFromA;
	m_report.unit = pose.unit;
	report(pose);
	m_report.contactMicroseconds = staysEmpty ? 0 : microsecondsSince(asked);
	noteAnswered(question);
}

// Remembers what was answered. An answer that a budget cut short is the coarsest: it serves while budgets buy nothing,
// and is asked anew otherwise.
void PairState::noteAnswered(Question& question)
{
	if (m_result.stats.cutShort > 0) question.settings.metric.coarsening = kOff;
	if (m_clusters.isEmpty())
		m_answered.reset();
	else if (m_answered)
		*m_answered = question;
	else
		m_answered = std::make_unique<Question>(question);
}

ContactBody PairState::bodyB(const PairPose& pose) const
{
	if (pose.isOfTwo()) return contactBody(pose.hierarchyB());
	return m_partnerSurface ? contactBody(*m_partnerSurface) : ContactBody{};
}

// Bodies that nothing pushes apart, such as a trigger that sweeps through others, would stay as deep as they have come by
// the way they went in, which is of use only where it leads out again: from the smaller one's radius on another way is
// looked for.
bool PairState::isSweptThrough(const PairPose& pose) const
{
	if (pose.responds) return false;
	const auto& slots = scratch().previous.slots;
	return std::any_of(slots.begin(), slots.end(),
					   [&](const ContactCluster& cluster)
					   {
						   return std::any_of(cluster.points.begin(), cluster.points.begin() + cluster.count,
											  [&](const HeldPoint& p) { return p.point.height < -pose.radius; });
					   });
}

void PairState::findPoints(const PairPose& pose, Question& question, bool goesOn)
{
	FacetContacts& facets = scratch().facets;
	ClusterSet &previous = scratch().previous, &next = scratch().next;
	m_clusters.copyTo(previous);
	previous.motionOfB = pose.aFromB * inverse(m_report.aFromB);
	const ContactBody a = contactBody(pose.hierarchyA());
	const std::vector<Contact>& contacts = scratch().result.contacts;
	if (isSweptThrough(pose)) m_facets = {};
	const JoinedBodies& joined = joinedBodies(pose);
	do
		facets.find(a, bodyB(pose), pose.aFromB, question.rules, contacts, previous, m_facets, goesOn, joined);
	while (refineHeld(pose, question));
	facets.settle(contacts, m_result.deep);
	m_report.candidates = std::uint32_t(facets.size());
	m_points = worthOfPoints(m_result.pairs.size(), facets.size());
	if (m_result.stats.cutShort > 0) m_ofCoarsest = m_points;
	if (m_budget) m_budget->spendPoints(m_points);
	m_foreseen.motion = facets.expectedMotion();
	facets.reduce(next);
	m_foreseen.spare = facets.spare();
	m_foreseen.missed = facets.missed();
	for (std::size_t slot = 0; pose.partner != Partner::kClod && slot < next.slots.size(); ++slot)
		for (std::size_t i = 0; i < std::size_t(next.slots[slot].count); ++i)
			if (!facets.isHeld(slot, i)) namePartnerFace(pose, next.slots[slot].points[i].point);
	m_clusters.hold(next);
}

// Names the part and triangle of a mesh that is no shape of ours as its owner names them.
void PairState::namePartnerFace(const PairPose& pose, ContactPoint& point)
{
	const bool hasGap = pose.isOfTwo() && m_context.searchGap && !pose.isRound();
	if (!hasGap) m_result.minDistance = std::min(m_result.minDistance, point.height + pose.rules.margin - pose.rules.radiusB);
	const std::array<int, 2> name = pose.partner == Partner::kConvex  ? std::array<int, 2>{int(kNone), int(kNone)}
									: pose.partner == Partner::kPlane ? std::array<int, 2>{0, int(kNone)}
																	  : m_mesh->nameOf(point.faceB / 2);
	point.nodeB = std::uint32_t(name[0]);
	point.faceB = std::uint32_t(name[1]);
}

// The most that third bodies carry either body off its way in the step, by how fast those near it close in, as their
// masses tell; what no impulse moves, by its own speed. What is less than the skin is none. Bullet makes a rebound of the
// speed at which the two meet before the step, and met in the step in which they are thrown they have none: where they
// would bounce off, that is left to the next step.
double PairState::shoveOf(const PairPose& pose) const
{
	if (double(gCalculateCombinedRestitutionCallback(m_objects[0], m_objects[1])) > kLively) return 0;
	const auto inverseMassOf = [](const btCollisionObject& object)
	{
		const btRigidBody* const body = btRigidBody::upcast(&object);
		return body ? double(body->getInvMass()) : 0;
	};
	// A broadphase keeps pairs for a while after their boxes have parted, how long by what was before.
	const auto boxesMeet = [](const btCollisionObject& l, const btCollisionObject& r)
	{
		const btBroadphaseProxy *const ofL = l.getBroadphaseHandle(), *const ofR = r.getBroadphaseHandle();
		return ofL && ofR && TestAabbAgainstAabb2(ofL->m_aabbMin, ofL->m_aabbMax, ofR->m_aabbMin, ofR->m_aabbMax);
	};
	double fastest = 0;
	for (std::size_t i = 0; i < 2; ++i)
	{
		const btCollisionObject &own = *m_objects[i], &partner = *m_objects[1 - i];
		const double inverseMass = inverseMassOf(own);
		if (!(inverseMass > 0)) continue;
		const RelativeMotion ofOwn = worldMotion(own, 0);
		const Vec3 center = toVec3(own.getWorldTransform().getOrigin());
		for (const PairState* other : *m_pairsOf[i])
		{
			const btCollisionObject& third = *other->m_objects[other->m_objects[0] == &own ? 1 : 0];
			if (&third == &partner || isFixed(third) || !third.hasContactResponse() || !boxesMeet(own, third)) continue;
			const Vec3 thirdCenter = toVec3(third.getWorldTransform().getOrigin()), between = 0.5 * (center + thirdCenter);
			const Vec3 towards = normalized(center - thirdCenter), ofThird = worldMotion(third, 0).velocity(between);
			const double inverseOfThird = inverseMassOf(third), closing = dot(ofThird - ofOwn.velocity(between), towards);
			const double carries = inverseOfThird > 0 ? closing : std::min(closing, dot(ofThird, towards));
			fastest = std::max(fastest, carries * inverseMass / (inverseMass + inverseOfThird));
		}
	}
	const double way = kThrown * fastest * pose.rules.timeStep / pose.scale();
	return way > kSkinShare * pose.rules.length ? way : 0;
}

// Adds what other pairs of the other body have told of that moves with this side.
void PairState::addJoined(const PairPose& pose, std::size_t side, std::vector<JoinedBody>& joined) const
{
	const btCollisionObject &object = *(side == 0 ? pose.a : pose.b)->getCollisionObject(),
							&touching = *(side == 0 ? pose.b : pose.a)->getCollisionObject();
	if (!(object.isStaticOrKinematicObject() || m_children[side] >= 0)) return;
	for (const PairState* other : *m_pairsOf[m_objects[0] == &touching ? 0 : 1])
		for (const std::optional<Side>& told : other->told())
		{
			if (other == this || !told || told->object == &touching || !told->object->hasContactResponse()) continue;
			const bool isSame = told->object == &object && told->child == m_children[side];
			if (isSame || !moveAsOne(object, *told->object)) continue;
			JoinedBody body;
			body.surface = told->surface.get();
			body.reach = std::numeric_limits<double>::infinity();
			if (told->hierarchy)
			{
				const std::uint32_t most = std::uint32_t(told->hierarchy->levels().size - 1);
				body.surface = &told->hierarchy->derived<ContactSurfaces>().level(std::min(told->level, most));
				body.center = toVec3(told->hierarchy->asset().sphereCenter);
				body.reach = double(told->hierarchy->asset().radius) + told->radius;
			}
			if (!body.surface) continue;
			const Transform worldFromBody = toTransform(told->object->getWorldTransform()) * told->objectFromSide;
			body.bodyFromA = inverse(worldFromBody) * pose.worldFromA;
			body.bodyFromA.translation = (1 / pose.scale()) * body.bodyFromA.translation;
			body.scale = pose.scale() / told->unit;
			body.radius = told->radius;
			const double far = length(worldFromBody.translation) / told->unit;
			body.rounding = kRoundings * (far + (told->hierarchy ? body.reach : 0));
			joined.push_back(body);
		}
}

const JoinedBodies& PairState::joinedBodies(const PairPose& pose) const
{
	JoinedBodies& joined = scratch().joined;
	joined.toA.clear();
	joined.toB.clear();
	if (m_isClosestPoints || !(pose.rules.timeStep > 0)) return joined;
	addJoined(pose, 0, joined.toA);
	addJoined(pose, 1, joined.toB);
	return joined;
}
}  // namespace clod
