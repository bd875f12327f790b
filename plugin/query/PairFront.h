// SPDX-License-Identifier: Zlib
// The bounding volume test tree of one query, kept for the next: every visited pair in preorder, with the last
// distances and the motion at which they were measured. A cache: see Traversal.h for what it may decide.
//
// Based on: Otaduy & Lin 2003, sec. 3.3 (generalised front tracking of Ehmann & Lin 2001). Departs from it: the whole
// tree above the front is kept, so that raising the front needs no search, and pairs that cannot have changed are
// skipped.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "clod/query/BoxSeparation.h"

namespace clod
{
enum class PairState : std::uint8_t
{
	kSeparated,  // culling volumes are farther apart than the tolerance
	kOpenA,      // replaced by the children of a
	kOpenB,      // replaced by the children of b
	kAnswer,     // accepted by the stop rule, culling volumes within the tolerance
	kDuplicate   // visited already through another parent
};

struct FrontEntry
{
	std::uint32_t a, b;
	std::uint32_t end;  // one past the last entry below this one
	PairState state;
	bool hullKnown;     // hullLower and axis are set
	float axis[3];      // frame A: the direction hullLower was measured along
	double separation;  // of the culling volumes, when the motion was boxStamp
	double boxStamp;
	double hullLower;  // lower bound of the hull distance, when the motion was hullStamp
	double hullStamp;
};
static_assert(sizeof(FrontEntry) == 64);

// A pair that is being opened.
struct OpenPair
{
	const std::uint32_t* children;
	std::uint32_t next = 0, count;
	std::uint32_t entry;     // in PairFront::entries
	std::uint32_t oldChild;  // in PairFront::previous, of the next child; kNone: none
	std::uint32_t fixed;     // the node that is not opened
	bool opensA;
	bool placed = false;  // fixedBox is set
	PlacedBox fixedBox;
};

// Set of pairs with an O(1) clear. Open addressing; grows by doubling.
class VisitedPairs
{
public:
	void clear()
	{
		if (++m_epoch == 0)
		{
			m_slots.assign(m_slots.size(), Slot{});
			m_epoch = 1;
		}
		m_count = 0;
	}
	// False when it was there already.
	bool insert(std::uint32_t a, std::uint32_t b)
	{
		if (2 * (m_count + 1) > m_slots.size()) grow();
		Slot& slot = find(a, b);
		if (slot.epoch == m_epoch) return false;
		slot = {a, b, m_epoch};
		++m_count;
		return true;
	}

private:
	struct Slot
	{
		std::uint32_t a = 0, b = 0, epoch = 0;
	};
	Slot& find(std::uint32_t a, std::uint32_t b)
	{
		const std::uint64_t key = (std::uint64_t(a) << 32 | b) * 0x9E3779B97F4A7C15u;
		std::size_t i = std::size_t(key >> 40) & (m_slots.size() - 1);  // bits that depend on both indices
		while (m_slots[i].epoch == m_epoch && !(m_slots[i].a == a && m_slots[i].b == b))
			i = (i + 1) & (m_slots.size() - 1);
		return m_slots[i];
	}
	void grow()
	{
		const std::vector<Slot> old = std::move(m_slots);
		m_slots.assign(old.empty() ? 1024 : 2 * old.size(), Slot{});
		for (const Slot& slot : old)
			if (slot.epoch == m_epoch) find(slot.a, slot.b) = slot;
	}
	std::vector<Slot> m_slots;
	std::size_t m_count = 0;
	std::uint32_t m_epoch = 1;
};

struct PairFront
{
	std::vector<FrontEntry> entries;   // of the last finished traversal, preorder; [0] is the pair of roots
	std::vector<FrontEntry> previous;  // the one before, read while entries is written
	std::vector<OpenPair> open;        // stack of the running traversal
	VisitedPairs visited;
	double motion = 0;  // accumulated bound of the relative motion (MotionBound.h)

	void clear()
	{
		entries.clear();
		previous.clear();
		motion = 0;
	}
};
}  // namespace clod
