// SPDX-License-Identifier: Zlib
// Hull tests of accepted pairs: cached bound, cached direction, then GJK from the canonical start.
#include "clod/query/ContactSink.h"

#include <algorithm>
#include <tuple>

namespace clod
{
void sortByNodes(std::vector<Contact>& contacts)
{
	const auto before = [](const Contact& l, const Contact& r)
	{ return std::tie(l.nodeA, l.nodeB) < std::tie(r.nodeA, r.nodeB); };
	if (!std::is_sorted(contacts.begin(), contacts.end(), before)) std::sort(contacts.begin(), contacts.end(), before);
}

void ContactSink::noContact(std::uint32_t a, std::uint32_t b)
{
	const Node &nodeA = m_context.a.node(a), &nodeB = m_context.b.node(b);
	m_largestCover = std::max(m_largestCover, double(nodeA.cover) + double(nodeB.cover));
}

// Beyond the limit not known any better. What was evaluated before may have stopped at the tolerance.
HullDistance ContactSink::distanceAtRest(std::uint32_t a, std::uint32_t b, double limit, const HullEvaluations& known)
{
	if (known.atRest && !(known.atRest->lower > m_tolerance && known.atRest->lower <= limit)) return *known.atRest;
	++m_stats.hullTests;
	return canonicalContact(m_context, a, b, limit);
}

void ContactSink::answer(std::uint32_t a, std::uint32_t b, CachedSeparation& cached, const HullEvaluations& known)
{
	if (m_onlyLists) return;
	const bool areWanted = m_covers == Covers::kWanted;
	const double limit = areWanted ? cullLimit(m_context.a.node(a), m_context.b.node(b), m_tolerance) : m_tolerance;
	if (m_hulls.isStillApart(a, b, limit, cached)) return;
	const bool moves = m_context.longestMove > 0;
	// What was a contact most often is one where it is: the way need not be looked at then.
	const bool wasNear = moves && cached.kind == CachedSeparation::Kind::kNear;
	bool isNear = wasNear && m_hulls.isStillNear(a, b, m_tolerance, cached);
	std::optional<HullDistance> atRest;
	if (wasNear && !isNear)
	{
		atRest = distanceAtRest(a, b, limit, known);
		isNear = atRest->upper + roomOf(m_context, a, b, m_tolerance) < m_tolerance;
	}
	if (moves && !isNear)
	{
		if (!known.onTheWay) ++m_stats.hullTests;
		const SweptBound bound =
			known.onTheWay ? *known.onTheWay : canonicalSweptBound(m_context, a, b, m_tolerance, m_tolerance);
		if (bound.lower > m_tolerance)
		{
			cached.setApart(bound.lower, bound.normal);
			if (!areWanted) return;
			if (!atRest) atRest = distanceAtRest(a, b, limit, known);
			if (!(atRest->lower > limit)) noContact(a, b);
			return;
		}
	}
	const HullDistance distance = atRest ? *atRest : distanceAtRest(a, b, limit, known);
	if (!moves && distance.lower > m_tolerance)
	{
		cached.setApart(distance.lower, distance.normal);
		if (!(distance.lower > limit)) noContact(a, b);
		return;
	}
	cached.setNear(distance.pointOnA, m_context.pose.directionToB(distance.pointOnB - m_context.pose.translation));
	m_contacts.push_back({a, b, distance.lower, distance.upper, distance.pointOnA, distance.pointOnB, distance.normal});
}

}  // namespace clod
