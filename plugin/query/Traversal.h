// SPDX-License-Identifier: Zlib
// The one walk over two hierarchies. Given a stop rule and a sink it visits the pairs of nodes whose culling volumes
// are within the tolerance, from the roots down and level of the walk by level, and hands every accepted one to the
// contacts.
//
// What the cache may decide: a pair's separation is 1-Lipschitz in the relative motion (BoxSeparation.h), so a value
// measured once, less the motion since, proves that it is beyond the tolerance still, and plus the motion that it is
// within, each with some room for rounding. Everything else is measured anew. Both proofs decide as a measurement
// would, hence the set of visited pairs never depends on the cache.
//
// Where there are no base levels, outside paper mode, a pair of contact nodes that is not accepted is opened only where
// its hulls, too, are near: boxes of curved patches are far from tight.
//
// Above base levels (StopRule.h; in exact mode the input surfaces) only primary children are followed: a tree, each
// pair once; and as no level there may answer, it jumps over levels (Hierarchy::wideChildren). Otherwise all children:
// a directed acyclic graph, each pair is opened where it is met first. Either way up to eight children are compared
// with the other node at once.
//
// Children that are apart leave no trace but the smallest of their separations, in the entry of the pair opened: while
// the motion does not use it up, none of them is looked at.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "clod/query/BoxSeparation.h"
#include "clod/query/ContactSink.h"
#include "clod/query/MotionBound.h"
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

class Traversal
{
public:
	Traversal(const QueryContext& context, const TraversalSettings& settings, PairFront& front, ContactSink& sink,
			  QueryStats& stats)
		: m_context(context),
		  m_settings(settings),
		  m_front(front),
		  m_sink(sink),
		  m_limit(roundDown(settings.tolerance)),
		  m_room(1e-9 * context.size + context.boxes.roundingOfTwo()),
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
		if (!m_front.previous.empty()) m_partMotion = PartMotion(m_front.pose, m_context.pose);
		m_change = m_front.pendingChange;
		m_front.pending = m_front.pendingChange = 0;
		m_front.pose = m_context.pose;
		startAtRoots();
		for (std::uint32_t i = 0; i < m_front.entries.size(); ++i)
		{
			const PairState state = m_front.entries[i].state;
			if (isOpen(state)) open(i);
		}
		m_stats->touchedFinestLevel = std::min(levelOf(m_context.a, m_finestA), levelOf(m_context.b, m_finestB));
	}

