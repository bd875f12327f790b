// SPDX-License-Identifier: Zlib
// The one walk over two hierarchies. Given a stop rule and a sink it visits the pairs of nodes whose culling volumes
// are within the tolerance, from the roots down and level of the walk by level, and hands every accepted one to the
// sink.
//
// What the cache may decide: a pair's separation is 1-Lipschitz in the relative motion (BoxSeparation.h), so a value
// measured once, less the motion since, proves that it is beyond the tolerance still, and plus the motion that it is
// within, each with some room for rounding. Everything else is measured anew. Both proofs decide as a measurement
// would, hence the set of visited pairs never depends on the cache.
//
// Outside exact and paper mode a pair of contact nodes that is not accepted is opened only where its hulls, too, are
// near: boxes of curved patches are far from tight.
//
// Exact mode follows primary children only: a tree, each pair once. Otherwise all children: a directed acyclic graph,
// each pair is opened where it is met first.
#pragma once
#include <algorithm>
#include <vector>

#include "clod/query/BoxSeparation.h"
#include "clod/query/HullCull.h"
#include "clod/query/StopRule.h"

namespace clod
{
struct TraversalSettings
{
	StopRule rule;
	double tolerance = 0;
	bool paper = false;     // cull by hull distance - h_a - h_b instead of culling boxes (paper eq. 1)
	bool sameRule = false;  // the stop rule is that of the cached front: its states hold
};

// Sink: bool skips(const FrontEntry& pair, const HullMemory& memory) - an accepted pair needs nothing: its boxes are
//         not even compared;
//       void answer(const FrontEntry& pair, HullMemory& memory)      - an accepted pair within the tolerance by its
//         culling volumes.
template <class Sink>
class Traversal
{
public:
	Traversal(const QueryContext& context, const TraversalSettings& settings, PairFront& front, Sink& sink,
			  QueryStats& stats)
		: m_context(context),
		  m_settings(settings),
		  m_front(front),
		  m_sink(sink),
		  m_room(1e-9 * context.size + boxRounding(context.size)),
		  m_moved(float(front.pending) * (1 + 3e-7f)),
		  m_stats(&stats),
		  m_hulls(context, stats)
	{
	}

	void run()
	{
		std::swap(m_front.entries, m_front.previous);
		std::swap(m_front.hulls, m_front.previousHulls);
		m_front.entries.clear();
		m_front.hulls.clear();
		m_front.visited.clear();
		m_front.pending = 0;
		Opened none;
		m_front.entries.push_back({m_context.a.root(), m_context.b.root(), kNone, kNone, 0, 0, 0, 0,
								   m_front.previous.empty() ? kNone : 0, PairState::kSeparated});
		visit(m_front.entries[0], none);
		for (std::uint32_t i = 0; i < m_front.entries.size(); ++i)
		{
			const PairState state = m_front.entries[i].state;
			if (state == PairState::kOpenA || state == PairState::kOpenB) open(i);
		}
		m_stats->touchedFinestLevel = std::min(levelOf(m_context.a, m_finestA), levelOf(m_context.b, m_finestB));
	}

private:
	// A pair that is being opened.
	struct Opened
	{
		bool opensA = false;
		bool placed = false;  // box is set
		PlacedBox box;        // of the node that is not opened
	};

	void open(std::uint32_t index)
	{
		const FrontEntry pair = m_front.entries[index];
		Opened opened;
		opened.opensA = pair.state == PairState::kOpenA;
		const Hierarchy& side = opened.opensA ? m_context.a : m_context.b;
		const Node& node = side.node(opened.opensA ? pair.a : pair.b);
		const bool shared = m_settings.rule.followsSharedChildren();
		const std::uint32_t count = shared ? node.childCount : node.primaryChildCount;
		const std::uint32_t* children = side.children(node).data;
		for (std::uint32_t k = 0; k < count; ++k) __builtin_prefetch(&side.cullBox(children[k]));

		std::uint32_t old = 0, oldEnd = 0;
		if (pair.old != kNone && m_front.previous[pair.old].state == pair.state)
		{
			old = m_front.previous[pair.old].link;
			oldEnd = old + m_front.previous[pair.old].childCount;
		}
		std::vector<FrontEntry>& entries = m_front.entries;
		const std::uint32_t first = std::uint32_t(entries.size());
		entries.resize(first + count);
		if (shared) m_front.visited.reserve(count);
		FrontEntry* next = entries.data() + first;
		for (std::uint32_t k = 0; k < count; ++k)
		{
			const std::uint32_t a = opened.opensA ? children[k] : pair.a, b = opened.opensA ? pair.b : children[k];
			if (shared && !m_front.visited.insert(a, b)) continue;
			while (old < oldEnd && m_front.previous[old].slot < k) ++old;
			const bool known = old < oldEnd && m_front.previous[old].slot == k;
			*next =
				FrontEntry{a, b, kNone, kNone, 0, std::uint16_t(k), 0, 0, known ? old : kNone, PairState::kSeparated};
			visit(*next++, opened);
		}
		entries.resize(std::size_t(next - entries.data()));
		const std::uint32_t kept = std::uint32_t(entries.size()) - first;
		m_stats->duplicates += count - kept;
		entries[index].link = first;
		entries[index].childCount = std::uint16_t(kept);
	}

