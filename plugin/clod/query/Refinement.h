// SPDX-License-Identifier: Zlib
// The walk of a query under a budget: first the coarsest valid answer, then refinements, the largest error first, one
// at a time, as long as the caller pays. Stopping at any moment leaves a valid answer.
//
// A refinement opens the pending pair that exceeds what the metric asks by the largest factor, s* / s0 or certified
// error over its limit (StopRule::excess). A pair counts for at most as much as the one it came from; then the factors
// of the pairs opened never rise, and at any moment those are opened that exceed the metric by more than some factor:
// what a smaller budget opens a larger one opens too. With nothing pending the accepted pairs are those of Traversal.cpp.
//
// Cost in tests (a box test or a hull distance each), known beforehand: every pair met costs one, a pair of contact
// nodes one more before it is opened, every pair that answers one more. committed() holds both, done or still to be
// done. Nothing is taken from a cache: costs, and what a budget of tests buys, are a function of pose and settings.
//
// Based on: Otaduy & Lin 2003, sec. 3.3 and 5.2 ("constant frame-rate"); Hubbard 1994 (time-critical collision
// detection).
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "clod/query/ContactSink.h"
#include "clod/query/StopRule.h"

namespace clod
{
class Refinement
{
public:
	// Opens what can never answer. The context must outlive the walk.
	void start(const QueryContext& context, const StopRule& rule, double tolerance)
	{
		m_context = &context;
		m_rule.emplace(rule);
		m_tolerance = tolerance;
		m_visited.clear();
		m_pending.clear();
		m_accepted.clear();
		m_boxTests = m_hullTests = m_opened = m_apart = 0;
		m_testsPerAnswer = context.longestMove > 0 ? 2 : 1;
		m_needed = 0;
		const std::uint32_t rootA = context.a.root();
		visit(true, context.b.root(), &rootA, 1, kOff);
		m_rootIsApart = m_pending.empty() && m_accepted.empty();
		while (!m_pending.empty() && m_pending.front().deviation == kOff) refine();
	}

	const StopRule& rule() const { return *m_rule; }  // after start()
	bool isComplete() const { return m_pending.empty(); }
	bool rootIsApart() const { return m_rootIsApart; }
	// By which factor the worst pending pair exceeds the metric; 0: none is pending.
	double excess() const { return m_pending.empty() ? 0 : m_pending.front().excess; }
	double deviation() const { return m_pending.empty() ? 0 : m_pending.front().deviation; }  // its s*
	std::uint64_t committed() const { return tests() + m_testsPerAnswer * answers(); }
	std::uint64_t tests() const { return m_boxTests + m_hullTests; }
	// Any budget of at least this many tests would have refined as far.
	std::uint64_t needed() const { return std::max(m_needed, committed()); }
	std::size_t answers() const { return m_pending.size() + m_accepted.size(); }
	// The most that committed() grows by the next refinement. Precondition: not complete.
	std::uint64_t cost() const
	{
		const std::uint64_t children = sideOf(m_pending.front()).node->childCount;
		return std::uint64_t(comparesHulls(m_pending.front())) + children + m_testsPerAnswer * (children - 1);
	}

	// Precondition: not complete.
	void refine()
	{
		m_needed = std::max(m_needed, committed() + cost());
		const Pending worst = m_pending.front();
		std::pop_heap(m_pending.begin(), m_pending.end());
		m_pending.pop_back();
		if (m_rule->acceptance(worst.a, worst.b) == Acceptance::kWhileApart)
		{
			++m_hullTests;
			if (canonicallyApart(*m_context, worst.a, worst.b))
			{
				m_accepted.push_back({worst.a, worst.b});
				return;
			}
		}
		else if (cullsByHulls(worst) && hullsApart(worst))
		{
			++m_apart;
			return;
		}
		++m_opened;
		const Side side = sideOf(worst);
		const Span<std::uint32_t> children = side.hierarchy->children(*side.node);
		for (std::uint32_t i = 0; i < side.node->childCount; i += kBoxLanes)
			visit(side.isA, side.isA ? worst.b : worst.a, children.data + i,
				  std::min(kBoxLanes, side.node->childCount - i), worst.excess);
	}

