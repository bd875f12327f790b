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
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A plan's query may have an own threshold: it is the one the plan was made with.
bool sameButOwn(ContactSettings l, ContactSettings r)
{
	if (l.metric.own != r.metric.own) return false;
	l.metric.own = r.metric.own = nullptr;
	return same(l, r);
}

// Refines as long as the budget pays for it and for the answer.
void spend(Refinement& walk, const Budget& budget, Clock::time_point start, const AnswerCost& answerCost)
{
	const bool timed = budget.microseconds < kInfinity;
	while (!walk.isComplete() && double(walk.committed() + walk.cost()) <= budget.tests)
	{
		const double answers = double(walk.answers()) + 0.5 * double(walk.cost());
		if (timed && microsecondsSince(start) + answerCost.estimate(answers) > budget.microseconds) return;
		walk.refine();
	}
}

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
}  // namespace

bool isSamePose(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const ContactSettings& settings,
				PairCache::State& state)
{
	const bool samePose = state.filled && state.a == &a && state.b == &b && state.hashA == a.contentHash() &&
						  state.hashB == b.contentHash() && same(state.aFromB, aFromB);
	// A plan has moved the cache to its pose; the last result stayed behind.
	const bool wasPlanned = state.planned.has_value();
	if (!(samePose && sameButOwn(state.settings, settings))) state.planned.reset();
	return samePose && !wasPlanned;
}

bool answersAgain(const ContactSettings& settings, const ContactResult& last, const PairCache::State& state)
{
	if (same(state.settings, settings)) return true;
	const double needed = double(state.refinement.needed());
	if (!state.settings.budget.isLimited() || last.excess > 0) return false;
	if (!(settings.budget.tests < kInfinity && settings.budget.tests >= needed)) return false;
	ContactSettings before = state.settings;
	before.budget = settings.budget;
	return same(before, settings);
}

void followMotion(const QueryContext& context, const ContactSettings& settings, PairCache::State& state)
{
	const bool sameBodies = state.a == &context.a && state.b == &context.b && state.hashA == context.a.contentHash() &&
							state.hashB == context.b.contentHash();
	if (!sameBodies)
	{
		state.clearFronts();
		state.a = &context.a;
		state.b = &context.b;
		state.hashA = context.a.contentHash();
		state.hashB = context.b.contentHash();
		state.filled = false;
	}
	else if (state.filled)
	{
		const double motion = motionBound(state.pose, context.pose, context.radiusA, context.radiusB);
		const double change =
			sweepChange(state.pose, state.settings.sweep, context.pose, context.sweep, motion, context.radiusB);
		state.front.move(motion, change);
		state.lastMove = motion + change;
		const bool otherTree = state.settings.budget.isLimited() != settings.budget.isLimited();
		if (otherTree || !(state.front.motion < kFarthestMotion * context.size)) state.clearFronts();
	}
	state.pose = context.pose;
}

ContactSearch::ContactSearch(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB,
							 const ContactSettings& settings, const AskedGap& gap, PairCache::State& state,
							 ContactResult& result)
	: m_settings(settings), m_gap(gap), m_state(state), m_result(result)
{
	if (state.planned)
	{
		m_context = &*state.planned;
		m_rule = state.refinement.rule();
		return;
	}
	m_context = &m_own.emplace(a, b, aFromB, settings.sweep);
	followMotion(*m_context, settings, state);
	state.aFromB = aFromB;
	m_isStillApart = state.separation.holds(*m_context, settings, gap);
	if (!m_isStillApart)
	{
		m_rule.emplace(*m_context, settings.metric);
		return;
	}
	state.settings = settings;
	result.stats.front = state.front.counts.leaves;
	result.stats.frontInner = state.front.counts.inner;
	result.stats.stillApart = 1;
}

void ContactSearch::run(double tolerance)
{
	m_largestCover = m_settings.budget.isLimited() ? refine(tolerance) : traverseFront(tolerance);
	m_largestCover = std::max(m_largestCover, m_rule->baseCover());
	sort();
}

