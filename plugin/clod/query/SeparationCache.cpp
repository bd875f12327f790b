// SPDX-License-Identifier: Zlib
#include "clod/query/SeparationCache.h"

#include <algorithm>

#include "clod/collide/MotionBound.h"
#include "clod/query/HullCull.h"

namespace clod
{
namespace
{
// What a search is for, and a traversal finds nothing of: contacts, or pairs whose surfaces may be near, too.
struct Searched
{
	StopRule strict;   // a pair that answers by this rule is not opened by any in question,
	StopRule relaxed;  // one that does not by this rule answers by none: differing in the threshold only
	double tolerance;
	bool surfaces;
};

struct MotionJudge
{
	const QueryContext& context;
	QueryStats& stats;
	const Searched& what;
	double best;
	NearestPair& nearest;
	NearestPairScratch& scratch;
	const WorkLimit& limitOfWork;
	bool isSpent = false;
	static constexpr bool nearestFirst = false;

	// Once: its own separation is a bound whichever the way.
	bool counts(const NearestPairScratch::Candidate& pair, double)
	{
		scratch.visited.reserve(1);
		return scratch.visited.insert(pair.a, pair.b);
	}
	static bool takes(const NearestPairScratch::Candidate&) { return true; }
	bool isSettled() { return best <= 0 || !affords(kTestsOfCandidate); }
	// Once it does not, the search is over.
	bool affords(std::size_t tests)
	{
		isSpent = isSpent || (limitOfWork.isSet() && !limitOfWork.allows(stats.boxTests + stats.hullTests + tests));
		return !isSpent;
	}
	// Hulls that overlap now may answer as soon as they part.
	bool mayAnswer(const NearestPairScratch::Candidate& pair) const
	{
		return what.relaxed.acceptance(pair.a, pair.b) != Acceptance::kNo;
	}
	// Pairs that leave half as much to go as the best are not looked at, and half of the best is the answer: a fifth of
	// the tests, for a search a half more often.
	double limit() const { return what.tolerance + kShareOfNearest * best; }
	double ofPair(const NearestPairScratch::Candidate& pair)
	{
		++stats.hullTests;
		const double reached =
			what.surfaces ? cullLimit(context.a.node(pair.a), context.b.node(pair.b), what.tolerance) : what.tolerance;
		const SweptBound bound = canonicalSweptBound(context, pair.a, pair.b, reached + best);
		const double motion = std::max(pair.separation - what.tolerance, bound.lower - reached);
		if (motion < best) nearest = {pair.a, pair.b};
		return motion;
	}
};

// By how much the pair may move, sweep included (MotionBound.h), before a traversal can find something by the two rules
// or any between them; at most `cap`. <= 0: it may already, or the limit was met.
double safeMotion(const QueryContext& context, const Searched& what, double cap, const SeparationCache::Tools& tools)
{
	thread_local NearestPairScratch scratch;
	QueryStats& stats = tools.stats;
	scratch.visited.clear();
	MotionJudge judge{context, stats, what, cap, tools.nearest, scratch, tools.limit};
	if (!judge.affords(kTestsOfCandidate)) return 0;
	const auto [a, b] = tools.nearest;
	if (isAnswer(context, what.relaxed, tools.nearest))
	{
		++stats.boxTests;
		judge.best = std::min(
			cap, judge.ofPair({boxSeparation(context.boxes, context.a.cullBox(a), context.b.cullBox(b)), a, b}));
	}
	NearestPairSearch<MotionJudge>(context, what.strict, judge, scratch, stats).run();
	if (judge.isSpent) return 0;
	return judge.best > 0 ? kShareOfNearest * judge.best : judge.best;
}

// Thresholds that may be others in the next query: that depend on the pose, or on what a budget buys.
bool changes(const Metric& metric)
{
	return metric.velocity.time < kOff || metric.view.pixels < kOff || metric.own || metric.coarsening > 1;
}

// Coarse hulls may be apart where surfaces meet: how far neither body, nor a component of it, comes to lie in the other, at
// most `wanted`.
double outside(const QueryContext& context, double wanted, const SeparationCache::Tools& tools)
{
	const PointBoxes counting(tools.stats);
	const Transform aFromB{context.pose.rotation, context.pose.translation};
	tools.probesA.prepare(context.a);
	tools.probesB.prepare(context.b);
	const double ofA = tools.probesA.distanceOutside(context.b, inverse(aFromB), wanted, tools.stats);
	return tools.probesB.distanceOutside(context.a, aFromB, ofA, tools.stats);
}

// For the rounding of the search and of what a traversal would compute now.
double room(const QueryContext& context, double tolerance)
{
	return 2 * (kSumRounding * context.size + context.boxes.roundingOfTwo()) +
		   kEvaluationRoom * (context.size + tolerance) + 4 * context.pose.rounding;
}
}  // namespace

bool SeparationCache::holds(const QueryContext& context, const ContactSettings& settings, const AskedGap& gap)
{
	if (!m_motion.isKnown() || !isMeantFor(settings, gap)) return false;
	const double motion = motionBound(m_pose, context.pose, context.radiusA, context.radiusB);
	const double change = sweepChange(m_pose, m_settings.sweep, context.pose, context.sweep, motion, context.radiusB);
	if (!m_motion.allows(motion + change + room(context, settings.tolerance))) return false;
	if (!isWithinThresholds(context, settings.metric)) return false;
	m_motion.use();
	return true;
}

void SeparationCache::seek(const QueryContext& context, const StopRule& rule, const ContactSettings& settings,
						   const AskedGap& gap, double lastMove, const Tools& tools)
{
	if (gap.isAskedApart) return;
	if (!m_motion.isToBeSought()) return;
	const double cap = lastMove > 0 ? kFarthestSearch * lastMove : settings.tolerance;
	const double toGo = motionToGo(context, rule, settings, gap, cap, tools);
	m_motion.set(toGo > 0 && context.hasInput() ? outside(context, toGo, tools) : toGo);
	m_pose = context.pose;
	m_settings = settings;
	m_gap = gap;
}

// Thresholds that change with pose, motion and camera: before a contact by any of those near the present ones. Where the
// gap is asked for, before a query would prove anything else of it.
double SeparationCache::motionToGo(const QueryContext& context, const StopRule& rule, const ContactSettings& settings,
								   const AskedGap& gap, double cap, const Tools& tools)
{
	m_thresholds = StopRule::thresholds(context, settings.metric);
	if (changes(settings.metric) && m_thresholds.most < kOff)
	{
		m_thresholds.least /= kThresholdSpan;
		m_thresholds.most = std::min(kThresholdSpan * m_thresholds.most, std::numeric_limits<double>::max());
	}
	const Searched contacts{rule.with(m_thresholds.least), rule.with(m_thresholds.most), settings.tolerance,
						   gap.isAsked && !rule.base().isUsed()};
	const double motion = safeMotion(context, contacts, cap, tools);
	m_largestCover = rule.baseCover();
	if (!gap.isAsked || m_largestCover <= gap.error) return motion;
	// The surfaces are asked (distance/SignedGap.cpp).
	m_largestCover = 0;
	if (!(motion > 0)) return motion;
	const StopRule exact = StopRule::ofLeaves(context);
	return safeMotion(context, {exact, exact, settings.tolerance, false}, motion, tools);
}

bool SeparationCache::isWithinThresholds(const QueryContext& context, const Metric& metric) const
{
	if ((metric.exact && metric.coarsening == 1) || (!changes(metric) && same(metric, m_settings.metric))) return true;
	const ThresholdRange now = StopRule::thresholds(context, metric);
	return (now.most < kOff) == (m_thresholds.most < kOff) && now.least >= m_thresholds.least &&
		   now.most <= m_thresholds.most;
}

bool SeparationCache::isMeantFor(const ContactSettings& settings, const AskedGap& gap) const
{
	const Metric &asked = settings.metric, &known = m_settings.metric;
	const bool hasLimit = asked.exact || asked.maxError < kOff || !(std::max(asked.coarsening, known.coarsening) < kOff);
	return asked.exact == known.exact && asked.maxError == known.maxError &&
		   (!hasLimit || asked.coarsening == known.coarsening) && settings.tolerance <= m_settings.tolerance &&
		   gap == m_gap && !gap.isAskedApart;
}
}  // namespace clod
