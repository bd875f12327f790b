// SPDX-License-Identifier: Zlib
#include "clod/manifold/ContactPoints.h"

#include <cmath>
#include <numeric>

#include "clod/collide/Room.h"

namespace clod
{
namespace
{
Transform movedBy(const PairBody& body, const Transform& pose, double timeStep)
{
	if (body.linear == Vec3{} && body.angular == Vec3{}) return pose;
	const double angle = timeStep * length(body.angular);
	const Vec3 axis = normalized(body.angular);
	const double sine = std::sin(0.5 * angle);
	const Mat3 turn = rotationFromQuaternion(sine * axis.x, sine * axis.y, sine * axis.z, std::cos(0.5 * angle));
	return {turn * pose.rotation, body.center + timeStep * body.linear + turn * (pose.translation - body.center)};
}
}  // namespace

Transform aFromBAfter(const PairBody& a, const PairBody& b, const Transform& aFromB, double timeStep)
{
	return inverse(movedBy(a, Transform{}, timeStep)) * movedBy(b, aFromB, timeStep);
}

int ClusterSet::pointCount() const
{
	int count = 0;
	for (const ContactCluster& cluster : slots) count += cluster.count;
	return count;
}

std::size_t HeldClusters::firstOf(std::size_t slot) const
{
	return std::accumulate(m_counts.begin(), m_counts.begin() + slot, std::size_t(0));
}

void HeldClusters::hold(const ClusterSet& set)
{
	m_points.clear();
	shrinkRoom(m_points, std::size_t(set.pointCount()));
	m_points.reserve(std::size_t(set.pointCount()));
	for (std::size_t slot = 0; slot < set.slots.size(); ++slot)
	{
		const ContactCluster& cluster = set.slots[slot];
		m_counts[slot] = std::uint8_t(cluster.count);
		m_points.insert(m_points.end(), cluster.points.begin(), cluster.points.begin() + cluster.count);
	}
}

void HeldClusters::copyTo(ClusterSet& set) const
{
	auto point = m_points.begin();
	for (std::size_t slot = 0; slot < set.slots.size(); ++slot)
	{
		set.slots[slot].count = int(m_counts[slot]);
		for (std::size_t i = 0; i < m_counts[slot]; ++i)
			static_cast<HeldPoint&>(set.slots[slot].points[i]) = *point++;
	}
}

void HeldClusters::linkToThemselves()
{
	auto point = m_points.begin();
	for (std::uint32_t slot = 0; slot < m_counts.size(); ++slot)
		for (std::uint32_t i = 0; i < m_counts[slot]; ++i) (point++)->previous = slot * kClusterPoints + i;
}

void carryWithB(ClusterSet& set, const Transform& bodyMotion)
{
	for (ContactCluster& cluster : set.slots)
		for (int i = 0; i < cluster.count; ++i)
		{
			ClusterPoint& old = cluster.points[std::size_t(i)];
			// Compared with points on A, so the gap between the surfaces is kept along the normal.
			old.normalWithB = bodyMotion.rotation * old.point.normal;
			old.placeWithB = bodyMotion * old.point.pointOnA;
		}
}
}  // namespace clod
