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

#include "clod/collide/HullDistance.h"
#include "clod/collide/Room.h"
#include "clod/collide/SeparatingAxis.h"
#include "clod/query/Constants.h"
#include "clod/query/Query.h"

namespace clod
{
enum class NodePairState : std::uint8_t
{
	kSeparated,   // culling volumes are farther apart than the tolerance: only the pair of roots is kept then
	kElsewhere,   // met before in this walk, through other parents
	kOpenA,       // replaced by the children of a
	kOpenB,       // replaced by the children of b
	kHullsApart,  // not accepted, and nothing the two nodes answer for is within the tolerance (HullCull.h)
	kAnswer       // accepted by the stop rule, culling volumes within the tolerance
};
inline bool isOpen(NodePairState state)
{
	return state == NodePairState::kOpenA || state == NodePairState::kOpenB;
}

// Bounds are of the pose of the last finished traversal, in float, rounded outward.
struct FrontEntry
{
	std::uint32_t a, b;
	std::uint32_t link = kNone;    // opened: its first child in entries
	std::uint32_t hull = kNone;    // its place in hulls
	std::uint16_t childCount = 0;  // of link
	std::uint16_t slot = 0;        // its number among the children of the node opened above it
	float high = 0;                // the separation of the culling volumes is less
	float apart = 0;               // opened: that of every child which is not kept exceeds
	std::uint32_t old = kNone;     // its entry in the traversal before
	NodePairState state = NodePairState::kSeparated;
	bool whileApart = false;  // answers, or is opened, as its hulls are apart, or not
};
static_assert(sizeof(FrontEntry) == 36);

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
	std::vector<FrontEntry> entries;  // of the last finished traversal; [0] is the pair of roots, children lie together
	std::vector<CachedSeparation> hulls;
	std::vector<std::uint32_t> answers;  // entries to give again without a walk, by their nodes; listed when needed
	double motion = 0;         // accumulated bound of the relative motion and of the sweep's change (MotionBound.h)
	double motionSince = 0;    // the part of it since the last finished traversal
	double sweepChangeSince = 0;  // of the sweep, since then, along directions fixed to A
	RelativePose pose;         // of the last finished traversal,
	Sweep sweep;               // and what moved on from there

	double tolerance = 0;  // of boxes, in the last finished traversal
	bool isLent = false;   // its memory is the thread's: see keep() and handBack() in Traversal.h
	FrontCounts counts;

	// For answers as much as there may be, as nearly all have a hull: a steady query allocates nothing.
	void makeRoom()
	{
		shrinkRoom(answers, hulls.capacity());
		answers.reserve(hulls.capacity());
	}
	// The bodies have parted: what they took is given back.
	void giveBack()
	{
		clear();
		entries.shrink_to_fit();
		hulls.shrink_to_fit();
		answers.shrink_to_fit();
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
		entries.clear();
		hulls.clear();
		answers.clear();
		motion = motionSince = sweepChangeSince = 0;
	}
};
}  // namespace clod
