// SPDX-License-Identifier: Zlib
// One query in progress, from pose to result: traversal or refinement, contacts, gap, certificate. README.md tells its
// life. Included by Query.cpp only.
#pragma once
#include <algorithm>
#include <limits>
#include <optional>

#include "clod/query/Clock.h"
#include "clod/query/ContactSink.h"
#include "clod/distance/GapCertificate.h"
#include "clod/query/PairCacheState.h"
#include "clod/query/Repetition.h"
#include "clod/query/Traversal.h"

namespace clod
{
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kSharpness = 0.85;      // of the largest s0: no worse is the gap known
inline constexpr double kDepthAccuracy = 1e-6;  // of the smaller radius: how exactly a depth is searched at least

// Refines as long as the budget pays for it and for the answer.
inline void spend(Refinement& walk, const Budget& budget, Clock::time_point start, const AnswerCost& answerCost)
{
	const bool timed = budget.microseconds < kInfinity;
	while (!walk.isComplete() && double(walk.committed() + walk.cost()) <= budget.tests)
	{
		const double answers = double(walk.answers()) + 0.5 * double(walk.cost());
		if (timed && microsecondsSince(start) + answerCost.estimate(answers) > budget.microseconds) return;
		walk.refine();
	}
}

// The gap is beyond the tolerance, but for the nodes' covers.
inline void setNothingNear(const Settings& settings, double largestCover, QueryResult& result)
{
	result.minDistance = kInfinity;
	result.errorBound = settings.contactsOnly ? kInfinity : largestCover;
	result.deep = false;
}

// Counts boxes that point queries meet in its lifetime as such.
class PointBoxes
{
public:
	explicit PointBoxes(QueryStats& stats) : m_stats(stats), m_before(stats.boxTests) {}
	~PointBoxes()
	{
		m_stats.pointBoxes += m_stats.boxTests - m_before;
		m_stats.boxTests = m_before;
	}
	PointBoxes(const PointBoxes&) = delete;
	PointBoxes& operator=(const PointBoxes&) = delete;

private:
	QueryStats& m_stats;
	const std::uint32_t m_before;
};

// One query in progress.
class Evaluation
{
public:
	Evaluation(const QueryContext& context, const Settings& settings, PairCache::State& state, QueryResult& result)
		: m_context(context), m_settings(settings), m_state(state), m_result(result)
	{
	}

	void run()
	{
		const double largestCover = traverse(m_settings.tolerance);
		sortContacts(largestCover);
		const bool overlap = std::any_of(m_result.contacts.begin(), m_result.contacts.end(),
										 [](const Contact& contact) { return contact.upper <= 0; });
		if (overlap && !m_inputOnly && !m_settings.contactsOnly)
			fromSurfaces();
		else
			fromNodes(overlap, largestCover);
		if (isTooCoarse()) fromSurfaces();
		levelStatistics();
		if (!m_settings.budget.isLimited()) return;
		m_state.refinement.addTo(m_result.stats);
		m_result.excess = m_state.refinement.excess();
		m_state.answerCost.observe(m_state.refinement.answers(), microsecondsSince(m_refined));
	}

private:
	// The error that the gap may have.
	double gapLimit() const { return std::min(m_settings.gapError, m_settings.metric.maxError); }
	// The nodes prove less than asked for, or, of a gap within the tolerance, than the threshold s0 lets expect
	// wherever it is largest, and the input surfaces prove more. What a budget cut short is left so, but for gapError.
	bool isTooCoarse() const
	{
		const double bound = m_result.errorBound;
		if (m_settings.contactsOnly || m_result.deep || m_isOfSurfaces || m_inputOnly) return false;
		const bool isUnfinished = m_settings.budget.isLimited() && !m_state.refinement.isComplete();
		if (m_settings.gapError == kInfinity && isUnfinished) return false;
		if (bound > gapLimit()) return true;
		const double s0 = StopRule::thresholds(m_context, m_settings.metric).most;
		return !m_result.contacts.empty() && bound > kSharpness * s0;
	}

	// Gap and bound as far as the accepted pairs prove them.
	void fromNodes(bool overlap, double largestCover)
	{
		const double inside = overlap ? 0 : depthInside();
		if (overlap && m_settings.contactsOnly)
			set({0, kInfinity, false});
		else if (overlap)
			surfacesMeet();
		else if (inside > 0)
			setInside(inside);
		else if (!m_result.contacts.empty())
			set(gapApart(m_context, m_result.contacts, m_settings.tolerance, largestCover));
		else if (m_settings.distance)
			farApart();
		else
			setNothingNear(m_settings, largestCover, m_result);
	}

	// Gap and bound of the input surfaces, whatever answered: what exact mode says.
	void fromSurfaces()
	{
		m_isOfSurfaces = true;
		++m_result.stats.gapSearches;
		double known = m_settings.distance ? kInfinity : m_settings.tolerance;
		if (!m_result.contacts.empty()) known = highFromWitnesses(m_context, m_result.contacts);
		const SurfaceDistance distance = surfaceDistance(m_context, known, m_state.closest, m_result.stats);
		const double inside = distance.high > 0 ? depthInside() : 0;
		if (!(distance.high > 0))
			surfacesMeet();
		else if (inside > 0)
			setInside(inside);
		else if (distance.value < kInfinity)
			set(gapOfSurfaces(distance));
		else
			setNothingNear(m_settings, 0, m_result);
	}

