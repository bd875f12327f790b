// SPDX-License-Identifier: Zlib
// Point to triangle distance after Ericson, Real-Time Collision Detection (2005), sec. 5.1.5.
#include "clod/query/ContactPointsSurface.h"

#include <algorithm>

namespace clod
{
namespace
{
Vec3 closestPoint(const Triangle& t, const Vec3& p)
{
	const Vec3 ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
	const double d1 = dot(ab, ap), d2 = dot(ac, ap);
	if (d1 <= 0 && d2 <= 0) return t[0];
	const Vec3 bp = p - t[1];
	const double d3 = dot(ab, bp), d4 = dot(ac, bp);
	if (d3 >= 0 && d4 <= d3) return t[1];
	const double vc = d1 * d4 - d3 * d2;
	if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 - d3 > 0) return t[0] + (d1 / (d1 - d3)) * ab;
	const Vec3 cp = p - t[2];
	const double d5 = dot(ab, cp), d6 = dot(ac, cp);
	if (d6 >= 0 && d5 <= d6) return t[2];
	const double vb = d5 * d2 - d1 * d6;
	if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 - d6 > 0) return t[0] + (d2 / (d2 - d6)) * ac;
	const double va = d3 * d6 - d5 * d4;
	if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0 && (d4 - d3) + (d5 - d6) > 0)
		return t[1] + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (t[2] - t[1]);
	const double sum = va + vb + vc;
	if (!(sum > 0)) return t[0];
	return t[0] + (vb / sum) * ab + (vc / sum) * ac;
}

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
		const CullBox& box = hierarchy.cullBox(index);
		const Vec3 center{double(box.center[0]), double(box.center[1]), double(box.center[2])};
		if (length(point - center) - double(box.radius) >= nearest) continue;
		const Node& node = hierarchy.node(index);
		for (const Face& face : hierarchy.faces(node))
			nearest = std::min(nearest, length(point - closestPoint(triangleOf(hierarchy, node, face), point)));
	}
	return nearest;
}

void LeakCheck::prepare(const std::vector<Contact>& contacts)
{
	m_nodesA.clear();
	m_nodesB.clear();
	for (const Contact& contact : contacts)
	{
		m_nodesA.push_back(contact.nodeA);
		m_nodesB.push_back(contact.nodeB);
	}
	sortUnique(m_nodesA);
	sortUnique(m_nodesB);
}

bool LeakCheck::leaks(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const ContactPoint& point,
					  double margin) const
{
	const double depth = -(point.height + margin);
	if (depth <= 0) return false;
	const double limit = kLeakShare * depth;
	if (point.referenceIsA) return distanceToFaces(a, m_nodesA, point.pointOnB, limit) < limit;
	return distanceToFaces(b, m_nodesB, inverse(aFromB) * point.pointOnA, limit) < limit;
}
}  // namespace clod
