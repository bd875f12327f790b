// SPDX-License-Identifier: Zlib
// When a pair of nodes answers, and which of its two nodes is opened when it may not. The latter is a fixed function of
// the two nodes and the settings; the former too, unless a metric asks for the place of the contact (Metric.h) or a
// certified limit holds only while the two hulls are apart, then of the pose as well: no history. The set of pairs a
// query visits is a function of the pose and the settings alone, whatever the order, and a larger threshold s0 never
// opens more.
//
// Based on: Otaduy & Lin 2003, sec. 3.3, eq. 2 and 3. Departs from it: the contact area D of a pair is the harmonic
// combination of node constants, not interpolated at the witness points (there is no witness yet).
#pragma once
#include <algorithm>
#include <limits>

#include "clod/query/Constants.h"
#include "clod/query/QueryContext.h"

namespace clod
{
inline double sumOf(float a, float b)
{
	return double(a) + double(b);
}
// Largest error bound that a pair within the tolerance can cause (GapCertificate.h derives the terms). Monotone to the
// roots. While its hulls are apart: cover and protrude.
inline double certifiedErrorApart(const Node& a, const Node& b)
{
	return std::max(sumOf(a.cover, b.cover), sumOf(a.protrude, b.protrude));
}
// Overlapping or not: half the width of the interval in which the depth of what the two stand for lies counts as well,
// going by their real faces, which are within reach of O(n) and within surf of the surface.
inline double certifiedError(const Node& a, const Node& b)
{
	const double below = std::max(sumOf(a.reach, b.surf), sumOf(b.reach, a.surf));
	const double shallow =
		std::max(sumOf(b.reach, b.protrude), sumOf(a.reach, a.protrude)) + sumOf(a.protrude, b.protrude);
	return std::max(certifiedErrorApart(a, b), 0.5 * (below + std::max(below, shallow)));
}

// Whether a pair of nodes answers.
enum class Acceptance : std::uint8_t
{
	kNo,
	kWhileApart,  // where its hulls do not overlap; such a pair is not culled by its hulls
	kYes
};

class StopRule
{
public:
	StopRule(const QueryContext& context, const Metric& metric)
		: m_context(&context),
		  m_finest(finest(context)),
		  m_threshold(thresholdOf(context, metric)),
		  m_isExact(metric.exact && !(metric.coarsening > 1)),
		  m_maxError(isCoarsest(metric) ? kOff : coarsened(metric.exact ? 0 : metric.maxError, metric, m_finest)),
		  m_leavesOfA(context.a.levels()[0].nodeCount),
		  m_leavesOfB(context.b.levels()[0].nodeCount),
		  m_base(baseLevels(metric))
	{
		if (m_base.isUsed())  // 0 of input surfaces
			m_baseCover = sumOf(context.tablesA.bounds(m_base.a).cover, context.tablesB.bounds(m_base.b).cover);
	}

	// The levels that keep a certified limit (TraversalTables.h); in exact mode the input surfaces. A front is of one pair
	// of base levels, or of none.
	const BaseLevels& base() const { return m_base; }
	bool isOfLeaves() const { return m_base.isOfLeaves(); }
	// Neither of the two nodes is above the base levels; so it is with any two where there are none.
	bool isWithinBase(std::uint32_t i, std::uint32_t j) const
	{
		return !m_base.isUsed() || (isWithinBaseA(i) && isWithinBaseB(j));
	}
	// The box of a node above the base holds the hulls of all its descendants, but of the surface only what the node
	// itself answers for; the rest is within the cover of a base level's hull. Surfaces of a pair that is culled may
	// therefore be nearer than its boxes, by no more than this.
	double baseCover() const { return m_baseCover; }

	Acceptance acceptance(std::uint32_t i, std::uint32_t j) const
	{
		// Leaves are told by their indices: their nodes need not be read.
		if (i < m_leavesOfA && j < m_leavesOfB) return Acceptance::kYes;
		if (m_base.isOfLeaves() || !isWithinBase(i, j)) return Acceptance::kNo;
		const Node &a = m_context->a.node(i), &b = m_context->b.node(j);
		if (!mayAnswer(i, j) || !isWithinThreshold(i, j)) return Acceptance::kNo;
		if (!dependsOnHulls()) return Acceptance::kYes;
		if (certifiedErrorApart(a, b) > m_maxError) return Acceptance::kNo;
		if (certifiedError(a, b) <= m_maxError) return Acceptance::kYes;
		return Acceptance::kWhileApart;
	}
	bool dependsOnHulls() const { return std::isfinite(m_maxError); }
	double maxError() const { return m_maxError; }

