// SPDX-License-Identifier: Zlib
// A second opinion on the few points that were chosen. Bisector prisms are not Voronoi cells: a triangle that touches a
// sharp corner only with a vertex can leak into the prism of a far face and claim a depth that is not there. A point is
// a leak when the reference's surface is nearer to it than half the depth it claims.
#pragma once
#include <vector>

#include "clod/Export.h"
#include "clod/manifold/ContactPoints.h"

namespace clod
{
inline constexpr double kLeakShare = 0.5;

// Distance from a point (in the hierarchy's frame) to the real faces of the listed nodes; `limit` when all are farther.
double distanceToFaces(const Hierarchy& hierarchy, const std::vector<std::uint32_t>& nodes, const Vec3& point,
					   double limit);

class CLOD_API LeakCheck
{
public:
	// The contacts whose nodes make up the surfaces in touch; they must live while points are checked.
	void start(const std::vector<Contact>& contacts);
	bool leaks(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const ContactPoint& point,
			   double margin);

private:
	void gatherNodes();
	const std::vector<Contact>* m_contacts = nullptr;
	bool m_isGathered = false;  // few points are under a face at all
	std::vector<std::uint32_t> m_nodesA, m_nodesB;
};
}  // namespace clod
