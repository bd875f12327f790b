// SPDX-License-Identifier: Zlib
// Breadth first, from the roots, with what the front before proves.
#include "clod/query/Traversal.h"

#include <algorithm>
#include <tuple>

namespace clod
{
namespace
{
// What a thread needs while it makes a front: the one before, and room that is not the pair's.
struct Previous
{
	std::vector<KeptEntry> entries;  // so many,
	std::uint32_t count = 0;
	const PackedFront* packed = nullptr;  // of these
	PackedFront packedNow;
	std::vector<FrontEntry> spareEntries;
	std::vector<CachedSeparation> spareHulls;
	VisitedPairs visited;

	// What is not packed was made in this query, or is at hand.
	void take(PairFront& front)
	{
		packed = &front.packed;
		if (!front.entries.empty())
		{
			packed = &packedNow;
			packedNow.pack(front.entries, front.hulls);
		}
		count = packed->unpack(entries);
		if (!front.isAtHand && front.entries.capacity() == 0) exchangeRoom(front);
	}
	void exchangeRoom(PairFront& front)
	{
		spareEntries.swap(front.entries);
		spareHulls.swap(front.hulls);
	}
	void takeBack(PairFront& front)
	{
		front.entries.clear();
		front.hulls.clear();
		if (spareEntries.capacity() == 0) exchangeRoom(front);
		front.giveBackRoom();
	}
};
Previous& previousOfThread()
{
	thread_local Previous previous;
	return previous;
}

class Traversal : private PairDecisions
{
public:
	using PairDecisions::PairDecisions;