	// A depth is searched among the leaves within so much: most are far below the tolerance, and few leaves then take
	// part. One beyond it is looked for as far as the nodes that overlap may have hidden it.
	void surfacesMeet()
	{
		double deviation = 0;
		for (const Contact& contact : m_result.contacts)
			if (contact.upper <= 0)
				deviation = std::max(deviation, double(m_context.a.node(contact.nodeA).deviation) +
													double(m_context.b.node(contact.nodeB).deviation));
		if (m_inputOnly) deviation = 0;
		const double tolerance = m_settings.tolerance;
		const double farthest = m_settings.distance ? tolerance : tolerance + 2.5 * deviation;
		double found = 0;  // a depth of some point
		for (double reach = tolerance > 0 ? 0.2 * tolerance : farthest;;
			 reach = reach < tolerance ? tolerance : 2 * reach)
		{
			reach = std::min(reach, farthest);
			if ((found < reach || reach == 0) && isDepthWithin(reach, found)) return;
			if (reach == farthest) break;
		}
		setInside(found);
	}

	// The depth is less than `reach`, and set; else some point's is not, or may not be, by `found`.
	bool isDepthWithin(double reach, double& found)
	{
		if (m_inputOnly && reach <= m_settings.tolerance)
		{
			m_state.near.clear();
			for (const Contact& contact : m_result.contacts)
				if (contact.lower <= reach) m_state.near.push_back(contact);
		}
		else
		{
			gatherLeafPairs(m_context, reach, m_state.closest, m_state.near, m_result.stats);
			sortPairs(m_state.near);
		}
		const PointBoxes counting(m_result.stats);
		DepthAccuracy accuracy = depthAccuracy(reach);
		accuracy.enough = reach;
		const DepthBound depth =
			nearPenetration(m_context, m_state.near, accuracy, m_state.penetration, m_result.stats);
		found = std::max(found, depth.lower);
		if (!(depth.upper < reach)) return false;
		set(gapBetween(-depth.upper, -depth.lower));
		return true;
	}

	// Returns the largest cover_a + cover_b of the accepted pairs that are no contacts.
	double traverse(double tolerance)
	{
		const StopRule rule(m_context, m_settings.metric, m_settings.paper);
		if (m_settings.budget.isLimited()) return refine(rule, tolerance);
		if (m_state.base != rule.base()) m_state.clearFronts();
		const double maxError = m_settings.metric.maxError;
		const bool sameRule =
			m_state.filled && m_state.threshold == rule.constantThreshold() && m_state.maxError == maxError;
		const TraversalSettings settings{rule, tolerance, m_settings.paper, sameRule};
		std::optional<double> cover;
		if (Repetition::isWorthTrying(settings, m_state.front)) cover = answered<Repetition>(settings);
		if (!cover) cover = answered<Traversal>(settings);
		m_state.threshold = rule.constantThreshold();
		m_state.maxError = maxError;
		m_state.base = rule.base();
		m_state.settings = m_settings;
		m_state.filled = true;
		return std::max(*cover, rule.baseCover());
	}
	// The sink's largest cover, where the front is the one that was looked for.
	template <class Way>
	std::optional<double> answered(const TraversalSettings& settings)
	{
		m_result.contacts.clear();
		m_result.stats.front = m_result.stats.frontInner = 0;
		const auto covers = settings.rule.base().isUsed() ? ContactSink::Covers::kBounded : coversOfMixedLevels();
		ContactSink sink(m_context, settings.tolerance, covers, m_result.contacts, m_result.stats);
		Way way(m_context, settings, m_state.front, sink, m_result.stats);
		if (!way.run()) return std::nullopt;
		return sink.largestCover();
	}

	ContactSink::Covers coversOfMixedLevels() const
	{
		return m_settings.contactsOnly ? ContactSink::Covers::kUnwanted : ContactSink::Covers::kWanted;
	}

	// The same under a budget: best first, without the front.
	double refine(const StopRule& rule, double tolerance)
	{
		Refinement& walk = m_state.refinement;
		if (!m_state.planned)
		{
			walk.start(m_context, rule, tolerance, m_settings.paper);
			spend(walk, m_settings.budget, m_start, m_state.answerCost);
		}
		m_refined = Clock::now();
		ContactSink sink(m_context, tolerance, coversOfMixedLevels(), m_result.contacts, m_result.stats);
		walk.answer(sink);
		m_state.settings = m_settings;
		m_state.filled = true;
		return std::max(sink.largestCover(), rule.baseCover());
	}

	bool rootIsApart() const
	{
		return m_settings.budget.isLimited() ? m_state.refinement.rootIsApart()
											 : m_state.front.entries[0].state == NodePairState::kSeparated;
	}

