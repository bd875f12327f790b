// SPDX-License-Identifier: Zlib
// Hull tests of accepted pairs: cached bound, cached direction, then GJK from the canonical start.
#include "clod/query/ContactSink.h"

#include <algorithm>
#include <limits>

namespace clod
{
namespace
{
constexpr double kInfinity = std::numeric_limits<double>::infinity();
}

void ContactSink::noContact(const FrontEntry& pair)
{
	const Node &nodeA = m_context.a.node(pair.a), &nodeB = m_context.b.node(pair.b);
	m_largestCover = std::max(m_largestCover, double(nodeA.cover) + double(nodeB.cover));
}

void ContactSink::answer(const FrontEntry& pair, HullMemory& memory)
{
	if (m_hulls.isStillApart(pair.a, pair.b, m_tolerance, memory)) return noContact(pair);
	const bool moves = m_context.longestMove > 0;
	if (moves)
	{
		++m_stats.hullTests;
		const SweptBound bound = canonicalSweptBound(m_context, pair.a, pair.b, m_tolerance);
		if (bound.lower > m_tolerance)
		{
			HullCull::keep(memory, bound.lower, bound.normal);
			return noContact(pair);
		}
	}
	++m_stats.hullTests;
	const HullDistance distance = canonicalDistance(m_context, pair.a, pair.b, moves ? kInfinity : m_tolerance);
	if (!moves && distance.lower > m_tolerance)
	{
		HullCull::keep(memory, distance.lower, distance.normal);
		return noContact(pair);
	}
	memory = HullMemory{};
	m_contacts.push_back(
		{pair.a, pair.b, distance.lower, distance.upper, distance.pointOnA, distance.pointOnB, distance.normal});
}

void NearPairs::answer(const FrontEntry& pair, HullMemory& memory)
{
	if (m_hulls.isApart(pair.a, pair.b, m_tolerance, memory)) return;
	m_pairs.push_back({pair.a, pair.b, m_ofContacts, kInfinity, {}, {}, {}});
}
}  // namespace clod
