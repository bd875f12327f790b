// SPDX-License-Identifier: Zlib
// The decisions on pairs of nodes that make a front: which children of an opened pair are near, whether hulls are apart,
// what answers. Traversal.cpp makes a front of them.
//
// A pair's separation is 1-Lipschitz in the relative motion (BoxSeparation.h). So a value measured once proves, less or
// plus the motion since and with some room for rounding, that the pair is still beyond the tolerance, or within. Both
// decide as a measurement would: the set of visited pairs never depends on the cache.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "clod/collide/BoxSeparation.h"
#include "clod/collide/MotionBound.h"
#include "clod/query/ContactSink.h"
#include "clod/query/StopRule.h"

namespace clod
{
struct TraversalSettings
{
	const StopRule& rule;
	double tolerance = 0;
	bool sameRule = false;  // the stop rule is that of the cached front: its states hold
	WorkLimit limit{Budget{}};
};

// Since the last traversal, rounded up.
inline float motionSince(const PairFront& front)
{
	return float(front.motionSince) * (1 + float(kBoundRounding));
}

class PairDecisions
{
public:
	PairDecisions(const QueryContext& context, const TraversalSettings& settings, PairFront& front, ContactSink& sink,
				  QueryStats& stats)
		: m_context(context),
		  m_settings(settings),
		  m_front(front),
		  m_sink(sink),
		  m_rootA(context.a.root()),
		  m_limit(roundDown(settings.tolerance)),
		  m_room(kSumRounding * context.size + context.boxes.roundingOfTwo()),
		  m_moved(motionSince(front)),
		  m_change(front.sweepChangeSince),
		  m_isLimited(settings.limit.isSet()),
		  m_mostTestsOfAnswer((context.longestMove > 0 ? 3 : 2) + (settings.rule.dependsOnHulls() ? 2 : 0)),
		  m_stats(&stats),
		  m_hulls(context, stats)
	{
		if (!front.isEmpty()) m_partMotion = PartMotion(front.pose, context.pose);
	}

protected:
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

	// Of the pair of roots alone.
	Row rowOfRoots() const
	{
		Row row;
		row.other = m_context.b.root();
		row.ofChildrenOfA = true;
		setRow(row, {&m_rootA, 1}, 0);
		return row;
	}
	static Row rowOf(const FrontEntry& opened)
	{
		Row row;
		row.ofChildrenOfA = opened.state == NodePairState::kOpenA;
		row.other = row.ofChildrenOfA ? opened.b : opened.a;
		return row;
	}
	static void setRow(Row& row, const Span<std::uint32_t>& children, std::uint32_t slot)
	{
		row.children = children.data + slot;
		row.count = std::min(kBoxLanes, std::uint32_t(children.size) - slot);
		row.firstSlot = slot;
		row.near = row.met = 0;
	}
	Span<std::uint32_t> childrenOf(const FrontEntry& opened) const
	{
		const bool isA = opened.state == NodePairState::kOpenA;
		return m_settings.rule.childrenOf(isA, isA ? opened.a : opened.b);
	}

	void measure(Row& row, std::uint32_t unknown)
	{
		if (unknown == row.all())
		{
			const std::uint32_t within = separate(row, row.children, row.count, row.high);
			row.near |= within;
			forEach(within, [&](std::uint32_t k) { row.high[k] = upperAfter(row.high[k], 0); });
			return;
		}
		std::uint32_t child[kBoxLanes], nodes[kBoxLanes], count = 0;
		forEach(unknown,
				[&](std::uint32_t k)
				{
					child[count] = k;
					nodes[count++] = row.children[k];
				});
		float separations[kBoxLanes];
		forEach(separate(row, nodes, count, separations),
				[&](std::uint32_t i)
				{
					row.near |= 1U << child[i];
					row.high[child[i]] = upperAfter(separations[i], 0);
				});
	}
	// Of some children of the row: which are near, as bits, and by how much the others are apart at least.
	std::uint32_t separate(Row& row, const std::uint32_t* nodes, std::uint32_t count, float (&separations)[kBoxLanes])
	{
		const std::uint32_t within =
			boxSeparations(m_context, row.ofChildrenOfA, row.other, nodes, count, separations, m_limit);
		m_stats->boxTests += count;
		float apart = std::numeric_limits<float>::infinity();
		for (std::uint32_t i = 0; i < count; ++i)
			apart = std::min(apart, (within >> i & 1) != 0 ? std::numeric_limits<float>::infinity() : separations[i]);
		if (within != (1U << count) - 1) row.apart = std::min(row.apart, lowerAfter(apart, 0));
		return within;
	}
	// To this pose, of a pair with node b.
	void carryOn(CachedSeparation& cached, std::uint32_t b) const
	{
		if (cached.isApart()) cached.lower = lowerNow(cached, b);
	}
	// What is left, at this pose, of a bound remembered of a pair with node b.
	float lowerNow(const CachedSeparation& known, std::uint32_t b) const
	{
		const Vec3 axis = known.axis.get();
		const PartMotion::Way way = wayOf(b);
		const double nearer = m_change + (axis == Vec3{} ? way.farthest() : way.along(axis));
		return lowerAfter(known.lower, float(nearer + kBoundRounding * std::abs(nearer)));
	}
	// So many tests more are within the limit.
	bool isAffordable(std::uint64_t tests) const
	{
		return !m_isLimited || m_settings.limit.allowsTests(m_stats->boxTests + m_stats->hullTests + tests);
	}
	bool hasTime() const { return !m_isLimited || m_settings.limit.hasTime(); }

	bool cullsByHulls(const FrontEntry& entry) const
	{
		return !m_settings.rule.base().isUsed() &&
			   mayCullByHulls(m_context.a.node(entry.a), m_context.b.node(entry.b));
	}
	bool areHullsApart(const FrontEntry& entry, CachedSeparation& cached)
	{
		const Node &a = m_context.a.node(entry.a), &b = m_context.b.node(entry.b);
		return m_hulls.isApart(entry.a, entry.b, cullLimit(a, b, m_settings.tolerance), cached);
	}
	// Whether an entry answers that may, as its hulls decide; and its answer.
	bool answers(const FrontEntry& entry, CachedSeparation& cached)
	{
		HullEvaluations known;
		if (entry.whileApart && !m_hulls.areApart(entry.a, entry.b, m_sink.tolerance(), cached, known)) return false;
		m_sink.answer(entry.a, entry.b, cached, known);
		return true;
	}

	PartMotion::Way wayOf(std::uint32_t b) const
	{
		const OrientedBox& box = m_context.b.cullBox(b);
		return m_partMotion.of(centerOf(box), double(box.radius));
	}

	const QueryContext& m_context;
	const TraversalSettings& m_settings;
	PairFront& m_front;
	ContactSink& m_sink;
	const std::uint32_t m_rootA;
	const float m_limit;  // floats within the tolerance are at most this
	const double m_room;  // for the rounding of two measurements
	const float m_moved;  // since the cached bounds
	PartMotion m_partMotion;
	const double m_change;  // of the sweep, since then
	const bool m_isLimited;
	// Along the remembered axis, on the way and at rest, and both once more where it is an answer only while its hulls are
	// apart.
	const std::uint32_t m_mostTestsOfAnswer;
	QueryStats* m_stats;
	HullCull m_hulls;
};
}  // namespace clod
