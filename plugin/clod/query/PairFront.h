// SPDX-License-Identifier: Zlib
// The bounding volume test tree of one query, kept for the next: every pair met but those that are apart, breadth
// first, with bounds of its last distances that are carried on with the motion. A cache: see PairDecisions.h for what
// it may decide.
//
// Based on: Otaduy & Lin 2003, sec. 3.3 (generalised front tracking of Ehmann & Lin 2001). Departs from it: the whole
// tree above the front is kept, so that raising the front needs no search, and pairs that cannot have changed are not
// measured.
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "clod/collide/Room.h"
#include "clod/collide/Sweep.h"
#include "clod/query/PackedFront.h"
#include "clod/query/Query.h"

namespace clod
{
// Set of pairs with an O(1) clear. Open addressing; grows by doubling. Node indices are below 2^28.
class VisitedPairs
{
public:
	void clear()
	{
		m_epoch = (m_epoch + 1) % 256;
		if (m_epoch == 0)
		{
			m_slots.assign(m_slots.size(), 0);
			m_epoch = 1;
		}
		m_count = 0;
	}
	// Room for so many more.
	void reserve(std::size_t more)
	{
		while (2 * (m_count + more) > m_slots.size()) grow();
	}
	// False when it was there already. Precondition: room.
	bool insert(std::uint32_t a, std::uint32_t b)
	{
		const std::uint64_t pair = std::uint64_t(m_epoch) << 56 | std::uint64_t(a) << 28 | b;
		std::uint64_t& slot = find(pair);
		if (slot == pair) return false;
		slot = pair;
		++m_count;
		return true;
	}

private:
	// Where the pair is, or the slot it may take.
	std::uint64_t& find(std::uint64_t pair)
	{
		std::size_t i = std::size_t((pair * 0x9E3779B97F4A7C15u) >> 32) & (m_slots.size() - 1);
		while (m_slots[i] >> 56 == m_epoch && m_slots[i] != pair) i = (i + 1) & (m_slots.size() - 1);
		return m_slots[i];
	}
	void grow()
	{
		const std::vector<std::uint64_t> old = std::move(m_slots);
		m_slots.assign(old.empty() ? 1024 : 2 * old.size(), 0);
		for (const std::uint64_t pair : old)
			if (pair >> 56 == m_epoch) find(pair) = pair;
	}
	std::vector<std::uint64_t> m_slots;  // epoch, a, b
	std::size_t m_count = 0;
	std::uint64_t m_epoch = 1;
};

// What QueryStats says of a front.
struct FrontCounts
{
	std::uint32_t leaves = 0, inner = 0, duplicates = 0, touchedFinestLevel = 0;
};
inline void addTo(QueryStats& stats, const FrontCounts& counts)
{
	stats.front += counts.leaves;
	stats.frontInner += counts.inner;
	stats.duplicates += counts.duplicates;
	stats.touchedFinestLevel = counts.touchedFinestLevel;
}

struct PairFront
{
	PackedFront packed;               // what is kept between queries, unless it is at hand
	std::vector<FrontEntry> entries;  // of the last finished traversal; [0] is the pair of roots, children lie together
	std::vector<CachedSeparation> hulls;
	std::vector<std::uint32_t> answers;  // entries to give again without a walk, by their nodes; listed when needed
	double motion = 0;            // accumulated bound of the relative motion and of the sweep's change (MotionBound.h)
	double motionSince = 0;       // the part of it since the last finished traversal
	double sweepChangeSince = 0;  // of the sweep, since then, along directions fixed to A
	RelativePose pose;            // of the last finished traversal,
	Sweep sweep;                  // and what moved on from there

	double tolerance = 0;   // of boxes, in the last finished traversal
	bool isAtHand = false;  // is asked for its answers again: not packed, in memory of its own
	bool isKept = true;     // when the query ends: else nothing of it is
	FrontCounts counts;

	// For answers as much as there may be, as nearly all have a hull: a steady query allocates nothing.
	void makeRoom()
	{
		shrinkRoom(answers, hulls.capacity());
		answers.reserve(hulls.capacity());
	}
	bool isEmpty() const { return packed.isEmpty() && entries.empty(); }
	// The bodies have parted: what they took is given back.
	void giveBack()
	{
		clear();
		packed.giveBack();
		giveBackRoom();
		answers.shrink_to_fit();
	}
	// Of one at hand: no larger than it need be.
	void fitRoom()
	{
		packed.giveBack();
		shrinkRoom(entries, entries.size());
		shrinkRoom(hulls, hulls.size());
	}
	void giveBackRoom()
	{
		std::vector<FrontEntry>().swap(entries);
		std::vector<CachedSeparation>().swap(hulls);
	}
	// change: of the sweep, along any axis; changeInA: along those fixed to A.
	void move(double by, double change, double changeInA)
	{
		motion += by + change;
		motionSince += by + change;
		sweepChangeSince += changeInA;
	}
	void clear()
	{
		packed.clear();
		entries.clear();
		hulls.clear();
		answers.clear();
		motion = motionSince = sweepChangeSince = 0;
	}
};
}  // namespace clod
