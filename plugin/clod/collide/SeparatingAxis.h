// SPDX-License-Identifier: Zlib
// The separating-axis cache: what two hulls showed at one pose, tried at the next before GJK. Nothing of it is taken on
// trust: an axis is tried by its support planes (separationAlong), a bound is widened by the motion since.
//
// A pair that has a place of its own, such as an entry of the front, keeps a CachedSeparation there. SeparatingAxes is
// a table for pairs that have none.
//
// Based on: van den Bergen, "A Fast and Robust GJK Implementation for Collision Detection of Convex Objects", 1999
// (incremental separating-axis GJK).
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "clod/collide/MotionBound.h"

namespace clod
{
struct CachedSeparation
{
	enum class Kind : std::uint8_t
	{
		kUnknown,
		kApart,  // along an axis
		kNear    // by two points
	};
	Kind kind = Kind::kUnknown;
	float lower = 0;  // apart: a bound of the distance, of the support planes across the axis if it is known
	Float3 onA;       // frame A. apart: the axis, unit, from B to A, or zero: it is not known; near: a point of hull a
	Float3 onB;       // frame B. near: a point of hull b
	Float3 between;   // frame A. near: an axis that may show that the hulls are apart all the same

	bool isApart() const { return kind == Kind::kApart; }
	void setApart(double bound, const Vec3& axis)
	{
		kind = Kind::kApart;
		lower = lowerAfter(float(bound), 0);
		onA = toFloat3(axis);
	}
	void setNear(const Vec3& pointOnA, const Vec3& pointOnB, const Vec3& axis)
	{
		kind = Kind::kNear;
		onA = toFloat3(pointOnA);
		onB = toFloat3(pointOnB);
		between = toFloat3(axis);
	}
};

// Axes by the two numbers of a pair. What falls into a place drives out what was there.
class SeparatingAxes
{
public:
	struct Entry
	{
		std::uint32_t a = kNobody, b = kNobody;
		Float3 axis;  // frame A, unit, from B to A
		bool isOf(std::uint32_t ofA, std::uint32_t ofB) const { return a == ofA && b == ofB; }
	};
	static constexpr std::uint32_t kNobody = 0xFFFFFFFFu;  // instead of a number: with any partner

	// Where the axis of a pair is, if it is, and goes.
	Entry& at(std::uint32_t a, std::uint32_t b)
	{
		const std::uint64_t pair = std::uint64_t(a) << 32 | b;
		return m_entries[std::size_t((pair * 0x9E3779B97F4A7C15u) >> 40) & (m_entries.size() - 1)];
	}
	// Room for so many pairs, should they come again.
	void reserve(std::size_t pairs)
	{
		if (kSlotsAPair * pairs <= m_entries.size()) return;
		std::size_t size = m_entries.size();
		while (size < kSlotsAPair * pairs) size *= 2;
		m_entries.assign(size, Entry{});
	}

private:
	// Of 498 pairs 450 were told apart by an axis, 262 with four (docs/tried.md, what the cache saves).
	static constexpr std::size_t kSlotsAPair = 16;
	std::vector<Entry> m_entries = std::vector<Entry>(1024);
};
}  // namespace clod
