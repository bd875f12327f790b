// SPDX-License-Identifier: Zlib
// An entry is its code and slot in four bits each and `high` in three bytes; if it is opened or the pair of roots
// apart, also the number of its children in one and `apart` in three. Numbers too long for that stand before it, after
// a code of their own. What is remembered of the hulls comes last: a bound and an axis, or corners and, of an answer,
// an axis. Bytes are read and written eight at once.
#include "clod/query/PackedFront.h"

#include "clod/collide/Room.h"

namespace clod
{
namespace
{
using State = NodePairState;
// What the code of an entry tells.
constexpr KeptEntry::Code kCodes[] = {
	{State::kSeparated, Remembered::kNothing},    {State::kElsewhere, Remembered::kNothing},
	{State::kOpenA, Remembered::kNothing},        {State::kOpenA, Remembered::kCorners},
	{State::kOpenB, Remembered::kNothing},        {State::kOpenB, Remembered::kCorners},
	{State::kHullsApart, Remembered::kNothing},   {State::kHullsApart, Remembered::kBound},
	{State::kAnswer, Remembered::kNothing},       {State::kAnswer, Remembered::kBound},
	{State::kAnswer, Remembered::kCornersAndAxis}};
constexpr std::uint32_t kLong = 15;  // the code
// By state and what was seen of the hulls; what no code tells is forgotten.
constexpr std::uint8_t kCodeOf[][4] = {{0, 0, 0, 0}, {1, 1, 1, 0}, {2, 2, 3, 0},
									   {4, 4, 5, 0}, {6, 7, 6, 0}, {8, 9, 10, 0}};
constexpr std::size_t kOfEntry = 4, kOfOpened = 4, kOfLong = 5, kBeyond = 8;
constexpr std::size_t kOfBound = 8, kOfHead = 2, kMostOfVertices = sizeof(NearCorners::vertices), kOfAxis = 5;
constexpr std::size_t kMost = kOfLong + kOfEntry + kOfOpened + kOfHead + kMostOfVertices + kOfAxis;

bool hasApart(std::uint32_t state)
{
	constexpr auto bit = [](State each) { return 1U << std::uint32_t(each); };
	constexpr std::uint32_t kThose = bit(State::kOpenA) | bit(State::kOpenB) | bit(State::kSeparated);
	return (kThose >> state & 1) != 0;
}

// The upper 24 bits of a float no less, or no more, than the number.
std::uint32_t upperBits(float bound)
{
	std::int32_t bits;
	std::memcpy(&bits, &bound, sizeof bits);
	return (std::uint32_t(bits) + (std::uint32_t(~(bits >> 31)) & 0xFF)) >> 8;
}
std::uint32_t lowerBits(float bound)
{
	std::int32_t bits;
	std::memcpy(&bits, &bound, sizeof bits);
	return (std::uint32_t(bits) + (std::uint32_t(bits >> 31) & 0xFF)) >> 8;
}
template <class T>
void put(std::byte* at, T value)
{
	std::memcpy(at, &value, sizeof value);
}
}  // namespace

std::byte* PackedFront::putCorners(std::byte* at, const NearCorners& corners)
{
	std::uint8_t narrow[8];
	std::uint32_t all = 0, head = corners.head;
	for (int i = 0; i < 8; ++i)
	{
		narrow[i] = std::uint8_t(corners.vertices[i]);
		all |= corners.vertices[i];
	}
	if (all > 0xFF)
	{
		head |= kWide;
		std::memcpy(at + kOfHead, corners.vertices, sizeof corners.vertices);
	}
	else
		std::memcpy(at + kOfHead, narrow, sizeof narrow);
	put(at, std::uint16_t(head));
	return at + kOfHead + bytesOfVertices(head);
}

void PackedFront::pack(const std::vector<FrontEntry>& entries, const std::vector<CachedSeparation>& hulls)
{
	thread_local std::vector<std::byte> room;
	const std::size_t most = entries.size() * kMost + kBeyond;
	if (room.size() < most) room.resize(most);
	std::byte *const start = room.data(), *at = start;
	const CachedSeparation* const allHulls = hulls.data();
	for (const FrontEntry *entry = entries.data(), *end = entry + entries.size(); entry < end; ++entry)
	{
		const std::uint32_t state = std::uint32_t(entry->state), slot = entry->slot, count = entry->childCount;
		const CachedSeparation* hull = nullptr;
		std::uint32_t code = kCodeOf[state][0];
		if (entry->hull != kNone)
		{
			hull = allHulls + entry->hull;
			code = kCodeOf[state][std::uint32_t(hull->kind)];
		}
		if (slot > 0xF || count > 0xFF)
		{
			put(at, kLong | slot << 8 | std::uint64_t(count) << 24);
			at += kOfLong;
		}
		put(at, code | (slot & 0xF) << 4 | upperBits(entry->high) << 8);
		at += kOfEntry;
		if (hasApart(state))
		{
			put(at, (count & 0xFF) | lowerBits(entry->apart) << 8);
			at += kOfOpened;
		}
		const Remembered remembered = kCodes[code].remembered;
		if (remembered == Remembered::kNothing) continue;
		if (remembered == Remembered::kBound)
		{
			put(at, lowerBits(hull->lower) | hull->axis.packed() << 24);
			at += kOfBound;
			continue;
		}
		at = putCorners(at, hull->corners);
		if (remembered == Remembered::kCorners) continue;
		put(at, hull->axis.packed());
		at += kOfAxis;
	}
	m_count = std::uint32_t(entries.size());
	at += kBeyond;
	m_bytes.clear();
	shrinkRoom(m_bytes, std::size_t(at - start));
	m_bytes.assign(start, at);
}

std::uint32_t PackedFront::unpack(std::vector<KeptEntry>& entries) const
{
	if (m_bytes.empty()) return 0;
	if (entries.size() < m_count) entries.resize(m_count);
	std::uint32_t next = 1;  // the children of the root
	const std::byte *const start = m_bytes.data(), *at = start;
	for (KeptEntry *entry = entries.data(), *end = entry + m_count; entry < end; ++entry)
	{
		std::uint64_t eight = valueAt<std::uint64_t>(at), longer = 0;
		if ((eight & 0xF) == kLong)
		{
			longer = eight;
			at += kOfLong;
			eight = valueAt<std::uint64_t>(at);
		}
		const KeptEntry::Code code = entry->code = kCodes[eight & 0xF];
		entry->slot = std::uint16_t(longer != 0 ? longer >> 8 : eight >> 4 & 0xF);
		entry->high = boundOf(std::uint32_t(eight));
		at += kOfEntry;
		if (hasApart(std::uint32_t(code.state)))
		{
			const std::uint32_t more = std::uint32_t(eight >> 32);
			entry->apart = boundOf(more);
			entry->link = next;
			entry->childCount = std::uint16_t(longer != 0 ? longer >> 24 : more & 0xFF);
			next += entry->childCount;
			at += kOfOpened;
		}
		entry->place = std::uint32_t(at - start);
		if (code.remembered == Remembered::kBound)
			at += kOfBound;
		else if (code.remembered != Remembered::kNothing)
		{
			at += kOfHead + bytesOfVertices(valueAt<std::uint16_t>(at));
			if (code.remembered == Remembered::kCornersAndAxis) at += kOfAxis;
		}
	}
	return m_count;
}
}  // namespace clod
