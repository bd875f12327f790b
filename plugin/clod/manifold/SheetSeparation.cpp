// SPDX-License-Identifier: Zlib
#include "clod/manifold/SheetSeparation.h"

#include <xxhash.h>

#include <algorithm>

#include "clod/collide/Box.h"
#include "clod/collide/MotionBound.h"

namespace clod
{
namespace
{
std::uint64_t hashOf(const Triangle& triangle)
{
	return XXH3_64bits(triangle.data(), sizeof(triangle));
}
}  // namespace

// Turns are about where the triangles are: a mesh's own origin may be far away.
RelativePose SheetSeparation::about(const Hierarchy& hierarchy, const Transform& aFromB) const
{
	return RelativePose({aFromB.rotation, aFromB * m_middle},
						std::max(hierarchy.originRadius(), length(m_middle) + m_radius));
}

bool SheetSeparation::holds(const Hierarchy& hierarchy, const Transform& aFromB, const Metric& metric, double tolerance)
{
	if (!m_motion.isKnown() || !same(metric, m_metric)) return false;
	const double moved = motionBound(m_pose, about(hierarchy, aFromB), hierarchy.originRadius(), m_radius);
	if (!m_motion.allows(moved + std::max(0.0, tolerance - m_tolerance))) return false;
	m_motion.use();
	return true;
}

void SheetSeparation::listOthers(const NearTriangles& triangles, NearTriangles& others) const
{
	others.clear();
	for (std::size_t i = 0; i < triangles.corners.size(); ++i)
	{
		if (!triangles.mayMeet[i] || std::binary_search(m_known.begin(), m_known.end(), hashOf(triangles.corners[i]))) continue;
		others.add(triangles.corners[i]);
	}
}

bool SheetSeparation::seek(PartnerContacts& contacts, const Hierarchy& hierarchy, const NearTriangles& triangles,
						   const Transform& aFromB, const Metric& metric, double tolerance, double farthest,
						   PartnerStats& stats)
{
	if (triangles.corners.empty() || !m_motion.isToBeSought()) return false;
	Box box = Box::none();
	for (const Triangle& triangle : triangles.corners)
		for (const Vec3& corner : triangle) box.add(corner);
	m_middle = 0.5 * (box.low + box.high);
	m_radius = 0.5 * length(box.high - box.low);
	m_pose = about(hierarchy, aFromB);
	m_metric = metric;
	m_tolerance = tolerance;
	const double motion = contacts.safeMotion(hierarchy, triangles, aFromB, metric, tolerance, farthest, stats);
	m_motion.set(motion);
	m_known.clear();
	if (motion > 0)
		for (const Triangle& triangle : triangles.corners) m_known.push_back(hashOf(triangle));
	std::sort(m_known.begin(), m_known.end());
	return motion > 0;
}
}  // namespace clod
