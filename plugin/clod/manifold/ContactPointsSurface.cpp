// SPDX-License-Identifier: Zlib
// Which chosen points the reference's surface is too near to.
#include "clod/manifold/ContactPointsSurface.h"

#include <algorithm>

#include "clod/collide/BoxSeparation.h"
#include "clod/hierarchy/InputSurface.h"

namespace clod
{
namespace
{
void sortUnique(std::vector<std::uint32_t>& values)
{
	std::sort(values.begin(), values.end());
	values.erase(std::unique(values.begin(), values.end()), values.end());
}
}  // namespace

double distanceToFaces(const Hierarchy& hierarchy, const std::vector<std::uint32_t>& nodes, const Vec3& point,
					   double limit)
{
	double nearest = limit;
	for (const std::uint32_t index : nodes)
	{
		const OrientedBox& box = hierarchy.cullBox(index);
		if (length(point - centerOf(box)) - double(box.radius) >= nearest) continue;
		const Node& node = hierarchy.node(index);
		for (const Face& face : hierarchy.faces(node))
			nearest = std::min(nearest, std::sqrt(nearestOnTriangle(triangleOf(hierarchy, node, face), point).squared));
	}
	return nearest;
}

void LeakCheck::start(const std::vector<Contact>& contacts)
{
	m_contacts = &contacts;
	m_isGathered = false;
}

void LeakCheck::gatherNodes()
{
	m_isGathered = true;
	m_nodesA.clear();
	m_nodesB.clear();
	for (const Contact& contact : *m_contacts)
	{
		m_nodesA.push_back(contact.nodeA);
		m_nodesB.push_back(contact.nodeB);
	}
	sortUnique(m_nodesA);
	sortUnique(m_nodesB);
}

bool LeakCheck::leaks(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const ContactPoint& point,
					  double margin)
{
	const double depth = -(point.height + margin);
	if (depth <= 0) return false;
	if (!m_isGathered) gatherNodes();
	const double limit = kLeakShare * depth;
	if (point.referenceIsA) return distanceToFaces(a, m_nodesA, point.pointOnB, limit) < limit;
	return distanceToFaces(b, m_nodesB, inverse(aFromB) * point.pointOnA, limit) < limit;
}
}  // namespace clod
