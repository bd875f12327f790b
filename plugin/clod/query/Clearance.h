// SPDX-License-Identifier: Zlib
// Two bodies that are apart: how much they may move before they have to be looked at again. While it lasts a query
// costs the bound of the motion, whatever the hierarchies hold.
//
// The front's own bounds cannot tell: a traversal stops where boxes are beyond the tolerance, hence some always are
// just beyond it. The search for the nearest pair (ClosestPair.h) costs about a fresh traversal, so one that was used
// up after few queries is not made again at once.
//
// Based on: conservative advancement (Mirtich 1996).
#pragma once
#include <algorithm>

#include "clod/query/ClosestPair.h"
#include "clod/query/InsideTest.h"
#include "clod/collide/MotionBound.h"
#include "clod/query/Patience.h"

namespace clod
{
class Clearance
{
public:
	void forget() { *this = Clearance{}; }

	// Nothing is near still: not at these settings, nor at thresholds such as theirs, from where the search was made to
	// this pose, whatever the way between.
	bool holds(const QueryContext& context, const Settings& settings)
	{
		if (!m_isKnown || !isMeantFor(settings)) return false;
		const double motion = motionBound(m_pose, context.pose, context.reachA, context.reachB);
		const double change =
			sweepChange(m_pose, m_settings.sweep, context.pose, context.sweep, motion, context.reachB);
		if (!(motion + change + room(context, settings) < m_motion)) return false;
		if (!isWithinThresholds(context, settings.metric)) return false;
		++m_uses;
		return true;
	}
	// What a query adds to the tolerance while it holds, see setNothingNear.
	double largestCover() const { return m_largestCover; }

	// After a traversal that found nothing. lastMove: motion and change of the sweep since the query before.
	struct Tools
	{
		ClosestPairScratch& scratch;
		InsideProbes &probesA, &probesB;
		QueryStats& stats;
	};
	void seek(const QueryContext& context, const Settings& settings, double lastMove, const Tools& tools)
	{
		const bool isPlain = !settings.paper && !settings.distance && !settings.budget.isLimited();
		if (!isPlain) return;
		if (m_isKnown) m_uses < kWorthwhile ? m_patience.fail() : m_patience.succeed();
		m_isKnown = false;
		m_uses = 0;
		if (!m_patience.isOver()) return;
		const double cap = lastMove > 0 ? kFarthest * lastMove : settings.tolerance;
		m_motion = motionToGo(context, settings, cap, tools);
		if (m_motion > 0) m_motion = std::min(m_motion, outside(context, tools));
		m_pose = context.pose;
		m_settings = settings;
		m_isKnown = true;
	}

private:
	static constexpr std::uint32_t kWorthwhile = 4;     // queries that a search should save
	static constexpr std::uint32_t kMostPatience = 63;  // queries until the next search
	static constexpr double kFarthest = 64;             // moves: what is farther is not looked for
	static constexpr double kSpan = 2;                  // thresholds of later queries: so many times these

	// Thresholds that change with pose, motion and camera: before a contact by any of those near the present ones.
	// Where the gap is asked for, before a query would prove anything else of it.
	double motionToGo(const QueryContext& context, const Settings& settings, double cap, const Tools& tools)
	{
		Metric metric = settings.metric;
		const StopRule rule(context, metric, false);
		m_thresholds = StopRule::thresholds(context, metric);
		if (dependsOnPose(metric) && m_thresholds.most < kOff)
		{
			m_thresholds.least /= kSpan;
			m_thresholds.most = std::min(kSpan * m_thresholds.most, std::numeric_limits<double>::max());
		}
		metric.velocity = VelocityThreshold{};
		metric.view = ViewThreshold{};
		metric.own = nullptr;
		metric.combine = Combine::kStrict;
		metric.weightedDeviation = m_thresholds.least;
		const StopRule strict(context, metric, false);
		metric.weightedDeviation = m_thresholds.most;
		const StopRule relaxed(context, metric, false);
		const ClearOf contacts{strict, relaxed, settings.tolerance, !settings.contactsOnly && !rule.base().isUsed()};
		double motion = clearMotion(context, contacts, cap, tools.scratch, tools.stats);
		m_largestCover = rule.baseCover();
		if (settings.contactsOnly || m_largestCover <= settings.gapError) return motion;
		// The surfaces are asked, see Evaluation.h.
		m_largestCover = 0;
		Metric leaves;
		leaves.exact = true;
		const StopRule exact(context, leaves, false);
		if (motion > 0)
			motion =
				clearMotion(context, {exact, exact, settings.tolerance, false}, motion, tools.scratch, tools.stats);
		return motion;
	}
	bool isWithinThresholds(const QueryContext& context, const Metric& metric) const
	{
		if (metric.exact || (!dependsOnPose(metric) && same(metric, m_settings.metric))) return true;
		const ThresholdRange now = StopRule::thresholds(context, metric);
		return (now.most < kOff) == (m_thresholds.most < kOff) && now.least >= m_thresholds.least &&
			   now.most <= m_thresholds.most;
	}
	static bool dependsOnPose(const Metric& metric)
	{
		return metric.velocity.time < kOff || metric.view.pixels < kOff || metric.own;
	}

	// Coarse hulls may be apart where surfaces meet: how far neither body, nor a component of it, comes to lie in the
	// other.
	static double outside(const QueryContext& context, const Tools& tools)
	{
		const Transform aFromB{context.pose.rotation, context.pose.translation};
		tools.probesA.prepare(context.a);
		tools.probesB.prepare(context.b);
		return std::min(tools.probesA.distanceOutside(context.b, inverse(aFromB), tools.stats),
						tools.probesB.distanceOutside(context.a, aFromB, tools.stats));
	}
	bool isMeantFor(const Settings& settings) const
	{
		return settings.metric.exact == m_settings.metric.exact &&
			   settings.metric.maxError == m_settings.metric.maxError && settings.tolerance <= m_settings.tolerance &&
			   settings.contactsOnly == m_settings.contactsOnly && settings.gapError == m_settings.gapError &&
			   !settings.paper && !settings.distance && !settings.budget.isLimited();
	}
	// For the rounding of the search and of what a traversal would compute now.
	static double room(const QueryContext& context, const Settings& settings)
	{
		return 2 * (1e-9 * context.size + context.boxes.roundingOfTwo()) +
			   10 * kHullDistanceAccuracy * (context.size + settings.tolerance) + 4 * context.pose.rounding;
	}

	bool m_isKnown = false;
	Settings m_settings;
	RelativePose m_pose;
	double m_motion = 0;  // from there, what uses it up
	ThresholdRange m_thresholds{0, 0};
	double m_largestCover = 0;
	std::uint32_t m_uses = 0;
	Patience m_patience{kMostPatience};
};
}  // namespace clod
