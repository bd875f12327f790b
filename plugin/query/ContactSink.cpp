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

double ContactSink::room(const FrontEntry& pair) const
{
	const double size = double(m_context.a.cullBox(pair.a).radius) + double(m_context.b.cullBox(pair.b).radius);
	return 10 * kHullDistanceAccuracy * (size + m_tolerance + m_context.longestMove) + 4 * m_context.pose.rounding;
}

// The pair is no contact.
void ContactSink::keepBound(HullMemory& memory, const FrontEntry& pair, double lower, const Vec3& direction)
{
	memory.lower = lowerAfter(float(lower), 0);
	for (int i = 0; i < 3; ++i) memory.axis[i] = float(direction[i]);
	const Node &nodeA = m_context.a.node(pair.a), &nodeB = m_context.b.node(pair.b);
	m_largestCover = std::max(m_largestCover, double(nodeA.cover) + double(nodeB.cover));
}

void ContactSink::answer(const FrontEntry& pair, HullMemory& memory)
{
	const Vec3 axis{double(memory.axis[0]), double(memory.axis[1]), double(memory.axis[2])};
	if (provenApart(pair, memory))
	{
		++m_stats.skippedBySlack;
		const Node &nodeA = m_context.a.node(pair.a), &nodeB = m_context.b.node(pair.b);
		m_largestCover = std::max(m_largestCover, double(nodeA.cover) + double(nodeB.cover));
		return;
	}
	if (memory.lower > -std::numeric_limits<float>::infinity())
	{
		++m_stats.hullTests;
		const double lower = sweptSeparationAlong(m_context, pair.a, pair.b, axis);
		if (lower > m_tolerance + room(pair)) return keepBound(memory, pair, lower, axis);
	}
	const bool moves = m_context.longestMove > 0;
	if (moves)
	{
		++m_stats.hullTests;
		const SweptBound bound = canonicalSweptBound(m_context, pair.a, pair.b, m_tolerance);
		if (bound.lower > m_tolerance) return keepBound(memory, pair, bound.lower, bound.normal);
	}
	++m_stats.hullTests;
	const HullDistance distance = canonicalDistance(m_context, pair.a, pair.b, moves ? kInfinity : m_tolerance);
	if (!moves && distance.lower > m_tolerance) return keepBound(memory, pair, distance.lower, distance.normal);
	memory.lower = -std::numeric_limits<float>::infinity();
	m_contacts.push_back(
		{pair.a, pair.b, distance.lower, distance.upper, distance.pointOnA, distance.pointOnB, distance.normal});
}
}  // namespace clod
