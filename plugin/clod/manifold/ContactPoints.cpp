// SPDX-License-Identifier: Zlib
#include "clod/manifold/ContactPoints.h"

#include <cmath>
#include <numeric>

#include "clod/collide/Room.h"

namespace clod
{
namespace
{
// By a vector along the axis, as long as the angle. Small angles by series, to 1e-10: this is asked very often.
Mat3 turnBy(const Vec3& angle)
{
	const Vec3 half = 0.5 * angle;
	const double squared = lengthSquared(half);
	double cosine = 1, sineShare = 1;  // sine over angle
	if (squared < 0.25)
	{
		cosine = 1 - squared / 2 * (1 - squared / 12 * (1 - squared / 30 * (1 - squared / 56)));
		sineShare = 1 - squared / 6 * (1 - squared / 20 * (1 - squared / 42 * (1 - squared / 72)));
	}
	else
	{
		const double size = std::sqrt(squared);
		cosine = std::cos(size);
		sineShare = std::sin(size) / size;
	}
	return rotationFromQuaternion(sineShare * half.x, sineShare * half.y, sineShare * half.z, cosine);
}
}  // namespace

Transform aFromBAfter(const PairBody& a, const PairBody& b, const Transform& aFromB, double timeStep)
{
	Transform after = aFromB;
	if (b.turning() != Vec3{})
	{
		const Mat3 turn = turnBy(timeStep * b.angular);
		after = {turn * aFromB.rotation, b.center + turn * (aFromB.translation - b.center)};
	}
	if (a.angular == Vec3{}) after.translation += timeStep * (b.linear - a.linear);
	else
	{
		const Mat3 back = transposed(turnBy(timeStep * a.angular));
		const Vec3 apart = after.translation - a.center + timeStep * (b.linear - a.linear);
		after = {back * after.rotation, a.center + back * apart};
	}
	return after;
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
	m_slots = 0;
	for (std::size_t slot = 0; slot < set.slots.size(); ++slot)
	{
		const ContactCluster& cluster = set.slots[slot];
		m_counts[slot] = std::uint8_t(cluster.count);
		if (cluster.count > 0) m_slots = slot + 1;
		m_points.insert(m_points.end(), cluster.points.begin(), cluster.points.begin() + cluster.count);
	}
}

void HeldClusters::copyTo(ClusterSet& set) const
{
	auto point = m_points.begin();
	set.slots.clear();
	for (std::size_t slot = 0; slot < m_slots; ++slot)
	{
		ContactCluster& cluster = set.slots[slot];
		cluster.count = int(m_counts[slot]);
		for (std::size_t i = 0; i < m_counts[slot]; ++i) cluster.points[i] = *point++;
	}
}

void HeldClusters::linkToThemselves()
{
	auto point = m_points.begin();
	for (std::uint32_t slot = 0; slot < m_slots; ++slot)
		for (std::uint32_t i = 0; i < m_counts[slot]; ++i) (point++)->previous = slot * kClusterPoints + i;
}
}  // namespace clod
