// SPDX-License-Identifier: Zlib
// Hull tests of accepted pairs: cached bound, cached direction, then GJK from the canonical start.
#include "clod/query/ContactSink.h"

#include <algorithm>

namespace clod
{
double ContactSink::room(const FrontEntry& entry) const
{
	const double size = double(m_context.a.cullBox(entry.a).radius) + double(m_context.b.cullBox(entry.b).radius);
	return 10 * kHullDistanceAccuracy * (size + m_tolerance) + 4 * m_context.pose.rounding;
}

void ContactSink::keepBound(FrontEntry& entry, double motion, double lower, const Vec3& direction) const
{
	entry.hullKnown = true;
	entry.hullLower = lower;
	entry.hullStamp = motion;
	for (int i = 0; i < 3; ++i) entry.axis[i] = float(direction[i]);
}

void ContactSink::answer(FrontEntry& entry, double motion)
{
	const Node &nodeA = m_context.a.node(entry.a), &nodeB = m_context.b.node(entry.b);
	const double cover = double(nodeA.cover) + double(nodeB.cover);
	if (provenApart(entry, motion))
	{
		++m_stats.skippedBySlack;
		m_largestCover = std::max(m_largestCover, cover);
		return;
	}
	if (entry.hullKnown)
	{
		const Vec3 axis{double(entry.axis[0]), double(entry.axis[1]), double(entry.axis[2])};
		const double lower =
			separationAlong(contactHull(m_context.a, nodeA), contactHull(m_context.b, nodeB), m_context.pose, axis);
		++m_stats.hullTests;
		if (lower > m_tolerance + room(entry))
		{
			keepBound(entry, motion, lower, axis);
			m_largestCover = std::max(m_largestCover, cover);
			return;
		}
	}
	const HullDistance distance = canonicalDistance(m_context, entry.a, entry.b, m_tolerance);
	++m_stats.hullTests;
	entry.hullKnown = false;
	if (distance.lower > m_tolerance)
	{
		keepBound(entry, motion, distance.lower, distance.normal);
		m_largestCover = std::max(m_largestCover, cover);
		return;
	}
	m_contacts.push_back(
		{entry.a, entry.b, distance.lower, distance.upper, distance.pointOnA, distance.pointOnB, distance.normal});
}
}  // namespace clod
