// SPDX-License-Identifier: Zlib
// Hull tests of accepted pairs: cached bound, cached direction, then GJK from the canonical start.
#include "clod/query/ContactSink.h"

#include <algorithm>

namespace clod
{
void ContactSink::noContact(std::uint32_t a, std::uint32_t b)
{
	const Node &nodeA = m_context.a.node(a), &nodeB = m_context.b.node(b);
	m_largestCover = std::max(m_largestCover, double(nodeA.cover) + double(nodeB.cover));
}

void ContactSink::answer(std::uint32_t a, std::uint32_t b, HullMemory& memory, const HullEvaluations& known)
{
	if (m_hulls.isStillApart(a, b, m_tolerance, memory)) return noContact(a, b);
	const bool moves = m_context.longestMove > 0;
	if (moves)
	{
		if (!known.onTheWay) ++m_stats.hullTests;
		const SweptBound bound =
			known.onTheWay ? *known.onTheWay : canonicalSweptBound(m_context, a, b, m_tolerance, m_tolerance);
		if (bound.lower > m_tolerance)
		{
			HullCull::keepApart(memory, bound.lower, bound.normal);
			return noContact(a, b);
		}
	}
	if (!known.atRest) ++m_stats.hullTests;
	const HullDistance distance = known.atRest ? *known.atRest : canonicalContact(m_context, a, b, m_tolerance);
	if (!moves && distance.lower > m_tolerance)
	{
		HullCull::keepApart(memory, distance.lower, distance.normal);
		return noContact(a, b);
	}
	memory = HullMemory{};
	m_contacts.push_back({a, b, distance.lower, distance.upper, distance.pointOnA, distance.pointOnB, distance.normal});
}

}  // namespace clod
