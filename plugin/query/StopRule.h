// SPDX-License-Identifier: Zlib
// When a pair of nodes answers, and which of its two nodes is opened when it may not. Both are fixed functions of the
// two nodes and the settings: no pose, no history. The set of pairs a query visits is then a function of the pose
// alone, whatever the order, and a larger threshold never opens more.
//
// Based on: Otaduy & Lin 2003, sec. 3.3, eq. 2 and 3. Departs from it: the contact area D of a pair is the harmonic
// combination of node constants, not interpolated at the witness points (outside paper mode there is no witness yet).
#pragma once
#include <algorithm>

#include "clod/query/Query.h"

namespace clod
{
// Largest error bound that a pair within the tolerance can cause (GapCertificate.h derives the terms):
// apart, cover and protrude; overlapping, half the width of the interval. Monotone to the roots.
inline double certifiedError(const Node& a, const Node& b)
{
	const auto sum = [](float x, float y) { return double(x) + double(y); };
	const double apart = std::max(sum(a.cover, b.cover), sum(a.protrude, b.protrude));
	const double below = std::max(sum(a.reach, b.surf), sum(b.reach, a.surf));
	const double proven = std::max(sum(b.reach, a.surf), sum(a.reach, b.surf));
	const double shallow = std::max(sum(b.reach, b.protrude), sum(a.reach, a.protrude)) + sum(a.protrude, b.protrude);
	return std::max(apart, 0.5 * (below + std::max(proven, shallow)));
}

class StopRule
{
public:
	// maxError replaces the one of the metric: restarts tighten it.
	StopRule(const Metric& metric, double maxError) : m_metric(metric), m_maxError(maxError) {}

	bool accepts(const Node& a, const Node& b) const
	{
		if (a.childCount == 0 && b.childCount == 0) return true;
		if (!(a.flags & b.flags & kClodNode) || m_metric.exact) return false;
		if (std::isfinite(m_metric.weightedDeviation) && !(weightedDeviation(a, b) <= m_metric.weightedDeviation))
			return false;
		return !std::isfinite(m_maxError) || certifiedError(a, b) <= m_maxError;
	}

	// s*_ab = max(f_a, f_b) / D_ab with 1 / D_ab = 1 / D_a + 1 / D_b (eq. 3).
	static double weightedDeviation(const Node& a, const Node& b)
	{
		const double volume = std::max(double(a.featureVolume), double(b.featureVolume));
		return volume > 0 ? volume * (1 / double(a.contactArea) + 1 / double(b.contactArea)) : 0;
	}

	// Precondition: the pair is not accepted. A leaf is never opened, a completion node first; then, where nodes may
	// answer, the one with the larger number of the metric; ties and the rest by size.
	bool opensA(const Hierarchy& a, std::uint32_t i, const Hierarchy& b, std::uint32_t j) const
	{
		const Node &nodeA = a.node(i), &nodeB = b.node(j);
		if (nodeA.childCount == 0) return false;
		if (nodeB.childCount == 0) return true;
		const bool clodA = (nodeA.flags & kClodNode) != 0, clodB = (nodeB.flags & kClodNode) != 0;
		if (clodA != clodB) return clodB;
		if (clodA && !m_metric.exact)
		{
			const bool volume = std::isfinite(m_metric.weightedDeviation);
			const float errorA = volume ? nodeA.featureVolume : nodeA.deviation;
			const float errorB = volume ? nodeB.featureVolume : nodeB.deviation;
			if (errorA != errorB) return errorA > errorB;
		}
		return a.cullBox(i).radius >= b.cullBox(j).radius;
	}

	bool followsSharedChildren() const { return !m_metric.exact; }

private:
	Metric m_metric;
	double m_maxError;
};
}  // namespace clod