	// Hands every pair that answers now to the sink; those it evaluates count in the sink's statistics.
	void answer(ContactSink& sink) const
	{
		const auto hand = [&](std::uint32_t a, std::uint32_t b)
		{
			CachedSeparation unknown;
			sink.answer(a, b, unknown);
		};
		for (const NodePair& pair : m_accepted) hand(pair.a, pair.b);
		for (const Pending& pair : m_pending) hand(pair.a, pair.b);
	}
	// Adds what the walk itself has done.
	void addTo(QueryStats& stats) const
	{
		stats.boxTests += m_boxTests;
		stats.hullTests += m_hullTests;
		stats.front = std::uint32_t(answers()) + m_apart;
		stats.frontInner = m_opened;
		stats.pending = std::uint32_t(m_pending.size());
		stats.needed = needed();
	}

private:
	struct NodePair
	{
		std::uint32_t a, b;
	};
	struct Pending
	{
		std::uint32_t a, b;
		double excess, deviation;
		// For a heap whose front is the worst; ties by s*, then by index, so that the order is one.
		bool operator<(const Pending& other) const
		{
			if (excess != other.excess) return excess < other.excess;
			if (deviation != other.deviation) return deviation < other.deviation;
			return a != other.a ? a > other.a : b > other.b;
		}
	};
	struct Side
	{
		bool isA;
		const Hierarchy* hierarchy;
		const Node* node;
	};

	Side sideOf(const Pending& pair) const
	{
		const bool isA = m_rule->opensA(pair.a, pair.b);
		const Hierarchy& hierarchy = isA ? m_context->a : m_context->b;
		return {isA, &hierarchy, &hierarchy.node(isA ? pair.a : pair.b)};
	}

	bool comparesHulls(const Pending& pair) const
	{
		return cullsByHulls(pair) || m_rule->acceptance(pair.a, pair.b) == Acceptance::kWhileApart;
	}
	// As Traversal.cpp does before a pair is opened.
	bool cullsByHulls(const Pending& pair) const
	{
		return !m_rule->base().isUsed() &&
			   mayCullByHulls(m_context->a.node(pair.a), m_context->b.node(pair.b));
	}
	bool hullsApart(const Pending& pair)
	{
		++m_hullTests;
		const double limit = cullLimit(m_context->a.node(pair.a), m_context->b.node(pair.b), m_tolerance);
		return canonicalSweptBound(*m_context, pair.a, pair.b, limit, limit).lower > limit;
	}

	// Pairs of `other` and nodes of the other body, of A or not.
	void visit(bool areOfA, std::uint32_t other, const std::uint32_t* nodes, std::uint32_t count, double largest)
	{
		m_visited.reserve(count);
		std::uint32_t met[kBoxLanes], fresh = 0;
		for (std::uint32_t i = 0; i < count; ++i)
			if (m_visited.insert(areOfA ? nodes[i] : other, areOfA ? other : nodes[i])) met[fresh++] = nodes[i];
		if (fresh == 0) return;
		m_boxTests += fresh;
		float separations[kBoxLanes];
		boxSeparations(*m_context, areOfA, other, met, fresh, separations);
		for (std::uint32_t i = 0; i < fresh; ++i)
		{
			const std::uint32_t a = areOfA ? met[i] : other, b = areOfA ? other : met[i];
			if (double(separations[i]) > m_tolerance)
				++m_apart;
			else
				keep(a, b, largest);
		}
	}

	void keep(std::uint32_t a, std::uint32_t b, double largest)
	{
		if (m_rule->acceptance(a, b) == Acceptance::kYes)
		{
			m_accepted.push_back({a, b});
			return;
		}
		Pending pair{a, b, kOff, kOff};  // what can never answer comes first
		if (m_rule->mayAnswer(a, b))
		{
			pair.excess = std::min(largest, m_rule->excess(a, b));
			const double deviation = StopRule::weightedDeviation(m_context->a.node(a), m_context->b.node(b));
			pair.deviation = std::min(deviation, std::numeric_limits<double>::max());
		}
		m_pending.push_back(pair);
		std::push_heap(m_pending.begin(), m_pending.end());
	}

	const QueryContext* m_context = nullptr;
	std::optional<StopRule> m_rule;
	double m_tolerance = 0;
	bool m_rootIsApart = true;
	VisitedPairs m_visited;
	std::vector<Pending> m_pending;  // a heap
	std::vector<NodePair> m_accepted;
	std::uint64_t m_testsPerAnswer = 1, m_needed = 0;
	std::uint32_t m_boxTests = 0, m_hullTests = 0, m_opened = 0, m_apart = 0;
};
}  // namespace clod