	static bool before(const Contact& l, const Contact& r)
	{
		return l.nodeA != r.nodeA ? l.nodeA < r.nodeA : l.nodeB < r.nodeB;
	}
	void sortPairs(std::vector<Contact>& contacts)
	{
		// Buffers that are swapped now and then grow together, so that a steady query allocates nothing.
		m_state.order.reserve(contacts.capacity());
		m_state.unsorted.reserve(contacts.capacity());
		if (std::is_sorted(contacts.begin(), contacts.end(), before)) return;
		m_state.order.clear();
		for (std::uint32_t i = 0; i < contacts.size(); ++i)
			m_state.order.push_back({std::uint64_t(contacts[i].nodeA) << 32 | contacts[i].nodeB, i});
		std::sort(m_state.order.begin(), m_state.order.end());
		m_state.unsorted.swap(contacts);
		contacts.clear();
		for (const auto& next : m_state.order) contacts.push_back(m_state.unsorted[next.contact]);
	}
	// largestCover: of the accepted pairs that are no contacts.
	void sortContacts(double largestCover)
	{
		sortPairs(m_result.contacts);
		m_inputOnly = largestCover == 0;
		for (const Contact& contact : m_result.contacts)
			m_inputOnly = m_inputOnly && m_context.a.node(contact.nodeA).childCount == 0 &&
						  m_context.b.node(contact.nodeB).childCount == 0;
	}

	// > 0: a component of one body is inside the other by so much at one of its points.
	double depthInside()
	{
		if (rootIsApart()) return 0;
		const PointBoxes counting(m_result.stats);
		m_state.probesA.prepare(m_context.a);
		m_state.probesB.prepare(m_context.b);
		const RelativePose& pose = m_context.pose;
		const Transform aFromB{pose.rotation, pose.translation};
		const double motion = m_state.front.motion;
		const double ofA = m_state.probesA.depthInside(m_context.b, inverse(aFromB), motion, m_result.stats);
		return std::max(ofA, m_state.probesB.depthInside(m_context.a, aFromB, motion, m_result.stats));
	}

	// The last per cent of a depth is not worth its cost, unless a limit asks for it.
	DepthAccuracy depthAccuracy(double reach) const
	{
		DepthAccuracy accuracy;
		accuracy.absolute = kDepthAccuracy * std::min(m_context.a.asset().radius, m_context.b.asset().radius);
		if (gapLimit() < kInfinity)
		{
			// A coarser answer could not be told from one beyond reach.
			accuracy.absolute =
				std::max(accuracy.absolute, std::min(0.5 * gapLimit(), 0.2 * std::min(reach, m_settings.tolerance)));
			accuracy.relative = 0;
		}
		if (m_settings.distance || gapLimit() < kInfinity) accuracy.cellLimit *= 10;
		return accuracy;
	}
	// So deep at some point, perhaps deeper.
	void setInside(double depth)
	{
		if (!m_settings.distance)
		{
			set({-depth, kInfinity, true});
			return;
		}
		const PointBoxes counting(m_result.stats);
		const DepthBound whole =
			wholePenetration(m_context, depthAccuracy(m_settings.tolerance), m_state.penetration, m_result.stats);
		set(gapBetween(-whole.upper, -whole.lower));
		m_result.deep = true;
	}

	// Nothing within the tolerance: the closest accepted pair, then the certificate within its distance.
	void farApart()
	{
		const StopRule rule(m_context, m_settings.metric, m_settings.paper);
		if (rule.isOfLeaves() || gapLimit() < kInfinity)
		{
			fromSurfaces();
			return;
		}
		const double distance = closestDistance(m_context, rule, m_settings.paper, m_state.closest, m_result.stats);
		const double largestCover = traverse(distance);
		sortContacts(largestCover);
		set(gapApart(m_context, m_result.contacts, distance, largestCover));
		m_result.contacts.clear();
	}

	void set(const Gap& gap)
	{
		m_result.minDistance = gap.value;
		m_result.errorBound = gap.errorBound;
		m_result.deep = gap.deep;
	}

	void levelStatistics()
	{
		if (m_result.contacts.empty()) return;
		std::uint32_t finest = kNone, coarsest = 0;
		for (const Contact& contact : m_result.contacts)
		{
			const std::uint32_t levelA = m_context.a.node(contact.nodeA).level,
								levelB = m_context.b.node(contact.nodeB).level;
			finest = std::min({finest, levelA, levelB});
			coarsest = std::max({coarsest, levelA, levelB});
		}
		m_result.stats.finestLevel = finest;
		m_result.stats.coarsestLevel = coarsest;
	}

	const QueryContext& m_context;
	const Settings& m_settings;
	PairCache::State& m_state;
	QueryResult& m_result;
	const Clock::time_point m_start = Clock::now();
	Clock::time_point m_refined;  // the budget is spent, the answer begins
	bool m_isOfSurfaces = false;  // the gap, whatever answered
	bool m_inputOnly = true;      // every accepted pair is of level 0: nothing finer exists
};
}  // namespace clod
