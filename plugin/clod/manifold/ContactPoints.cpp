// SPDX-License-Identifier: Zlib
#include "clod/manifold/ContactPoints.h"

namespace clod
{
int ClusterSet::pointCount() const
{
	int count = 0;
	for (const ContactCluster& cluster : slots) count += cluster.count;
	return count;
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
