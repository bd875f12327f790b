// SPDX-License-Identifier: Zlib
// The one walk over two hierarchies. Given a stop rule and a sink it visits the pairs of nodes whose culling volumes
// are within the tolerance, from the roots down, and hands every accepted one to the sink.
//
// What the cache may decide: a pair's separation s is 1-Lipschitz in the relative motion m (BoxSeparation.h), so a
// value measured at motion m0 proves s > tolerance while s0 - (m - m0) > tolerance + room, and s <= tolerance while s0
// + (m - m0) < tolerance - room. Everything else is measured anew. Both proofs decide as a measurement would, hence the
// set of visited pairs never depends on the cache.
//
// Exact mode follows primary children only: a tree, each pair once. Otherwise all children: a directed acyclic graph,
// each pair is opened where it is met first.
#pragma once
#include <vector>

#include "clod/query/BoxSeparation.h"
#include "clod/query/PairFront.h"
#include "clod/query/QueryContext.h"
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

// Sink: bool skips(const FrontEntry& old, double motion) - an accepted pair needs nothing, not even its boxes compared;
//       void answer(FrontEntry& entry, double motion)    - an accepted pair within the tolerance by its culling
//       volumes.
template <class Sink>
class Traversal
{
public:
	Traversal(const QueryContext& context, const TraversalSettings& settings, PairFront& front, Sink& sink)
		: m_context(context), m_settings(settings), m_front(front), m_sink(sink), m_room(1e-9 * context.size)
	{
	}

	void run(QueryStats& stats)
	{
		m_stats = &stats;
		std::swap(m_front.entries, m_front.previous);
		m_front.entries.clear();
		m_front.visited.clear();
		m_front.open.clear();
		visit(m_context.a.root(), m_context.b.root(), m_front.previous.empty() ? kNone : 0, nullptr);
		while (!m_front.open.empty())
		{
			OpenPair& open = m_front.open.back();
			if (open.next == open.count)
			{
				m_front.entries[open.entry].end = std::uint32_t(m_front.entries.size());
				m_front.open.pop_back();
				continue;
			}
			const std::uint32_t child = open.children[open.next++], old = open.oldChild;
			if (old != kNone) open.oldChild = m_front.previous[old].end;
			if (open.opensA)
				visit(child, open.fixed, old, &open);
			else
				visit(open.fixed, child, old, &open);
		}
	}

private:
	const FrontEntry* previousEntry(std::uint32_t old) const { return old == kNone ? nullptr : &m_front.previous[old]; }

	// Appends the pair to the front and, if it is to be opened, to the open pairs (which invalidates parent).
	void visit(std::uint32_t a, std::uint32_t b, std::uint32_t oldIndex, OpenPair* parent)
	{
		const FrontEntry* old = previousEntry(oldIndex);
		const std::uint32_t index = std::uint32_t(m_front.entries.size());
		FrontEntry entry{a, b, index + 1, PairState::kDuplicate, false, {0, 0, 0}, 0, -1, 0, 0};
		if (m_settings.rule.followsSharedChildren() && !m_front.visited.insert(a, b))
		{
			++m_stats->duplicates;
			m_front.entries.push_back(entry);
			return;
		}
		if (old && old->state == PairState::kDuplicate) old = nullptr;
		if (old) entry = *old;
		entry.end = index + 1;
		if (old && m_settings.sameRule && old->state == PairState::kAnswer && m_sink.skips(entry, m_front.motion))
		{
			++m_stats->skippedBySlack;
			++m_stats->front;
			m_front.entries.push_back(entry);
			return;
		}
		const bool apart = separated(entry, old != nullptr, parent);
		const PairState before = old ? old->state : PairState::kSeparated;
		entry.state = apart ? PairState::kSeparated : nextState(entry, before);
		if (entry.state == PairState::kAnswer) m_sink.answer(entry, m_front.motion);
		const bool opened = entry.state == PairState::kOpenA || entry.state == PairState::kOpenB;
		++(opened ? m_stats->frontInner : m_stats->front);
		m_front.entries.push_back(entry);
		if (opened) open(entry, index, before == entry.state ? oldIndex + 1 : kNone);
	}

	PairState nextState(const FrontEntry& entry, PairState before) const
	{
		if (m_settings.sameRule && before != PairState::kSeparated) return before;
		const StopRule& rule = m_settings.rule;
		if (rule.accepts(entry.a, entry.b)) return PairState::kAnswer;
		return rule.opensA(entry.a, entry.b) ? PairState::kOpenA : PairState::kOpenB;
	}

	void open(const FrontEntry& entry, std::uint32_t index, std::uint32_t oldChild)
	{
		const bool opensA = entry.state == PairState::kOpenA;
		const Hierarchy& side = opensA ? m_context.a : m_context.b;
		const Node& node = side.node(opensA ? entry.a : entry.b);
		OpenPair open;
		open.entry = index;
		open.children = side.children(node).data;
		open.count = m_settings.rule.followsSharedChildren() ? node.childCount : node.primaryChildCount;
		open.oldChild = oldChild;
		open.opensA = opensA;
		open.fixed = opensA ? entry.b : entry.a;
		m_front.open.push_back(open);
	}

	// Are the culling volumes farther apart than the tolerance? From the cached value where it proves it.
	bool separated(FrontEntry& entry, bool cached, OpenPair* parent)
	{
		if (cached)
		{
			const double moved = m_front.motion - entry.boxStamp;
			const bool far = entry.separation - moved > m_settings.tolerance + m_room;
			if (far || entry.separation + moved < m_settings.tolerance - m_room)
			{
				++m_stats->skippedBySlack;
				return far;
			}
		}
		entry.separation = measure(entry, parent);
		entry.boxStamp = m_front.motion;
		return entry.separation > m_settings.tolerance;
	}

	double measure(const FrontEntry& entry, OpenPair* parent)
	{
		if (m_settings.paper)
		{
			++m_stats->hullTests;
			return paperSeparation(m_context, entry.a, entry.b, m_settings.tolerance);
		}
		++m_stats->boxTests;
		if (!parent) return boxSeparation(placeA(entry.a), placeB(entry.b));
		if (!parent->placed)
		{
			parent->fixedBox = parent->opensA ? placeB(parent->fixed) : placeA(parent->fixed);
			parent->placed = true;
		}
		return parent->opensA ? boxSeparation(placeA(entry.a), parent->fixedBox)
							  : boxSeparation(parent->fixedBox, placeB(entry.b));
	}

	PlacedBox placeA(std::uint32_t a) const { return placeInA(m_context.a.cullBox(a)); }
	PlacedBox placeB(std::uint32_t b) const { return placeInA(m_context.b.cullBox(b), m_context.pose); }

	const QueryContext& m_context;
	const TraversalSettings& m_settings;
	PairFront& m_front;
	Sink& m_sink;
	QueryStats* m_stats = nullptr;
	const double m_room;  // for the rounding of two measurements
};
}  // namespace clod
