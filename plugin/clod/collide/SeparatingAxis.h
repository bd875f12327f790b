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
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "clod/collide/HullDistance.h"
#include "clod/collide/MotionBound.h"

namespace clod
{
// A vector of unit length, or none, in 39 bits: numbers in steps, towards zero. A separation along it is none too
// large.
class ShortAxis
{
public:
	static constexpr int kBits = 13;
	static constexpr std::uint64_t kMask = (std::uint64_t(1) << 3 * kBits) - 1;
	static constexpr double kStep = 1.0 / (1 << (kBits - 1));

	ShortAxis() = default;
	explicit ShortAxis(std::uint64_t packed) : m_bits(packed) {}
	explicit ShortAxis(const Vec3& v) : m_bits(packed(v.x) | packed(v.y) << kBits | packed(v.z) << 2 * kBits) {}
	std::uint64_t packed() const { return m_bits; }
	Vec3 get() const { return {number(0), number(1), number(2)}; }

private:
	static std::uint64_t packed(double x)
	{
		constexpr double kMost = 1 / kStep - 1;
		return std::uint64_t(std::int64_t(std::min(x / kStep, kMost))) & ((1U << kBits) - 1);
	}
	double number(int which) const
	{
		return kStep * double(std::int64_t(m_bits << (64 - kBits * (which + 1))) >> (64 - kBits));
	}
	std::uint64_t m_bits = 0;
};

// What is remembered of two hulls between queries, in few bytes.
struct CachedSeparation
{
	enum class Kind : std::uint8_t
	{
		kUnknown,
		kApart,  // along an axis
		kNear    // by two points of the hulls of some corners
	};
	ShortAxis axis;   // frame A, from B to A. apart: zero: it is not known; near: it may show them apart all the same
	float lower = 0;  // apart: a bound of the distance, of the support planes across the axis if it is known
	NearCorners corners;  // near
	Kind kind = Kind::kUnknown;

	bool isApart() const { return kind == Kind::kApart; }
	void setApart(double bound, const Vec3& direction)
	{
		kind = Kind::kApart;
		lower = lowerAfter(float(bound), 0);
		axis = ShortAxis(direction);
	}
	// Unless the corners are not known.
	void setNear(const NearCorners& near, const Vec3& direction)
	{
		kind = near.count() > 0 ? Kind::kNear : Kind::kUnknown;
		corners = near;
		axis = ShortAxis(direction);
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