	// At some coarsening: any pair of contact levels.
	bool mayAnswer(std::uint32_t i, std::uint32_t j) const
	{
		return (m_context->a.node(i).flags & m_context->b.node(j).flags & kClodNode) != 0;
	}
	// By which factor a pair exceeds what the metric asks for: s* / s0 (the paper's priority), or the certified error over
	// its limit, which is kFinestShare where it is less. 0: by none, else at least 1.
	double excess(std::uint32_t i, std::uint32_t j, bool isApart) const
	{
		if (i < m_leavesOfA && j < m_leavesOfB && m_context->hasInput()) return 0;
		const Node &a = m_context->a.node(i), &b = m_context->b.node(j);
		const auto factor = [this](double error, double limit)
		{ return error > limit ? std::max(1.0, error / std::max(limit, m_finest)) : 0; };
		return std::max(factor(weightedDeviation(a, b), thresholdOf(i, j)),
						factor(isApart ? certifiedErrorApart(a, b) : certifiedError(a, b), m_isExact ? 0 : m_maxError));
	}

	// What a front was made with: equal constants and maxError make equal rules. Not a number where the place counts.
	double constantThreshold() const
	{
		return m_threshold.isConstant() ? m_threshold.constant() : std::numeric_limits<double>::quiet_NaN();
	}

	// The rule of the input surfaces.
	static StopRule ofLeaves(const QueryContext& context)
	{
		Metric exact;
		exact.exact = true;
		return StopRule(context, exact);
	}
	// The same rule, but for one threshold everywhere. Precondition: this one sets a threshold, or `s0` is kOff.
	StopRule with(double s0) const
	{
		StopRule rule = *this;
		rule.m_threshold = Threshold(s0);
		return rule;
	}

	// Between which thresholds s0 all pairs of nodes are judged at this pose: infinite only where none is set.
	ThresholdRange thresholds() const { return rangeOf(*m_context, m_threshold); }
	static ThresholdRange thresholds(const QueryContext& context, const Metric& metric)
	{
		return rangeOf(context, thresholdOf(context, metric));
	}

	// s*_ab = max(f_a, f_b) / D_ab with 1 / D_ab = 1 / D_a + 1 / D_b (eq. 3).
	static double weightedDeviation(const Node& a, const Node& b)
	{
		const double volume = std::max(double(a.featureVolume), double(b.featureVolume));
		return volume > 0 ? volume * (1 / double(a.contactArea) + 1 / double(b.contactArea)) : 0;
	}

	// Precondition: not a pair of leaves. A leaf is never opened, nor one within the base beside one above it, a
	// completion node first; then, where nodes may answer, the one with the larger number of the metric; ties and the
	// rest by size.
	bool opensA(std::uint32_t i, std::uint32_t j) const
	{
		const Node &nodeA = m_context->a.node(i), &nodeB = m_context->b.node(j);
		if (nodeA.childCount == 0) return false;
		if (nodeB.childCount == 0) return true;
		const bool clodA = (nodeA.flags & kClodNode) != 0, clodB = (nodeB.flags & kClodNode) != 0;
		if (clodA != clodB) return clodB;
		const bool isAbove = !isWithinBase(i, j);
		if (isAbove && isWithinBaseA(i) != isWithinBaseB(j)) return isWithinBaseB(j);
		if (clodA && !isAbove && !m_base.isOfLeaves())
		{
			const bool volume = !m_threshold.isConstant() || m_threshold.constant() < kOff;
			const float errorA = volume ? nodeA.featureVolume : nodeA.deviation;
			const float errorB = volume ? nodeB.featureVolume : nodeB.deviation;
			if (errorA != errorB) return errorA > errorB;
		}
		return m_context->a.cullBox(i).radius >= m_context->b.cullBox(j).radius;
	}