	void visit(FrontEntry& entry, Opened& opened)
	{
		m_finestA = std::min(m_finestA, entry.a);
		m_finestB = std::min(m_finestB, entry.b);
		if (entry.old == kNone) return decide(entry, PairState::kSeparated, opened, HullMemory{});
		const FrontEntry& old = m_front.previous[entry.old];
		entry.low = lowerAfter(old.low, m_moved);
		entry.high = upperAfter(old.high, m_moved);
		HullMemory memory;
		if (old.hull != kNone)
		{
			memory = m_front.previousHulls[old.hull];
			memory.lower = lowerAfter(memory.lower, m_moved);
			memory.upper = upperAfter(memory.upper, m_moved);
			if (m_settings.sameRule && old.state == PairState::kAnswer && m_sink.skips(entry, memory))
			{
				++m_stats->skippedBySlack;
				++m_stats->front;
				entry.state = PairState::kAnswer;
				return keep(entry, memory);
			}
		}
		decide(entry, old.state, opened, memory);
	}

	void decide(FrontEntry& entry, PairState before, Opened& opened, HullMemory memory)
	{
		if (!separated(entry, opened)) entry.state = nextState(entry, before);
		if (entry.state == PairState::kAnswer)
		{
			m_sink.answer(entry, memory);
			keep(entry, memory);
		}
		else if (entry.state != PairState::kSeparated && cullsByHulls(entry))
		{
			if (hullsApart(entry, memory)) entry.state = PairState::kHullsApart;
			keep(entry, memory);
		}
		const bool isOpened = entry.state == PairState::kOpenA || entry.state == PairState::kOpenB;
		++(isOpened ? m_stats->frontInner : m_stats->front);
	}

	bool cullsByHulls(const FrontEntry& entry) const
	{
		return m_settings.rule.followsSharedChildren() && !m_settings.paper &&
			   mayCullByHulls(m_context.a.node(entry.a), m_context.b.node(entry.b));
	}
	bool hullsApart(const FrontEntry& entry, HullMemory& memory)
	{
		const double limit = cullLimit(m_context.a.node(entry.a), m_context.b.node(entry.b), m_settings.tolerance);
		return m_hulls.isApart(entry.a, entry.b, limit, memory);
	}
	void keep(FrontEntry& entry, const HullMemory& memory)
	{
		entry.hull = std::uint32_t(m_front.hulls.size());
		m_front.hulls.push_back(memory);
	}

	PairState nextState(const FrontEntry& entry, PairState before) const
	{
		if (m_settings.sameRule && before != PairState::kSeparated && before != PairState::kHullsApart) return before;
		const StopRule& rule = m_settings.rule;
		if (rule.accepts(entry.a, entry.b)) return PairState::kAnswer;
		return rule.opensA(entry.a, entry.b) ? PairState::kOpenA : PairState::kOpenB;
	}

	// Are the culling volumes farther apart than the tolerance? From the cached bounds where they prove it.
	bool separated(FrontEntry& entry, Opened& opened)
	{
		if (entry.old != kNone)
		{
			const bool far = double(entry.low) > m_settings.tolerance + m_room;
			if (far || double(entry.high) < m_settings.tolerance - m_room)
			{
				++m_stats->skippedBySlack;
				return far;
			}
		}
		const double separation = measure(entry, opened);
		entry.low = lowerAfter(float(separation), 0);
		entry.high = upperAfter(float(separation), 0);
		return separation > m_settings.tolerance;
	}

	double measure(const FrontEntry& entry, Opened& opened)
	{
		if (m_settings.paper)
		{
			++m_stats->hullTests;
			return paperSeparation(m_context, entry.a, entry.b, m_settings.tolerance);
		}
		++m_stats->boxTests;
		if (!opened.placed)
		{
			opened.box = opened.opensA ? placeB(entry.b) : placeA(entry.a);
			opened.placed = true;
		}
		return opened.opensA ? boxSeparation(placeA(entry.a), opened.box) : boxSeparation(opened.box, placeB(entry.b));
	}

	PlacedBox placeA(std::uint32_t a) const { return placeInA(m_context.a.cullBox(a)); }
	PlacedBox placeB(std::uint32_t b) const
	{
		return placeInA(m_context.b.cullBox(b), m_context.pose, m_context.sweep);
	}

	static std::uint32_t levelOf(const Hierarchy& hierarchy, std::uint32_t node)
	{
		std::uint32_t level = 0;
		while (node >= hierarchy.levels()[level].firstNode + hierarchy.levels()[level].nodeCount) ++level;
		return level;
	}

	const QueryContext& m_context;
	const TraversalSettings& m_settings;
	PairFront& m_front;
	Sink& m_sink;
	const double m_room;  // for the rounding of two measurements
	const float m_moved;  // since the cached bounds
	QueryStats* m_stats;
	HullCull m_hulls;
	// Finer levels come first.
	std::uint32_t m_finestA = kNone - 1, m_finestB = kNone - 1;
};
}  // namespace clod
