// SPDX-License-Identifier: Zlib
// A front as a pair keeps it between queries: what the next walk asks of it, entry by entry. Entries come breadth
// first, so where the children of an opened one lie follows from those before; nodes are met again by the walk itself.
// Bounds are rounded outward to 16 bits and an exponent: coarser ones would wander, as they are widened in each query.
#pragma once
#include <cstddef>
#include <cstring>
#include <vector>

#include "clod/query/FrontEntry.h"

namespace clod
{
enum class Remembered : std::uint8_t
{
	kNothing,
	kBound,          // apart, and the axis
	kCorners,        // near; of those opened,
	kCornersAndAxis  // and of answers
};

// Of an entry of the front before, as of FrontEntry.
struct KeptEntry
{
	float high;
	float apart;  // as the two that follow: of one opened, or the pair of roots apart
	std::uint32_t link;
	std::uint16_t childCount, slot;
	std::uint32_t place;  // in the bytes, of what is remembered of the hulls
	struct Code
	{
		NodePairState state;
		Remembered remembered;
	} code;
};

class PackedFront
{
public:
	bool isEmpty() const { return m_bytes.empty(); }
	void pack(const std::vector<FrontEntry>& entries, const std::vector<CachedSeparation>& hulls);
	// In the same order. Returns how many they are: what is behind them is left as it was.
	std::uint32_t unpack(std::vector<KeptEntry>& entries) const;
	// Precondition: nothing is in `hull`.
	void recall(const KeptEntry& entry, CachedSeparation& hull) const
	{
		if (entry.code.remembered != Remembered::kNothing)
			take(m_bytes.data() + entry.place, entry.code.remembered, hull);
	}
	void clear() { m_bytes.clear(); }
	void giveBack()
	{
		m_bytes.clear();
		m_bytes.shrink_to_fit();
	}

private:
	template <class T>
	static T valueAt(const std::byte* at)
	{
		T value;
		std::memcpy(&value, at, sizeof value);
		return value;
	}
	// Of the upper 24 of 32 bits.
	static float boundOf(std::uint32_t bits)
	{
		bits &= ~0xFFU;
		float bound;
		std::memcpy(&bound, &bits, sizeof bound);
		return bound;
	}
	// Of corners by their head: indices of vertices have a byte each or, of a hull of more than 256, two.
	static constexpr std::uint32_t kWide = 1U << NearCorners::kBits;
	static std::size_t bytesOfVertices(std::uint32_t head) { return (head & 7) << (1 + (head >> NearCorners::kBits)); }
	static std::byte* putCorners(std::byte* at, const NearCorners& corners);  // returns what is behind them
	static void take(const std::byte* from, Remembered remembered, CachedSeparation& hull)
	{
		if (remembered == Remembered::kBound)
		{
			const std::uint64_t packed = valueAt<std::uint64_t>(from);
			hull.kind = CachedSeparation::Kind::kApart;
			hull.lower = boundOf(std::uint32_t(packed) << 8);
			hull.axis = ShortAxis(packed >> 24);
			return;
		}
		hull.kind = CachedSeparation::Kind::kNear;
		const std::uint32_t head = valueAt<std::uint16_t>(from);
		NearCorners& corners = hull.corners;
		corners.head = std::uint16_t(head & ~kWide);
		from += sizeof corners.head;
		if ((head & kWide) != 0)
			std::memcpy(corners.vertices, from, bytesOfVertices(head));
		else
			for (int i = 0; i < 8; ++i) corners.vertices[i] = std::uint16_t(from[i]);
		if (remembered == Remembered::kCornersAndAxis)
			hull.axis = ShortAxis(valueAt<std::uint64_t>(from + bytesOfVertices(head)) & ShortAxis::kMask);
	}

	std::uint32_t m_count = 0;
	std::vector<std::byte> m_bytes;
};
}  // namespace clod