	// Where the budget ends it, what was decided stays for the next traversal by the same rule.
	bool run()
	{
		if (!hasTime() || !isAffordable(1 + m_mostTestsOfAnswer))
		{
			if (!m_settings.sameRule) m_front.clear();
			return false;
		}
		m_previous.take(m_front);
		const bool isWhole = walk();
		if (isWhole)
		{
			m_stats->frontCame = std::uint32_t(m_front.entries.size()) - m_carried;
			m_stats->frontGone = m_previous.count - m_carried;
		}
		else
			m_front.tolerance = 0;  // has no answers to give
		return isWhole;
	}

private:
	bool walk()
	{
		m_front.entries.clear();
		m_front.hulls.clear();
		m_previous.visited.clear();
		m_front.answers.clear();
		m_front.counts = FrontCounts{};
		m_front.motionSince = m_front.sweepChangeSince = 0;
		m_front.pose = m_context.pose;
		m_front.sweep = m_context.sweep;
		startAtRoots();
		for (std::uint32_t i = 0; i < m_front.entries.size(); ++i)
		{
			if (!isOpen(m_front.entries[i].state)) continue;
			if (!hasTime() || !open(i)) return false;
		}
		m_front.counts.touchedFinestLevel = std::min(levelOf(m_context.a, m_finestA), levelOf(m_context.b, m_finestB));
		m_front.tolerance = m_settings.tolerance;
		addTo(*m_stats, m_front.counts);
		return true;
	}
	void startAtRoots()
	{
		const std::uint32_t rootA = m_context.a.root(), rootB = m_context.b.root();
		touch(rootA, rootB);
		m_previous.visited.reserve(1);
		Row row = rowOfRoots();
		const bool wasApart = m_previous.count > 0 && m_previous.entries[0].code.state == NodePairState::kSeparated;
		if (m_previous.count > 0 && !wasApart) row.met = 1, row.old[0] = 0;
		const float apart = wasApart ? lowerAfter(m_previous.entries[0].apart, m_moved) : 0.0F;
		const bool isStillApart = wasApart && isBeyond(apart);
		examine(row, isStillApart);
		if (wasApart || (row.near == 0 && m_previous.count > 0)) ++m_carried;  // without a link to its old entry
		if (row.near == 0)
		{
			FrontEntry root{rootA, rootB};
			root.apart = isStillApart ? apart : row.apart;
			m_front.entries.push_back(root);
			++m_front.counts.leaves;
		}
		else
			visit(row, 0);
	}
	// False where the limit was met: it is as if it had not been tried.
	bool open(std::uint32_t index)
	{
		const FrontEntry pair = m_front.entries[index];
		Row row = rowOf(pair);
		const Hierarchy& side = row.ofChildrenOfA ? m_context.a : m_context.b;
		const Span<std::uint32_t> children = childrenOf(pair);

		std::uint32_t old = 0, oldEnd = 0;
		bool stillApart = false;
		if (pair.old != kNone && m_previous.entries[pair.old].code.state == pair.state)
		{
			const KeptEntry& before = m_previous.entries[pair.old];
			old = before.link;
			oldEnd = old + before.childCount;
			const float low = lowerAfter(before.apart, m_moved);
			stillApart = isBeyond(low);
			if (stillApart) row.apart = low;
		}
		if (!stillApart)
			for (const std::uint32_t child : children) __builtin_prefetch(&side.cullBox(child));
		const std::uint32_t first = std::uint32_t(m_front.entries.size());
		const std::size_t firstHull = m_front.hulls.size();
		std::uint32_t& finest = row.ofChildrenOfA ? m_finestA : m_finestB;
		for (const std::uint32_t child : children) finest = std::min(finest, child);
		if (!m_settings.rule.isOfLeaves()) m_previous.visited.reserve(children.size);
		for (std::uint32_t slot = 0; slot < children.size; slot += kBoxLanes)
		{
			setRow(row, children, slot);
			for (; old < oldEnd && m_previous.entries[old].slot < slot + row.count; ++old)
			{
				const std::uint32_t k = m_previous.entries[old].slot - slot;
				row.met |= 1U << k;
				row.old[k] = old;
			}
			bool isMet = !isAffordable(row.count);
			if (!isMet) examine(row, stillApart);
			forEach(row.near,
					[&](std::uint32_t k)
					{
						isMet = isMet || !isAffordable(m_mostTestsOfAnswer);
						if (!isMet) visit(row, k);
					});
			if (isMet)
			{
				m_front.entries.resize(first);
				m_front.hulls.resize(firstHull);
				return false;
			}
		}
		FrontEntry& opened = m_front.entries[index];
		opened.link = first;
		opened.childCount = std::uint16_t(m_front.entries.size() - first);
		m_front.counts.leaves += std::uint32_t(children.size) - opened.childCount;
		opened.apart = row.apart;
		return true;
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
	// From the bound kept.
	bool isKnownNear(Row& row, std::uint32_t k)
	{
		row.high[k] = upperAfter(m_previous.entries[row.old[k]].high, m_moved);
		const bool isKnown = double(row.high[k]) < m_settings.tolerance - m_room;
		m_stats->skippedBySlack += isKnown ? 1 : 0;
		return isKnown;
	}

	// A pair within the tolerance by its culling volumes.
	void visit(const Row& row, std::uint32_t k)
	{
		FrontEntry entry{row.a(k), row.b(k)};
		entry.slot = std::uint16_t(row.firstSlot + k);
		entry.high = row.high[k];
		if ((row.met >> k & 1) != 0)
		{
			entry.old = row.old[k];
			++m_carried;
		}
		// Where only leaves answer the walk follows a tree, and meets each pair once.
		if (!m_settings.rule.isOfLeaves() && !m_previous.visited.insert(entry.a, entry.b))
		{
			entry.state = NodePairState::kElsewhere;
			++m_front.counts.duplicates;
		}
		else
			decide(entry);
		m_front.entries.push_back(entry);
	}

	void decide(FrontEntry& entry)
	{
		NodePairState before = NodePairState::kSeparated;
		CachedSeparation cached;
		if (entry.old != kNone)
		{
			const KeptEntry& old = m_previous.entries[entry.old];
			before = old.code.state;
			m_previous.packed->recall(old, cached);
			carryOn(cached, entry.b);
		}
		const Acceptance acceptance = acceptanceOf(entry, before);
		entry.whileApart = acceptance == Acceptance::kWhileApart;
		if (acceptance != Acceptance::kNo)
		{
			if (answers(entry, cached))
			{
				entry.state = NodePairState::kAnswer;
				keep(entry, cached);
			}
		}
		else if (cullsByHulls(entry))
		{
			if (areHullsApart(entry, cached)) entry.state = NodePairState::kHullsApart;
			keep(entry, cached);
		}
		if (entry.state == NodePairState::kSeparated)
		{
			const bool wasOpened = m_settings.sameRule && isOpen(before);
			const bool opensA = wasOpened ? before == NodePairState::kOpenA : m_settings.rule.opensA(entry.a, entry.b);
			entry.state = opensA ? NodePairState::kOpenA : NodePairState::kOpenB;
		}
		++(isOpen(entry.state) ? m_front.counts.inner : m_front.counts.leaves);
	}

	void keep(FrontEntry& entry, const CachedSeparation& cached)
	{
		entry.hull = std::uint32_t(m_front.hulls.size());
		m_front.hulls.push_back(cached);
	}

	Acceptance acceptanceOf(const FrontEntry& entry, NodePairState before) const
	{
		const bool isKnown = before == NodePairState::kAnswer || isOpen(before);
		if (m_settings.sameRule && isKnown && !m_settings.rule.dependsOnHulls())
			return before == NodePairState::kAnswer ? Acceptance::kYes : Acceptance::kNo;
		return m_settings.rule.acceptance(entry.a, entry.b);
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

	Previous& m_previous = previousOfThread();
	std::uint32_t m_carried = 0;  // entries that the traversal before had
	// Finer levels come first.
	std::uint32_t m_finestA = kNone - 1, m_finestB = kNone - 1;
};

// Gives the answers of the last front once more.
class LastAnswers : private PairDecisions
{
public:
	using PairDecisions::PairDecisions;

	// False where one that answered does not now, or the other way round.
	bool give()
	{
		if (m_front.answers.empty()) list();
		const double nearer = m_change + m_partMotion.of(Vec3{}, 2 * m_context.radiusB).farthest();
		for (const std::uint32_t i : m_front.answers)
		{
			const FrontEntry& entry = m_front.entries[i];
			if (isFar(entry, nearer))
			{
				++m_stats->skippedBySlack;
				continue;
			}
			CachedSeparation cached;
			if (entry.hull != kNone) cached = m_front.hulls[entry.hull];
			carryOn(cached, entry.b);
			const std::uint32_t before = m_stats->hullTests;
			if (answers(entry, cached) != (entry.state == NodePairState::kAnswer)) return false;
			if (m_stats->hullTests != before && entry.hull != kNone)
				m_front.hulls[entry.hull] = carriedBack(cached, entry.b);
		}
		m_stats->frontKept = 1;
		addTo(*m_stats, m_front.counts);
		return true;
	}

private:
	// By a bound remembered, less what anything of B can have come nearer, or its node.
	bool isFar(const FrontEntry& entry, double nearer) const
	{
		if (entry.hull == kNone || entry.whileApart) return false;
		const CachedSeparation& known = m_front.hulls[entry.hull];
		return known.isApart() && (m_sink.skips((1 - 2 * kBoundRounding) * (double(known.lower) - nearer)) ||
								   m_sink.skips(double(lowerNow(known, entry.b))));
	}
	// Contacts are then in order, too.
	void list()
	{
		const std::vector<FrontEntry>& entries = m_front.entries;
		for (std::uint32_t i = 0; i < entries.size(); ++i)
			if (entries[i].state == NodePairState::kAnswer || entries[i].whileApart) m_front.answers.push_back(i);
		std::sort(m_front.answers.begin(), m_front.answers.end(),
				  [&](std::uint32_t l, std::uint32_t r)
				  { return std::tie(entries[l].a, entries[l].b) < std::tie(entries[r].a, entries[r].b); });
	}
	// As of the last traversal, what was found now: along its axis, which is known.
	CachedSeparation carriedBack(CachedSeparation cached, std::uint32_t b) const
	{
		if (!cached.isApart()) return cached;
		const double nearer = m_change + wayOf(b).leastAlong(cached.axis.get());
		cached.lower = lowerAfter(cached.lower, float(-nearer + kBoundRounding * std::abs(nearer)));
		return cached;
	}
};
}  // namespace

bool traverse(const QueryContext& context, const TraversalSettings& settings, PairFront& front, ContactSink& sink,
			  QueryStats& stats)
{
	return Traversal(context, settings, front, sink, stats).run();
}

bool hasAllAnswers(const QueryContext& context, double tolerance, const PairFront& front)
{
	if (front.entries.empty() || !(tolerance < front.tolerance)) return false;
	const double nearer =
		approachBound(front.pose, front.sweep, context.pose, context.sweep, context.radiusA, context.radiusB);
	return tolerance + nearer + kSumRounding * context.size + context.boxes.roundingOfTwo() < front.tolerance;
}

bool answerFromLast(const QueryContext& context, const TraversalSettings& settings, PairFront& front, ContactSink& sink,
					QueryStats& stats)
{
	return LastAnswers(context, settings, front, sink, stats).give();
}

void settle(PairFront& front, bool isKept)
{
	if (isKept && front.isAtHand) return front.fitRoom();
	if (isKept && !front.entries.empty()) front.packed.pack(front.entries, front.hulls);
	previousOfThread().takeBack(front);
	if (!isKept) front.giveBack();
}
}  // namespace clod
