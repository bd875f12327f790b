// SPDX-License-Identifier: Zlib
// Hull tests of accepted pairs: cached bound, cached direction, then GJK from the canonical start.
#include "clod/query/ContactSink.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace clod
{
namespace
{
constexpr double kInfinity = std::numeric_limits<double>::infinity(), kLeast = std::numeric_limits<double>::denorm_min();
}  // namespace

void sortByNodes(std::vector<Contact>& contacts)
{
	const auto before = [](const Contact& l, const Contact& r)
	{ return std::tie(l.nodeA, l.nodeB) < std::tie(r.nodeA, r.nodeB); };
	if (!std::is_sorted(contacts.begin(), contacts.end(), before)) std::sort(contacts.begin(), contacts.end(), before);
}

void ContactSink::noContact(std::uint32_t a, std::uint32_t b)
{
	m_largestCover = std::max(m_largestCover, m_context.coversOf(a, b));
}

// Beyond the limit not known any better. What was evaluated before may have stopped at the tolerance.
HullDistance ContactSink::distanceAtRest(std::uint32_t a, std::uint32_t b, double limit, const HullEvaluations& known)
{
	if (known.atRest && !(known.atRest->lower > m_tolerance && known.atRest->lower <= limit)) return *known.atRest;
	++m_stats.hullTests;
	return canonicalContact(m_context, a, b, limit);
}

void ContactSink::add(std::uint32_t a, std::uint32_t b, const HullDistance& distance)
{
	m_leastApart = std::min(m_leastApart, distance.lower - m_context.coversOf(a, b));
	if (m_signsOnly)
	{
		const double lower = distance.lower > 0 ? kLeast : 0, upper = distance.upper > 0 ? kInfinity : 0;
		return m_contacts.push_back({a, b, lower, upper, {}, {}, {}});
	}
	m_contacts.push_back({a, b, distance.lower, distance.upper, distance.pointOnA, distance.pointOnB, distance.normal});
}

// Of signs only, a contact takes no distance where an axis shows the hulls apart and they are near all the same: by their
// points, or at some time of the way. What had to be evaluated is handed on.
bool ContactSink::isDecided(std::uint32_t a, std::uint32_t b, CachedSeparation& cached, HullEvaluations& known)
{
	const bool wasNear = cached.kind == CachedSeparation::Kind::kNear;
	double lower = wasNear ? separationAtRest(a, b, cached.axis.get()) : 0;
	if (wasNear && !isBeyond(m_context, a, b, lower, 0)) return false;
	if (!wasNear || !m_hulls.isStillNear(a, b, m_tolerance, cached))
	{
		if (!(m_context.longestMove > 0)) return false;
		if (!known.onTheWay)
		{
			++m_stats.hullTests;
			known.onTheWay = canonicalSweptBound(m_context, a, b, m_tolerance, m_tolerance);
		}
		const SweptBound& way = *known.onTheWay;
		if (way.lower > m_tolerance)
		{
			cached.setApart(way.lower, way.normal);
			return true;
		}
		if (!way.hasPoints) return false;
		if (!wasNear) lower = separationAtRest(a, b, way.normal);
		if (!isBeyond(m_context, a, b, lower, 0)) return false;
		cached.setNear(way.corners, wasNear ? cached.axis.get() : way.normal);
	}
	++m_stats.hullTests;  // in the place of the distance, so that no pair counts more tests than a budget expects
	HullDistance apart;
	apart.lower = lower;
	apart.upper = kInfinity;
	add(a, b, apart);
	return true;
}

// A bound by their planes across an axis, if there is one.
double ContactSink::separationAtRest(std::uint32_t a, std::uint32_t b, const Vec3& axis)
{
	if (axis == Vec3{}) return 0;
	return separationAlong(contactHull(m_context.a, m_context.a.node(a)), contactHull(m_context.b, m_context.b.node(b)),
						   m_context.pose, axis);
}

void ContactSink::answer(std::uint32_t a, std::uint32_t b, CachedSeparation& cached, HullEvaluations& known)
{
	if (m_onlyLists) return;
	const bool areWanted = m_covers == Covers::kWanted;
	const double limit = areWanted ? cullLimit(m_context.a.node(a), m_context.b.node(b), m_tolerance) : m_tolerance;
	if (m_hulls.isStillApart(a, b, limit, cached)) return;
	if (m_signsOnly && !known.atRest && isDecided(a, b, cached, known)) return;
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
	cached.setNear(distance.corners, distance.normal);
	add(a, b, distance);
}

}  // namespace clod
