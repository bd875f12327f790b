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
		if (m_scratch.lastA != kNone && m_rule.accepts(nodeA(m_scratch.lastA), nodeB(m_scratch.lastB)))
			measure(m_scratch.lastA, m_scratch.lastB);
		push(m_context.a.root(), m_context.b.root());
		while (!m_scratch.stack.empty())
		{
			const ClosestPairScratch::Candidate top = m_scratch.stack.back();
			m_scratch.stack.pop_back();
			if (top.separation > m_best) continue;
			if (m_rule.accepts(nodeA(top.a), nodeB(top.b)))
				measure(top.a, top.b);
			else
				open(top.a, top.b);
		}
		return m_best;
	}

private:
	const Node& nodeA(std::uint32_t a) const { return m_context.a.node(a); }
	const Node& nodeB(std::uint32_t b) const { return m_context.b.node(b); }

	void open(std::uint32_t a, std::uint32_t b)
	{
		const bool opensA = m_rule.opensA(m_context.a, a, m_context.b, b);
		const Hierarchy& side = opensA ? m_context.a : m_context.b;
		const Node& node = side.node(opensA ? a : b);
		const std::uint32_t count = m_rule.followsSharedChildren() ? node.childCount : node.primaryChildCount;
		const std::size_t first = m_scratch.stack.size();
		for (std::uint32_t i = 0; i < count; ++i)
		{
			const std::uint32_t child = side.children(node)[i];
			opensA ? push(child, b) : push(a, child);
		}
		std::sort(m_scratch.stack.begin() + std::ptrdiff_t(first), m_scratch.stack.end(),
				  [](const auto& l, const auto& r) { return l.separation > r.separation; });
	}

	void push(std::uint32_t a, std::uint32_t b)
	{
		++m_stats.boxTests;
		const double separation =
			m_paper ? paperSeparation(m_context, a, b, m_best)
					: boxSeparation(placeInA(m_context.a.cullBox(a)), placeInA(m_context.b.cullBox(b), m_context.pose));
		if (separation <= m_best) m_scratch.stack.push_back({separation, a, b});
	}

	void measure(std::uint32_t a, std::uint32_t b)
	{
		++m_stats.hullTests;
		const HullDistance distance = canonicalDistance(m_context, a, b, m_best);
		if (distance.lower > m_best || distance.upper >= m_best) return;
		m_best = distance.upper;
		m_scratch.lastA = a;
		m_scratch.lastB = b;
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
