// SPDX-License-Identifier: Zlib
// Depth-first branch and bound on the distance, the nearest child first.
#include "clod/query/ClosestPair.h"

#include <algorithm>
#include <limits>

namespace clod
{
namespace
{
class ClosestPairSearch
{
public:
	ClosestPairSearch(const QueryContext& context, const StopRule& rule, bool paper, ClosestPairScratch& scratch,
					  QueryStats& stats)
		: m_context(context), m_rule(rule), m_paper(paper), m_scratch(scratch), m_stats(stats)
	{
	}

	double run()
	{
		m_scratch.stack.clear();
		const std::uint32_t rootA = m_context.a.root();
		push(true, m_context.b.root(), &rootA, 1, 0);
		while (!m_scratch.stack.empty())
		{
			const ClosestPairScratch::Candidate top = m_scratch.stack.back();
			m_scratch.stack.pop_back();
			if (top.separation > m_best) continue;
			if (m_rule.accepts(top.a, top.b))
				measure(top);
			else
				open(top);
		}
		return m_best;
	}

private:
	void open(const ClosestPairScratch::Candidate& pair)
	{
		const std::uint32_t a = pair.a, b = pair.b;
		const bool opensA = m_rule.opensA(a, b);
		const Hierarchy& side = opensA ? m_context.a : m_context.b;
		const Node& node = side.node(opensA ? a : b);
		const std::uint32_t count = m_rule.followsSharedChildren() ? node.childCount : node.primaryChildCount;
		const std::size_t first = m_scratch.stack.size();
		for (std::uint32_t i = 0; i < count; i += kBoxLanes)
			push(opensA, opensA ? b : a, side.children(node).data + i, std::min(kBoxLanes, count - i), pair.separation);
		std::sort(m_scratch.stack.begin() + std::ptrdiff_t(first), m_scratch.stack.end(),
				  [](const auto& l, const auto& r) { return l.separation > r.separation; });
	}

	// Pairs of `other` and nodes of the other body, of A or not.
	void push(bool areOfA, std::uint32_t other, const std::uint32_t* nodes, std::uint32_t count, double above)
	{
		m_stats.boxTests += count;
		const Hierarchy &side = areOfA ? m_context.a : m_context.b, &otherSide = areOfA ? m_context.b : m_context.a;
		const CullBox* boxes[kBoxLanes];
		for (std::uint32_t i = 0; i < count; ++i) boxes[i] = &side.cullBox(nodes[i]);
		float separations[kBoxLanes];
		if (!m_paper) boxSeparations(m_context.boxes, otherSide.cullBox(other), !areOfA, boxes, count, separations);
		for (std::uint32_t i = 0; i < count; ++i)
		{
			const std::uint32_t a = areOfA ? nodes[i] : other, b = areOfA ? other : nodes[i];
			const double separation = m_paper ? paperSeparation(m_context, a, b, m_best) : double(separations[i]);
			if (separation <= m_best) m_scratch.stack.push_back({std::max(above, separation), a, b});
		}
	}

	void measure(const ClosestPairScratch::Candidate& pair)
	{
		++m_stats.hullTests;
		const HullDistance distance = canonicalDistance(m_context, pair.a, pair.b, m_best);
		if (distance.lower <= m_best) m_best = std::min(m_best, std::max(pair.separation, distance.upper));
	}

	const QueryContext& m_context;
	const StopRule& m_rule;
	const bool m_paper;
	ClosestPairScratch& m_scratch;
	QueryStats& m_stats;
	double m_best = std::numeric_limits<double>::infinity();
};
}  // namespace

double closestDistance(const QueryContext& context, const StopRule& rule, bool paper, ClosestPairScratch& scratch,
					   QueryStats& stats)
{
	return ClosestPairSearch(context, rule, paper, scratch, stats).run();
}
}  // namespace clod
