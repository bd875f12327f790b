// SPDX-License-Identifier: Zlib
// One query in progress, from pose to result: traversal or refinement, contacts, gap, certificate. README.md tells its
// life. Included by Query.cpp only.
#pragma once
#include <algorithm>
#include <chrono>
#include <limits>

#include "clod/query/ContactSink.h"
#include "clod/query/GapCertificate.h"
#include "clod/query/PairState.h"
#include "clod/query/Traversal.h"

namespace clod
{
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kDepthAccuracy = 1e-6;  // of the smaller radius: how exactly a depth is searched at least
inline constexpr double kDepthShare = 0.4;  // of the deviations: a depth known better would not make the bound tighter

using Clock = std::chrono::steady_clock;
inline double microsecondsSince(Clock::time_point start)
{
	return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

// Refines as long as the budget pays for it and for the answer.
inline void spend(Refinement& walk, const Budget& budget, Clock::time_point start, double microsecondsPerAnswer)
{
	const bool timed = budget.microseconds < kInfinity;
	while (!walk.isComplete() && double(walk.committed() + walk.cost()) <= budget.tests)
	{
		const double answer = microsecondsPerAnswer * (double(walk.answers()) + 0.5 * double(walk.cost()));
		if (timed && microsecondsSince(start) + answer > budget.microseconds) return;
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
		double limit = m_settings.metric.maxError;
		for (std::uint32_t restarts = 0;; ++restarts)
		{
			m_result.contacts.clear();
			m_result.deep = false;
			once(limit);
			m_result.stats.restarts = restarts;
			const double error = m_result.errorBound;
			const bool unproved = error == kInfinity && (m_settings.contactsOnly || m_result.contacts.empty());
			if (!(error > m_settings.metric.maxError) || unproved || m_inputOnly || !paysForRestart()) break;
			// Halve the limit, or more where the bound asks for it; three passes reach the input surface.
			limit = restarts < 2 ? 0.5 * limit * std::max(0.125, m_settings.metric.maxError / error) : 0;
		}
		levelStatistics();
		if (!m_settings.budget.isLimited()) return;
		m_state.refinement.addTo(m_result.stats);
		m_result.excess = m_state.refinement.excess();
		m_state.microsecondsPerAnswer =
			microsecondsSince(m_refined) / double(std::max<std::size_t>(1, m_state.refinement.answers()));
	}

private:
	void once(double limit)
	{
		const double largestCover = traverse(limit, m_settings.tolerance);
		sortContacts();
		const bool overlap = std::any_of(m_result.contacts.begin(), m_result.contacts.end(),
										 [](const Contact& contact) { return contact.upper <= 0; });
		const double inside = overlap ? 0 : depthInside();
		if (overlap || inside > 0)
			overlapping(overlap, inside, limit);
		else if (!m_result.contacts.empty())
			set(gapApart(m_context, m_result.contacts, m_settings.tolerance, largestCover));
		else if (m_settings.distance)
			farApart(limit);
		else
			setNothingNear(m_settings, largestCover, m_result);
		m_inputOnly = m_inputOnly && largestCover == 0;
	}

	// Returns the largest cover_a + cover_b of the accepted pairs that are no contacts.
	double traverse(double limit, double tolerance)
	{
		const StopRule rule(m_context, m_settings.metric, limit, m_settings.paper);
		if (m_settings.budget.isLimited()) return refine(rule, tolerance);
		if (m_state.isOfLeaves != rule.isOfLeaves()) m_state.clearFronts();
		const bool sameRule =
			m_state.filled && m_state.threshold == rule.constantThreshold() && m_state.maxError == limit;
		const TraversalSettings settings{rule, tolerance, m_settings.paper, sameRule};
		ContactSink sink(m_context, tolerance, rule.isOfLeaves(), m_result.contacts, m_result.stats);
		m_result.stats.front = m_result.stats.frontInner = 0;
		Traversal<ContactSink>(m_context, settings, m_state.front, sink, m_result.stats).run();
		m_state.threshold = rule.constantThreshold();
		m_state.maxError = limit;
		m_state.isOfLeaves = rule.isOfLeaves();
		m_state.settings = m_settings;
		m_state.filled = true;
		return sink.largestCover();
	}

	// The same under a budget: best first, without the front.
	double refine(const StopRule& rule, double tolerance)
	{
		Refinement& walk = m_state.refinement;
		if (m_answered)
			walk.tighten(rule);
		else if (!m_state.planned)
			walk.start(m_context, rule, tolerance, m_settings.paper);
		if (m_answered || !m_state.planned) spend(walk, m_settings.budget, m_start, m_state.microsecondsPerAnswer);
		m_answered = true;
		m_refined = Clock::now();
		ContactSink sink(m_context, tolerance, false, m_result.contacts, m_result.stats);
		walk.answer(sink);
		m_state.settings = m_settings;
		m_state.filled = true;
		return sink.largestCover();
	}

	// Without a budget always. A planned query leaves the budget to its caller: it has none for a restart.
	bool paysForRestart() const
	{
		if (!m_settings.budget.isLimited()) return true;
		const Refinement& walk = m_state.refinement;
		const double cost = double(walk.costToTighten());
		return walk.isComplete() && !m_state.planned && double(walk.committed()) + cost <= m_settings.budget.tests &&
			   microsecondsSince(m_start) + m_state.microsecondsPerAnswer * cost <= m_settings.budget.microseconds;
	}
	bool rootIsApart() const
	{
		return m_settings.budget.isLimited() ? m_state.refinement.rootIsApart()
											 : m_state.front.entries[0].state == PairState::kSeparated;
	}

	static bool before(const Contact& l, const Contact& r)
	{
		return l.nodeA != r.nodeA ? l.nodeA < r.nodeA : l.nodeB < r.nodeB;
	}
	void sortPairs(std::vector<Contact>& contacts)
	{
		m_state.order.resize(contacts.size());
		for (std::uint32_t i = 0; i < contacts.size(); ++i) m_state.order[i] = i;
		std::sort(m_state.order.begin(), m_state.order.end(),
				  [&](std::uint32_t l, std::uint32_t r) { return before(contacts[l], contacts[r]); });
		m_state.unsorted.swap(contacts);
		contacts.clear();
		for (const std::uint32_t i : m_state.order) contacts.push_back(m_state.unsorted[i]);
	}
	void sortContacts()
	{
		sortPairs(m_result.contacts);
		m_inputOnly = true;
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

	void overlapping(bool hullsOverlap, double inside, double limit)
	{
		const PointBoxes counting(m_result.stats);
		if (hullsOverlap && m_settings.contactsOnly)
		{
			set({0, kInfinity, false});
			return;
		}
		const double radius = std::min(m_context.a.asset().radius, m_context.b.asset().radius);
		// The last per cent of a depth is not worth its cost, unless a hard limit asks for it.
		DepthAccuracy accuracy;
		accuracy.absolute = kDepthAccuracy * radius;
		if (m_settings.metric.maxError < kInfinity)
		{
			// A coarser answer could not be told from one deeper than the tolerance.
			const double coarse = std::min(0.5 * m_settings.metric.maxError, 0.2 * m_settings.tolerance);
			accuracy.absolute = std::max(accuracy.absolute, coarse);
			accuracy.relative = 0;
		}
		if (m_settings.distance) accuracy.cellLimit *= 10;
		if (hullsOverlap)
		{
			if (m_inputOnly || m_settings.metric.maxError < kInfinity)
				setDepth(nearDepth(m_result.contacts, m_settings.tolerance, accuracy), m_settings.tolerance, accuracy);
			else
				lookDeeper(limit, accuracy);
			if (!m_result.deep) return;
		}
		if (m_settings.distance)
		{
			const DepthBound whole = wholePenetration(m_context, accuracy, m_state.penetration, m_result.stats);
			set(gapBetween(-whole.upper, -whole.lower));
			m_result.deep = true;
			return;
		}
		if (!hullsOverlap) set({-inside, kInfinity, true});
	}

	// A depth that pairs of nodes within a tolerance do not prove: coarse depths are known to the accuracy only.
	double enoughAt(double tolerance, const DepthAccuracy& accuracy) const
	{
		return m_inputOnly ? tolerance : tolerance - accuracy.absolute;
	}
	// As far as pairs of nodes within a tolerance prove it.
	DepthBound nearDepth(const std::vector<Contact>& near, double tolerance, DepthAccuracy accuracy)
	{
		accuracy.enough = enoughAt(tolerance, accuracy);
		return nearPenetration(m_context, near, m_inputOnly, accuracy, m_state.penetration, m_result.stats);
	}
	void setDepth(const DepthBound& depth, double tolerance, const DepthAccuracy& accuracy)
	{
		if (m_inputOnly ? depth.upper < tolerance : depth.deepest < enoughAt(tolerance, accuracy))
			set(gapOverlapping(m_context, m_result.contacts, m_inputOnly, depth));
		else
			set({-depth.lower, kInfinity, true});
	}

	// Coarse hulls overlap by up to their deviations where the surfaces are apart: the depth is searched to a share of
	// them, among the contacts if that can prove it, else among the pairs within more. The contact list stays.
	void lookDeeper(double limit, DepthAccuracy accuracy)
	{
		double deviation = 0;
		for (const Contact& contact : m_result.contacts)
			if (contact.upper <= 0)
				deviation = std::max(deviation, double(m_context.a.node(contact.nodeA).deviation) +
													double(m_context.b.node(contact.nodeB).deviation));
		accuracy.absolute = std::max(accuracy.absolute, kDepthShare * deviation);
		for (const double share : {0.0, 0.6, 2.5})
		{
			const double tolerance = m_settings.tolerance + share * deviation;
			if (!(accuracy.absolute < tolerance)) continue;
			if (share > 0) traverseNear(limit, tolerance);
			setDepth(nearDepth(share > 0 ? m_state.near : m_result.contacts, tolerance, accuracy), tolerance, accuracy);
			if (!m_result.deep) return;
		}
	}

	// The pairs of nodes within a tolerance larger than that of the contacts.
	void traverseNear(double limit, double tolerance)
	{
		const StopRule rule(m_context, m_settings.metric, limit, m_settings.paper);
		NearPairs sink(m_context, tolerance, m_settings.tolerance, m_state.near, m_result.stats);
		m_state.near.clear();
		if (m_settings.budget.isLimited())
		{
			// As far as the budget went: what exceeds the metric by more than what is pending is open.
			Refinement& walk = m_state.nearby;
			walk.start(m_context, rule, tolerance, m_settings.paper);
			while (walk.excess() > m_state.refinement.excess()) walk.refine();
			walk.answer(sink);
		}
		else
		{
			const std::uint32_t front = m_result.stats.front, frontInner = m_result.stats.frontInner;
			const TraversalSettings settings{rule, tolerance, m_settings.paper, rule.hasConstantThreshold()};
			Traversal<NearPairs>(m_context, settings, m_state.front, sink, m_result.stats).run();
			m_result.stats.front = front;
			m_result.stats.frontInner = frontInner;
		}
		sortPairs(m_state.near);
		for (Contact& pair : m_state.near)
		{
			const auto known = std::lower_bound(m_result.contacts.begin(), m_result.contacts.end(), pair, before);
			if (known != m_result.contacts.end() && !before(pair, *known)) pair = *known;
		}
	}

	// Nothing within the tolerance: the closest accepted pair, then the certificate within its distance.
	void farApart(double limit)
	{
		const StopRule rule(m_context, m_settings.metric, limit, m_settings.paper);
		const double distance = closestDistance(m_context, rule, m_settings.paper, m_state.closest, m_result.stats);
		const double largestCover = traverse(limit, distance);
		sortContacts();
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
	bool m_answered = false;      // under a budget: once
	bool m_inputOnly = true;      // every accepted pair is of level 0: nothing finer exists
};
}  // namespace clod