void ContactSearch::finish(bool isNothingNear)
{
	levelStatistics(*m_context, m_result);
	if (m_settings.budget.isLimited())
	{
		m_state.refinement.addTo(m_result.stats);
		m_result.excess = m_state.refinement.excess();
		m_state.answerCost.observe(m_state.refinement.answers(), microsecondsSince(m_refined));
	}
	const bool wasPlanned = m_state.planned.has_value();
	if (isNothingNear && !wasPlanned)
		m_state.separation.seek(*m_context, *m_rule, m_settings, m_gap, m_state.lastMove,
								{m_state.nearest, m_state.probesA, m_state.probesB, m_result.stats});
	m_state.planned.reset();
}

bool ContactSearch::overlaps() const
{
	return std::any_of(m_result.contacts.begin(), m_result.contacts.end(),
					   [](const Contact& contact) { return contact.upper <= 0; });
}

bool ContactSearch::isCutShort() const
{
	return m_settings.budget.isLimited() && !m_state.refinement.isComplete();
}

// Returns the largest cover_a + cover_b of the accepted pairs that are no contacts.
double ContactSearch::traverseFront(double tolerance)
{
	const StopRule& rule = *m_rule;
	if (m_state.base != rule.base()) m_state.clearFronts();
	const double maxError = m_settings.metric.maxError;
	const bool sameRule =
		m_state.filled && m_state.threshold == rule.constantThreshold() && m_state.maxError == maxError;
	const TraversalSettings settings{rule, tolerance, sameRule};
	std::optional<double> cover;
	if (isWorthValidating(settings, m_state.front)) cover = answerFrom(true, settings);
	if (!cover) cover = answerFrom(false, settings);
	m_state.threshold = rule.constantThreshold();
	m_state.maxError = maxError;
	m_state.base = rule.base();
	m_state.settings = m_settings;
	m_state.filled = true;
	return *cover;
}

// From the last front, if it still is one, or a new one: the sink's largest cover.
std::optional<double> ContactSearch::answerFrom(bool validates, const TraversalSettings& settings)
{
	m_result.contacts.clear();
	m_result.stats.front = m_result.stats.frontInner = 0;
	const auto covers = settings.rule.base().isUsed() ? ContactSink::Covers::kBounded : coversOfMixedLevels();
	ContactSink sink(*m_context, settings.tolerance, covers, m_result.contacts, m_result.stats);
	if (!validates)
		traverse(*m_context, settings, m_state.front, sink, m_result.stats);
	else if (!validateFront(*m_context, settings, m_state.front, sink, m_result.stats))
		return std::nullopt;
	return sink.largestCover();
}

ContactSink::Covers ContactSearch::coversOfMixedLevels() const
{
	return m_gap.isAsked ? ContactSink::Covers::kWanted : ContactSink::Covers::kUnwanted;
}

// The same under a budget: best first, without the front.
double ContactSearch::refine(double tolerance)
{
	Refinement& walk = m_state.refinement;
	if (!m_state.planned)
	{
		walk.start(*m_context, *m_rule, tolerance);
		spend(walk, m_settings.budget, m_start, m_state.answerCost);
	}
	m_refined = Clock::now();
	ContactSink sink(*m_context, tolerance, coversOfMixedLevels(), m_result.contacts, m_result.stats);
	walk.answer(sink);
	m_state.settings = m_settings;
	m_state.filled = true;
	return sink.largestCover();
}

bool ContactSearch::rootIsApart() const
{
	return m_settings.budget.isLimited() ? m_state.refinement.rootIsApart()
										 : m_state.front.entries[0].state == NodePairState::kSeparated;
}

void ContactSearch::sort()
{
	m_state.sorter.sort(m_result.contacts);
	m_isOfInput = m_largestCover == 0;
	for (const Contact& contact : m_result.contacts)
		m_isOfInput = m_isOfInput && m_context->a.node(contact.nodeA).childCount == 0 &&
					  m_context->b.node(contact.nodeB).childCount == 0;
}

double ContactSearch::depthInside()
{
	if (rootIsApart()) return 0;
	const PointBoxes counting(m_result.stats);
	m_state.probesA.prepare(m_context->a);
	m_state.probesB.prepare(m_context->b);
	const RelativePose& pose = m_context->pose;
	const Transform aFromB{pose.rotation, pose.translation};
	const double motion = m_state.front.motion;
	const double ofA = m_state.probesA.depthInside(m_context->b, inverse(aFromB), motion, m_result.stats);
	return std::max(ofA, m_state.probesB.depthInside(m_context->a, aFromB, motion, m_result.stats));
}
}  // namespace clod
