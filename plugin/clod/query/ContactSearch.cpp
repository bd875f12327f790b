// SPDX-License-Identifier: Zlib
#include "clod/query/ContactSearch.h"

#include <algorithm>

#include "clod/collide/MotionBound.h"
#include "clod/query/Constants.h"
#include "clod/query/Traversal.h"

namespace clod
{
namespace
{
void levelStatistics(const QueryContext& context, ContactResult& result)
{
	if (result.contacts.empty()) return;
	std::uint32_t finest = kNone, coarsest = 0;
	for (const Contact& contact : result.contacts)
	{
		const std::uint32_t levelA = context.a.node(contact.nodeA).level, levelB = context.b.node(contact.nodeB).level;
		finest = std::min({finest, levelA, levelB});
		coarsest = std::max({coarsest, levelA, levelB});
	}
	result.stats.finestLevel = finest;
	result.stats.coarsestLevel = coarsest;
}
// It depends on the two hierarchies only: all coarsest answers are of one rule.
StopRule coarsestRule(const QueryContext& context)
{
	Metric metric;
	metric.coarsening = kOff;
	return StopRule(context, metric);
}
// Of an accepted pair of which nothing is remembered, at most.
std::uint32_t testsOfFreshAnswer(const QueryContext& context)
{
	return context.longestMove > 0 ? 2 : 1;
}
}  // namespace

void followMotion(const QueryContext& context, PairCache::State& state)
{
	const bool sameBodies = state.a == &context.a && state.b == &context.b && state.hashA == context.a.contentHash() &&
							state.hashB == context.b.contentHash();
	if (!sameBodies)
	{
		state.clearFronts();
		state.outline.reset();
		state.lastMove = state.lastApproach = 0;
		state.a = &context.a;
		state.b = &context.b;
		state.hashA = context.a.contentHash();
		state.hashB = context.b.contentHash();
		state.filled = false;
	}
	else if (!(state.pose.rotation == context.pose.rotation && state.pose.translation == context.pose.translation &&
			   state.sweep == context.sweep))
	{
		const double motion = motionBound(state.pose, context.pose, context.radiusA, context.radiusB);
		const double change =
			sweepChange(state.pose, state.sweep, context.pose, context.sweep, motion, context.radiusB);
		const double changeInA =
			sweepChangeOfParts(state.pose, state.sweep, context.pose, context.sweep, context.radiusB);
		const double farthest = kFarthestMotion * context.size;
		state.front.move(motion, change, changeInA);
		state.lastMove += motion + change;
		state.lastApproach =
			approachBound(state.pose, state.sweep, context.pose, context.sweep, context.radiusA, context.radiusB);
		if (!(state.front.motion < farthest)) state.clearFronts();
		if (state.outline)
		{
			state.outline->move(motion, change, changeInA);
			if (!(state.outline->motion < farthest)) state.outline->clear();
		}
	}
	state.pose = context.pose;
	state.sweep = context.sweep;
}

Outline outline(const QueryContext& context, double tolerance, PairCache::State& state)
{
	if (!state.outline) state.outline = std::make_unique<PairFront>();
	PairFront& front = *state.outline;
	front.isAtHand = true;
	Outline result;
	if (front.entries.empty() || front.motionSince > 0 || front.tolerance != tolerance)
	{
		QueryStats stats;
		std::vector<Contact> none;
		ContactSink sink = ContactSink::ofLists(context, tolerance, none, stats);
		traverse(context, {coarsestRule(context), tolerance, true}, front, sink, stats);
		result.listing = stats.boxTests + stats.hullTests;
	}
	const auto answers = std::count_if(front.entries.begin(), front.entries.end(), [](const FrontEntry& entry)
									   { return entry.state == NodePairState::kAnswer; });
	result.answering = std::uint32_t(answers) * testsOfFreshAnswer(context);
	return result;
}

ContactSearch::ContactSearch(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB,
							 const ContactSettings& settings, const AskedGap& gap, PairCache::State& state,
							 ContactResult& result)
	: m_settings(settings),
	  m_gap(gap),
	  m_state(state),
	  m_result(result),
	  m_limit(settings.budget),
	  m_context(a, b, aFromB, settings.sweep),
	  m_answered(&state.front)
{
	followMotion(m_context, state);
	if (!state.separation.holds(m_context, settings, gap))
	{
		m_rule.emplace(m_context, settings.metric);
		return;
	}
	m_isStillApart = true;
	state.lastMove = 0;
	countQuiet(true);
	result.stats.front = state.front.counts.leaves;
	result.stats.frontInner = state.front.counts.inner;
	result.stats.stillApart = 1;
}

bool ContactSearch::run(double tolerance)
{
	m_tolerance = tolerance;
	const std::optional<double> covered = traverseFront(tolerance);  // which may change the rule
	if (!covered) return false;
	m_largestCover = std::max(*covered, m_rule->baseCover());
	sort();
	return true;
}

void ContactSearch::finish(bool isNothingNear)
{
	levelStatistics(m_context, m_result);
	if (isCoarsened()) tellExcess();
	if (isNothingNear && m_result.stats.cutShort == 0)
		m_state.separation.seek(m_context, *m_rule, m_settings, m_gap, m_state.lastMove,
								{m_state.nearest, m_state.probesA, m_state.probesB, m_result.stats, m_limit});
	countQuiet(isNothingNear);
	m_state.lastMove = 0;
}

// Memory follows contact: a pair that has long found nothing keeps no front, nor does one whose next will be another.
void ContactSearch::countQuiet(bool isNothingNear)
{
	PairFront& front = m_state.front;
	m_state.calmFor = m_state.lastMove > kMovingShare * m_settings.tolerance ? 0 : std::min(m_state.calmFor + 1, kCalm);
	const bool isOfNoUse = isMovingOn(), wasKept = front.isKept;
	m_state.quietFor = isNothingNear ? std::min(m_state.quietFor + 1, kParted) : 0;
	if (m_state.quietFor == kParted && wasKept) m_state.outline.reset();
	front.isKept = m_state.quietFor < kParted && !isOfNoUse;
	settle(front, front.isKept && (wasKept || !isNothingNear));
}

// Of one level of each body, where most of a front is another after so far a motion: then it is kept only where it is
// small beside the bodies.
bool ContactSearch::isMovingOn() const
{
	const bool isOfBase = m_rule && m_rule->base().isUsed() && !m_limit.isSet() && !isOfSinglePiece();
	const double ofBodies = double(m_context.a.bytes().size() + m_context.b.bytes().size());
	const double ofFront = double(m_state.front.entries.size() * sizeof(FrontEntry));
	return isOfBase && ofFront > kFrontShare * ofBodies && m_state.calmFor < kCalm;
}

bool ContactSearch::isOfSinglePiece() const
{
	return m_context.a.levels()[0].nodeCount == 1 || m_context.b.levels()[0].nodeCount == 1;
}

void ContactSearch::tellExcess()
{
	Metric asked = m_settings.metric;
	asked.coarsening = 1;
	const StopRule rule(m_context, asked);
	for (const Contact& contact : m_result.contacts)
	{
		const double excess = rule.excess(contact.nodeA, contact.nodeB, contact.lower > 0);
		m_result.stats.pending += excess > 0 ? 1 : 0;
		m_result.excess = std::max(m_result.excess, excess);
	}
}

bool ContactSearch::overlaps() const
{
	return std::any_of(m_result.contacts.begin(), m_result.contacts.end(),
					   [](const Contact& contact) { return contact.upper <= 0; });
}

// Returns the largest cover_a + cover_b of the accepted pairs that are no contacts; none of a trial that fails.
std::optional<double> ContactSearch::traverseFront(double tolerance)
{
	if (m_limit.isSet() && !m_settings.isTrial)
	{
		const Outline coarsest = outline(m_context, tolerance, m_state);
		m_result.stats.boxTests += coarsest.listing;
		m_limit.holdBack(coarsest.answering);
	}
	m_answered = &m_state.front;
	const std::optional<double> cover = traverseBy(*m_rule, tolerance, m_limit);
	if (cover) return cover;
	remember(*m_rule);  // the front is of it, as far as it goes
	m_state.separation.forget();
	m_result.stats.cutShort = 1;
	m_result.stats.front = m_result.stats.frontInner = 0;
	m_result.contacts.clear();
	if (m_settings.isTrial) return std::nullopt;
	return answerCoarsest(tolerance);
}

// Of the outline: nothing is remembered of its pairs, they take what was held back.
double ContactSearch::answerCoarsest(double tolerance)
{
	m_rule.emplace(coarsestRule(m_context));
	m_answered = m_state.outline.get();
	addTo(m_result.stats, m_answered->counts);
	ContactSink sink = sinkOf(*m_rule, tolerance);
	for (const FrontEntry& entry : m_answered->entries)
	{
		CachedSeparation nothing;
		HullEvaluations none;
		if (entry.state == NodePairState::kAnswer) sink.answer(entry.a, entry.b, nothing, none);
	}
	m_leastApart = sink.leastApart();
	return sink.largestCover();
}

void ContactSearch::remember(const StopRule& rule)
{
	m_state.threshold = rule.constantThreshold();
	m_state.maxError = rule.maxError();
	m_state.base = rule.base();
	m_state.filled = true;
}

// By how much more than the tolerance a front is made for. Pairs of base levels leave no trace unless they are
// contacts, so that such a front has all contacts until the motion has used that up. Of two surfaces that fit into each
// other it would have many times the pairs: where one body is a single piece; of coarse levels, where pairs are opened
// whose hulls overlap, a point or a segment. A piece's size more hardly adds pairs, however small the body.
double ContactSearch::lookAhead(const StopRule& rule, const WorkLimit& limit) const
{
	const bool isCore = m_context.a.isThinCore() || m_context.b.isThinCore();
	const bool maySee = rule.isOfLeaves() || (isCore && rule.base().isUsed());
	if (!isOfSinglePiece() || !maySee || limit.isSet() || !m_state.front.isKept) return 0;
	const bool aIsSingle = m_context.a.levels()[0].nodeCount == 1;
	const double radius = double(std::min(m_context.a.asset().radius, m_context.b.asset().radius));
	const double size = radius + pieceOf(aIsSingle ? m_context.b : m_context.a);
	return (isCore ? kFartherOfCore : 1) * std::min(kMovesAhead * m_state.lastApproach, kMostAhead * size);
}

// None where the limit was met.
std::optional<double> ContactSearch::traverseBy(const StopRule& rule, double tolerance, const WorkLimit& limit)
{
	if (m_state.base != rule.base()) m_state.clearFronts();
	PairFront& front = m_state.front;
	const bool sameRule =
		m_state.filled && m_state.threshold == rule.constantThreshold() && m_state.maxError == rule.maxError();
	const double ahead = lookAhead(rule, limit);
	front.isAtHand = ahead > 0;
	const bool hasMore = sameRule && front.tolerance > tolerance && front.tolerance < tolerance + 2 * ahead;
	std::optional<double> cover;
	if (hasMore && hasAllAnswers(m_context, tolerance, front))
		cover = answerFrom(answerFromLast, {rule, front.tolerance, sameRule, limit}, tolerance);
	if (!cover)
	{
		cover = answerFrom(traverse, {rule, tolerance + ahead, sameRule, limit}, tolerance);
		if (cover && ahead > 0) front.makeRoom();  // others are never asked for their answers again
	}
	remember(rule);
	return cover;
}

// By boxes as the settings say, by hulls within the tolerance: the sink's largest cover.
std::optional<double> ContactSearch::answerFrom(Walk& walk, const TraversalSettings& settings, double tolerance)
{
	m_result.contacts.clear();
	m_result.stats.front = m_result.stats.frontInner = 0;
	ContactSink sink = sinkOf(settings.rule, tolerance);
	if (!walk(m_context, settings, m_state.front, sink, m_result.stats)) return std::nullopt;
	m_leastApart = sink.leastApart();
	return sink.largestCover();
}

ContactSink ContactSearch::sinkOf(const StopRule& rule, double tolerance) const
{
	using Covers = ContactSink::Covers;
	const Covers covers =
		rule.base().isUsed() ? Covers::kBounded : m_gap.isAsked ? Covers::kWanted : Covers::kUnwanted;
	ContactSink sink(m_context, tolerance, covers, m_result.contacts, m_result.stats);
	if (m_settings.signsOnly && !m_gap.isAsked) sink.leaveOutDistances();
	return sink;
}

bool ContactSearch::rootIsApart() const
{
	return m_answered->entries[0].state == NodePairState::kSeparated;
}

void ContactSearch::sort()
{
	sortByNodes(m_result.contacts);
	m_isOfInput = hasInput() && m_largestCover == 0;
	for (const Contact& contact : m_result.contacts)
		m_isOfInput = m_isOfInput && m_context.a.node(contact.nodeA).childCount == 0 &&
					  m_context.b.node(contact.nodeB).childCount == 0;
}

// Of the two surfaces, by what was found with base levels: what is no contact is farther than the tolerance, but for
// covers.
double ContactSearch::leastApart() const
{
	if (!m_rule->base().isUsed()) return 0;
	return std::min(m_leastApart, m_tolerance - m_rule->baseCover());
}

double ContactSearch::hiddenDepth() const
{
	double most = m_largestCover;
	for (const Contact& contact : m_result.contacts)
		most = std::max(most, m_context.coversOf(contact.nodeA, contact.nodeB));
	for (const FrontEntry& entry : m_answered->entries)
		if (entry.state == NodePairState::kAnswer) most = std::max(most, m_context.coversOf(entry.a, entry.b));
	return most;
}

double ContactSearch::depthInside()
{
	if (rootIsApart()) return 0;
	const PointBoxes counting(m_result.stats);
	m_state.probesA.prepare(m_context.a);
	m_state.probesB.prepare(m_context.b);
	const RelativePose& pose = m_context.pose;
	const Transform aFromB{pose.rotation, pose.translation};
	const double apart = leastApart();
	const double ofA = m_state.probesA.depthInside(m_context.b, inverse(aFromB), apart, m_result.stats);
	return std::max(ofA, m_state.probesB.depthInside(m_context.a, aFromB, apart, m_result.stats));
}
}  // namespace clod
