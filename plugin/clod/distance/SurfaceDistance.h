// SPDX-License-Identifier: Zlib
// How far apart two bodies are: the nearest pair of accepted nodes, whatever their level, or of the input surfaces; and
// the pairs of leaves near each other. Each search starts from the roots, so what it finds is a function of the pose.
#pragma once
#include "clod/query/NearestPair.h"

namespace clod
{
// Directions that pairs of leaves were seen to be apart along, tried first the next time: most pairs that are near by
// their boxes are met again. What does not fit is forgotten.
class RememberedDirections
{
public:
	struct Entry
	{
		std::uint32_t a = kNone, b = kNone;
		float direction[3] = {0, 0, 0};  // frame A, from B to A
		bool isOf(std::uint32_t nodeA, std::uint32_t nodeB) const { return a == nodeA && b == nodeB; }
		Entry with(std::uint32_t nodeA, std::uint32_t nodeB) const
		{
			return {nodeA, nodeB, {direction[0], direction[1], direction[2]}};
		}
	};
	// Where the direction of a pair, or of one leaf and kNone, is, if it is, and goes.
	Entry& at(std::uint32_t a, std::uint32_t b)
	{
		const std::uint64_t pair = std::uint64_t(a) << 32 | b;
		return m_entries[std::size_t((pair * 0x9E3779B97F4A7C15u) >> 40) & (m_entries.size() - 1)];
	}
	// Room for so many, should they come again.
	void reserve(std::size_t pairs)
	{
		constexpr std::size_t kSlotsAPair = 16;
		if (kSlotsAPair * pairs <= m_entries.size()) return;
		std::size_t size = kFewest;
		while (size < kSlotsAPair * pairs) size *= 2;
		m_entries.assign(size, Entry{});
	}

private:
	static constexpr std::size_t kFewest = 1024;
	std::vector<Entry> m_entries = std::vector<Entry>(kFewest);
};

struct SurfaceSearchScratch : NearestPairScratch
{
	RememberedDirections directions;
};

// The smallest tolerance at which a traversal reports a contact: over all accepted pairs and the ways to them, the
// smallest max(hull distance, culling separations on the way). That is the smallest hull distance, but for pairs met
// through shared children only, whose parents' boxes need not enclose their hulls. Hull distances are upper ends of the
// certified bracket from the canonical start. Each pair is opened once at most.
double closestDistance(const QueryContext& context, const StopRule& rule, NearestPairScratch& scratch,
					   QueryStats& stats);

// The distance of the two input surfaces, from the pairs of leaves (exact mode's tree).
struct SurfaceDistance
{
	double low, high;  // certified; both 0 where two leaves overlap or touch
	double value;      // the upper end of the nearest pair's bracket; infinite where no pair is nearer than known
};
// known: pairs beyond it are not looked for.
SurfaceDistance surfaceDistance(const QueryContext& context, double known, SurfaceSearchScratch& scratch,
								QueryStats& stats);

// Every pair of leaves within the tolerance, as contacts, in no particular order.
void gatherLeafPairs(const QueryContext& context, double tolerance, SurfaceSearchScratch& scratch,
					 std::vector<Contact>& pairs, QueryStats& stats);
}  // namespace clod