	// What stands for a node that is opened.
	Span<std::uint32_t> childrenOf(bool isOfA, std::uint32_t index) const
	{
		const Hierarchy& side = isOfA ? m_context->a : m_context->b;
		const Node& node = side.node(index);
		const std::uint32_t base = isOfA ? m_base.a : m_base.b;
		if (base == kNone || node.level <= base) return side.children(node);
		return (isOfA ? m_context->tablesA : m_context->tablesB).collapsedChildren(index, base);
	}

private:
	bool isWithinBaseA(std::uint32_t i) const { return m_context->a.node(i).level <= m_base.a; }
	bool isWithinBaseB(std::uint32_t j) const { return m_context->b.node(j).level <= m_base.b; }

	// Does no threshold ask for finer nodes here and there?
	bool isAlone() const { return m_threshold.isConstant() && !(m_threshold.constant() < kOff); }
	// Coarsened without end, or so far that the coarsest answer errs by less.
	bool isCoarsest(const Metric& metric) const
	{
		const double asked = metric.exact ? 0 : metric.maxError, limit = coarsened(asked, metric, m_finest);
		return metric.coarsening == kOff || (isAlone() && asked < kOff && limit > std::max(asked, coarsest()));
	}
	double coarsest() const { return kCoarsestShare / kFinestShare * m_finest; }
	BaseLevels baseLevels(const Metric& metric) const
	{
		if (m_isExact) return {0, 0};
		// No limit of the rule, which is then kept without a look at the hulls: where they overlap it may err by more.
		if (isCoarsest(metric)) return chooseBaseLevels(m_context->tablesA, m_context->tablesB, coarsest(), true);
		if (!std::isfinite(m_maxError)) return {};
		return chooseBaseLevels(m_context->tablesA, m_context->tablesB, m_maxError, isAlone());
	}
	bool isWithinThreshold(std::uint32_t i, std::uint32_t j) const
	{
		const double s0 = thresholdOf(i, j);
		return !(s0 < kOff) || weightedDeviation(m_context->a.node(i), m_context->b.node(j)) <= s0;
	}
	double thresholdOf(std::uint32_t i, std::uint32_t j) const
	{
		return m_threshold.isConstant() ? m_threshold.constant() : m_threshold.at(placeOf(i, j));
	}
	// The ball round the smaller culling box: it holds the hull of its node, hence a witness point of every contact.
	Place placeOf(std::uint32_t i, std::uint32_t j) const
	{
		const OrientedBox &a = m_context->a.cullBox(i), &b = m_context->b.cullBox(j);
		const bool isA = a.radius <= b.radius;
		const OrientedBox& box = isA ? a : b;
		return {isA ? centerOf(box) : m_context->pose.apply(centerOf(box)), double(box.radius)};
	}
	// The places: no node's centre is beyond the radius of its body, nor its ball wider than what is within.
	static ThresholdRange rangeOf(const QueryContext& context, const Threshold& threshold)
	{
		if (threshold.isConstant()) return {threshold.constant(), threshold.constant()};
		const ThresholdRange ofA = threshold.within({Vec3{}, 3 * context.radiusA});
		const ThresholdRange ofB = threshold.within({context.pose.translation, 3 * context.radiusB});
		return {std::min(ofA.least, ofB.least),
				std::min(std::max(ofA.most, ofB.most), std::numeric_limits<double>::max())};
	}
	static double finest(const QueryContext& context)
	{
		return kFinestShare * double(std::min(context.a.asset().radius, context.b.asset().radius));
	}
	static Threshold thresholdOf(const QueryContext& context, const Metric& metric)
	{
		return Threshold(metric, fastest(context, metric), finest(context));
	}
	static double fastest(const QueryContext& context, const Metric& metric)
	{
		const Vec3 &linear = metric.velocity.linear, &angular = metric.velocity.angular;
		const double turning = length(angular);
		return std::max(length(linear) + turning * context.radiusA,
						length(linear + cross(angular, context.pose.translation)) + turning * context.radiusB);
	}

	const QueryContext* m_context;
	double m_finest;
	Threshold m_threshold;
	bool m_isExact;
	double m_maxError;
	std::uint32_t m_leavesOfA, m_leavesOfB;  // the first nodes
	BaseLevels m_base;
	double m_baseCover = 0;
};
}  // namespace clod
