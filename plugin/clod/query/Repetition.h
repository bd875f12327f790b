// SPDX-License-Identifier: Zlib
// The answers of the last front once more. Most fronts are what they were (bodies at rest hardly move): each entry
// keeps how much motion the decisions on it and on its children can take, and where few have used that up, these alone
// are made again. If they are the same, so is the front, and only its accepted pairs are left to be evaluated. If one
// is not, the front is made anew (Traversal.h).
#pragma once
#include <tuple>

#include "clod/query/PairDecisions.h"

namespace clod
{
class Repetition : private PairDecisions
{
public:
	using PairDecisions::PairDecisions;

	// Whether a front has what it takes, and few enough decisions have to be made again; otherwise it is tried again,
	// and the books for it kept, after some traversals only.
	static bool isWorthTrying(const TraversalSettings& settings, PairFront& front)
	{
		if (front.books.holds.empty() || !settings.sameRule || front.tolerance != settings.tolerance) return false;
		if (front.books.spent > front.books.holds.size()) return false;
		const float moved = motionSince(front);
		std::size_t used = 0;
		for (const float holds : front.books.holds) used += moved < holds ? 0 : 1;
		if (kEntriesADecision * used < front.books.holds.size()) return true;
		front.patience.fail();
		return false;
	}

	// False, perhaps with some answers given: the front has changed. Precondition: worth trying.
	bool run()
	{
		const bool isSame = areAllAsTheyWere() && giveAnswers();
		if (!isSame)
		{
			m_front.patience.fail();
			return false;
		}
		m_front.patience.succeed();
		m_stats->frontKept = 1;
		addTo(*m_stats, m_front.counts);
		return true;
	}

private:
	static constexpr std::size_t kEntriesADecision = 4;  // of a traversal cost as much as one decision made again

	bool areAllAsTheyWere()
	{
		const std::uint32_t testsBefore = m_stats->boxTests + m_stats->hullTests;
		for (std::uint32_t i = 0; i < m_front.books.holds.size(); ++i)
			if (!(m_moved < m_front.books.holds[i]) && !isAsItWas(i)) return false;
		m_front.books.spent += m_stats->boxTests + m_stats->hullTests - testsBefore;
		return true;
	}
	// False where one that answered does not now, or the other way round.
	bool giveAnswers()
	{
		if (m_front.books.answers.empty()) listAnswers();
		for (const std::uint32_t i : m_front.books.answers)
		{
			const FrontEntry& entry = m_front.entries[i];
			HullMemory memory = remembered(entry, m_front.hulls);
			const std::uint32_t before = m_stats->hullTests;
			if (answers(entry, memory) != (entry.state == NodePairState::kAnswer)) return false;
			if (memory.knowledge == HullKnowledge::kApart) m_front.books.spent += m_stats->hullTests - before;
		}
		return true;
	}
	// Are the decisions of the last traversal on entry i, and on its children, those that it would make now?
	bool isAsItWas(std::uint32_t i)
	{
		const FrontEntry& entry = m_front.entries[i];
		m_front.books.holds[i] = std::numeric_limits<float>::infinity();
		if (i == 0)
		{
			Row row = rowOfRoots();
			measure(row, 1);
			if (row.near == 0) return false;
			hold(0, m_moved, slackOf(row, 1));
		}
		if (!entry.whileApart && entry.state != NodePairState::kAnswer && cullsByHulls(entry))
		{
			HullMemory memory = remembered(entry, m_front.hulls);
			if (areHullsApart(entry, memory) != (entry.state == NodePairState::kHullsApart)) return false;
			hold(i, m_moved, slackOfHulls(entry, memory));
		}
		if (!isOpen(entry.state)) return true;
		Row row = rowOf(entry);
		const Span<std::uint32_t> children = childrenOf(entry);
		std::uint32_t child = entry.link;
		for (std::uint32_t slot = 0; slot < children.size; slot += kBoxLanes)
		{
			setRow(row, children, slot);
			const std::uint32_t first = child;
			while (child < entry.link + entry.childCount && m_front.entries[child].slot < slot + row.count) ++child;
			measure(row, row.all());
			const Kept kept = keptOf(first, child, slot);
			if (((row.near ^ kept.all) & ~kept.traceless) != 0) return false;
			hold(i, m_moved, slackOf(row, row.near & ~kept.traceless));
		}
		return true;
	}
	// Contacts are then in order, too.
	void listAnswers()
	{
		const std::vector<FrontEntry>& entries = m_front.entries;
		for (std::uint32_t i = 0; i < entries.size(); ++i)
			if (entries[i].state == NodePairState::kAnswer || entries[i].whileApart) m_front.books.answers.push_back(i);
		std::sort(m_front.books.answers.begin(), m_front.books.answers.end(),
				  [&](std::uint32_t l, std::uint32_t r)
				  { return std::tie(entries[l].a, entries[l].b) < std::tie(entries[r].a, entries[r].b); });
	}
};
}  // namespace clod