private:
	// Some of the pairs of one opened: a node of one body and children of the other's, and what is known of them. Sets
	// of children are bits.
	struct Row
	{
		bool ofChildrenOfA = false;
		std::uint32_t other = kNone;              // the node that is not opened
		const std::uint32_t* children = nullptr;  // count of them
		std::uint32_t count = 0, firstSlot = 0;
		std::uint32_t met = 0;                                 // in the traversal before,
		std::uint32_t old[kBoxLanes];                          // as these entries
		std::uint32_t near = 0;                                // within the tolerance,
		float high[kBoxLanes];                                 // by bounds of the separation
		float apart = std::numeric_limits<float>::infinity();  // that of all others exceeds it
		std::uint32_t all() const { return (1U << count) - 1; }
		std::uint32_t a(std::uint32_t k) const { return ofChildrenOfA ? children[k] : other; }
		std::uint32_t b(std::uint32_t k) const { return ofChildrenOfA ? other : children[k]; }
	};
	template <class Visit>
	static void forEach(std::uint32_t bits, Visit&& visit)
	{
		for (; bits != 0; bits &= bits - 1) visit(std::uint32_t(__builtin_ctz(bits)));
	}

	void startAtRoots()
	{
		const std::uint32_t rootA = m_context.a.root(), rootB = m_context.b.root();
		touch(rootA, rootB);
		m_front.visited.reserve(1);
		Row row;
		row.other = rootB;
		row.ofChildrenOfA = true;
		row.children = &rootA;
		row.count = 1;
		const bool wasApart = !m_front.previous.empty() && m_front.previous[0].state == PairState::kSeparated;
		if (!m_front.previous.empty() && !wasApart) row.met = 1, row.old[0] = 0;
		const float apart = wasApart ? lowerAfter(m_front.previous[0].apart, m_moved) : 0.0F;
		const bool isStillApart = wasApart && isBeyond(apart);
		examine(row, isStillApart);
		if (row.near == 0)
		{
			FrontEntry root{rootA, rootB};
			root.apart = isStillApart ? apart : row.apart;
			m_front.entries.push_back(root);
			++m_stats->front;
		}
		else
			visit(row, 0);
	}

	void open(std::uint32_t index)
	{
		const FrontEntry pair = m_front.entries[index];
		Row row;
		row.ofChildrenOfA = pair.state == PairState::kOpenA;
		row.other = row.ofChildrenOfA ? pair.b : pair.a;
		const Hierarchy& side = row.ofChildrenOfA ? m_context.a : m_context.b;
		const Span<std::uint32_t> children =
			m_settings.rule.childrenOf(row.ofChildrenOfA, row.ofChildrenOfA ? pair.a : pair.b);

		std::uint32_t old = 0, oldEnd = 0;
		bool stillApart = false;
		if (pair.old != kNone && m_front.previous[pair.old].state == pair.state)
		{
			const FrontEntry& before = m_front.previous[pair.old];
			old = before.link;
			oldEnd = old + before.childCount;
			const float low = lowerAfter(before.apart, m_moved);
			stillApart = isBeyond(low);
			if (stillApart) row.apart = low;
		}
		if (!stillApart)
			for (const std::uint32_t child : children) __builtin_prefetch(&side.cullBox(child));
		const std::uint32_t first = std::uint32_t(m_front.entries.size());
		std::uint32_t& finest = row.ofChildrenOfA ? m_finestA : m_finestB;
		for (const std::uint32_t child : children) finest = std::min(finest, child);
		if (!m_settings.rule.isOfLeaves()) m_front.visited.reserve(children.size);
		for (std::uint32_t slot = 0; slot < children.size; slot += kBoxLanes)
		{
			row.children = children.data + slot;
			row.count = std::min(kBoxLanes, std::uint32_t(children.size) - slot);
			row.firstSlot = slot;
			row.near = row.met = 0;
			for (; old < oldEnd && m_front.previous[old].slot < slot + row.count; ++old)
			{
				const std::uint32_t k = m_front.previous[old].slot - slot;
				row.met |= 1U << k;
				row.old[k] = old;
			}
			examine(row, stillApart);
			forEach(row.near, [&](std::uint32_t k) { visit(row, k); });
		}
		FrontEntry& opened = m_front.entries[index];
		opened.link = first;
		opened.childCount = std::uint16_t(m_front.entries.size() - first);
		m_stats->front += std::uint32_t(children.size) - opened.childCount;
		opened.apart = row.apart;
	}

	// Which pairs of a row are near, from cached bounds where they prove it; othersAreFar: those not met before are.
	void examine(Row& row, bool othersAreFar)
	{
		std::uint32_t unknown = row.all();
		if (othersAreFar)
		{
			unknown = row.met;
			m_stats->skippedBySlack += row.count;
		}
		forEach(row.met,
				[&](std::uint32_t k)
				{
					if (othersAreFar) --m_stats->skippedBySlack;
					if (!isKnownNear(row, k)) return;
					row.near |= 1U << k;
					unknown &= ~(1U << k);
				});
		if (unknown != 0) measure(row, unknown);
	}
	// From the bound kept, or because the sink needs nothing of the pair, however near its boxes are.
	bool isKnownNear(Row& row, std::uint32_t k)
	{
		const FrontEntry& old = m_front.previous[row.old[k]];
		row.high[k] = upperAfter(old.high, m_moved);
		if (double(row.high[k]) < m_settings.tolerance - m_room)
		{
			++m_stats->skippedBySlack;
			return true;
		}
		if (!m_settings.sameRule || old.state != PairState::kAnswer || old.hull == kNone) return false;
		return m_sink.skips(row.a(k), row.b(k), remembered(old));
	}

	void measure(Row& row, std::uint32_t unknown)
	{
		std::uint32_t child[kBoxLanes], nodes[kBoxLanes], count = 0;
		forEach(unknown,
				[&](std::uint32_t k)
				{
					child[count] = k;
					nodes[count++] = row.children[k];
				});
		float separations[kBoxLanes];
		const std::uint32_t within = m_settings.paper ? paperSeparations(row, child, count, separations)
													  : boxSeparations(m_context, row.ofChildrenOfA, row.other, nodes,
																	   count, separations, m_limit);
		(m_settings.paper ? m_stats->hullTests : m_stats->boxTests) += count;
		float apart = std::numeric_limits<float>::infinity();
		for (std::uint32_t i = 0; i < count; ++i)
			apart = std::min(apart, (within >> i & 1) != 0 ? std::numeric_limits<float>::infinity() : separations[i]);
		if (within != (1U << count) - 1) row.apart = std::min(row.apart, lowerAfter(apart, 0));
		forEach(within,
				[&](std::uint32_t i)
				{
					row.near |= 1U << child[i];
					row.high[child[i]] = upperAfter(separations[i], 0);
				});
	}
	std::uint32_t paperSeparations(const Row& row, const std::uint32_t* child, std::uint32_t count,
								   float* separations) const
	{
		std::uint32_t within = 0;
		for (std::uint32_t i = 0; i < count; ++i)
		{
			separations[i] = lowerAfter(
				float(paperSeparation(m_context, row.a(child[i]), row.b(child[i]), m_settings.tolerance)), 0);
			within |= separations[i] <= m_limit ? 1U << i : 0;
		}
		return within;
	}

	HullMemory remembered(const FrontEntry& old) const
	{
		if (old.hull == kNone) return {};
		HullMemory memory = m_front.previousHulls[old.hull];
		if (memory.knowledge != HullKnowledge::kApart) return memory;
		const CullBox& box = m_context.b.cullBox(old.b);
		const double nearer = m_partMotion.along(vectorOf(memory.onA), centerOf(box), double(box.radius)) + m_change;
		memory.lower = lowerAfter(memory.lower, float(nearer + 3e-7 * std::abs(nearer)));
		return memory;
	}

	// A pair within the tolerance by its culling volumes.
	void visit(const Row& row, std::uint32_t k)
	{
		FrontEntry entry{row.a(k), row.b(k)};
		entry.slot = std::uint16_t(row.firstSlot + k);
		entry.high = row.high[k];
		if ((row.met >> k & 1) != 0) entry.old = row.old[k];
		if (!m_settings.rule.isInTree(entry.a, entry.b) && !m_front.visited.insert(entry.a, entry.b))
		{
			entry.state = PairState::kElsewhere;
			++m_stats->duplicates;
		}
		else
			decide(entry);
		m_front.entries.push_back(entry);
	}

	void decide(FrontEntry& entry)
	{
		PairState before = PairState::kSeparated;
		HullMemory memory;
		if (entry.old != kNone)
		{
			before = m_front.previous[entry.old].state;
			memory = remembered(m_front.previous[entry.old]);
		}
		const Acceptance acceptance = acceptanceOf(entry, before);
		if (acceptance == Acceptance::kYes)
		{
			entry.state = PairState::kAnswer;
			m_sink.answer(entry.a, entry.b, memory);
			keep(entry, memory);
		}
		else if (acceptance == Acceptance::kWhileApart)
			answerWhileApart(entry, memory);
		else if (cullsByHulls(entry))
		{
			if (hullsApart(entry, memory)) entry.state = PairState::kHullsApart;
			keep(entry, memory);
		}
		if (entry.state == PairState::kSeparated)
		{
			const bool wasOpened = m_settings.sameRule && isOpen(before);
			const bool opensA = wasOpened ? before == PairState::kOpenA : m_settings.rule.opensA(entry.a, entry.b);
			entry.state = opensA ? PairState::kOpenA : PairState::kOpenB;
		}
		++(isOpen(entry.state) ? m_stats->frontInner : m_stats->front);
	}

	bool cullsByHulls(const FrontEntry& entry) const
	{
		return !m_settings.rule.base().isUsed() && !m_settings.paper &&
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

	static bool isOpen(PairState state) { return state == PairState::kOpenA || state == PairState::kOpenB; }
	Acceptance acceptanceOf(const FrontEntry& entry, PairState before) const
	{
		const bool isKnown = before == PairState::kAnswer || isOpen(before);
		if (m_settings.sameRule && isKnown && !m_settings.rule.dependsOnHulls())
			return before == PairState::kAnswer ? Acceptance::kYes : Acceptance::kNo;
		return m_settings.rule.acceptance(entry.a, entry.b);
	}
	void answerWhileApart(FrontEntry& entry, HullMemory& memory)
	{
		std::optional<HullDistance> evaluated;
		if (!m_hulls.areApart(entry.a, entry.b, m_settings.tolerance, memory, evaluated)) return;
		entry.state = PairState::kAnswer;
		m_sink.answer(entry.a, entry.b, memory, evaluated);
		keep(entry, memory);
	}

	bool isBeyond(float low) const { return double(low) > m_settings.tolerance + m_room; }
	void touch(std::uint32_t a, std::uint32_t b)
	{
		m_finestA = std::min(m_finestA, a);
		m_finestB = std::min(m_finestB, b);
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
	ContactSink& m_sink;
	const float m_limit;  // floats within the tolerance are at most this
	const double m_room;  // for the rounding of two measurements
	const float m_moved;  // since the cached bounds
	PartMotion m_partMotion;
	double m_change = 0;  // of the sweep, since then
	QueryStats* m_stats;
	HullCull m_hulls;
	// Finer levels come first.
	std::uint32_t m_finestA = kNone - 1, m_finestB = kNone - 1;
};
}  // namespace clod
