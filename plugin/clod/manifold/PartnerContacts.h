// SPDX-License-Identifier: Zlib
// Accepted contacts of a hierarchy with what has none: a half space, or triangles of an engine's own mesh. The partner
// counts as exact (no error, unlimited contact area), so the same metric chooses the nodes that answer.
//
// Frame A is the hierarchy's; B is the partner, whose surface has one node (a half space) or one a triangle, in the order
// given (ContactSurface.h).
#pragma once
#include <vector>

#include "clod/Export.h"
#include "clod/query/Query.h"

namespace clod
{
struct PartnerStats
{
	std::uint32_t boxTests = 0, nodes = 0, finestLevel = kNone, coarsestLevel = 0;
	double errorBound = 0;  // the largest certified error of a node that answered
};

class CLOD_API PartnerContacts
{
public:
	// Appends what is within the tolerance of the half space normal . p <= offset, however far: lower = upper = 0.
	void withHalfSpace(const Hierarchy& hierarchy, const Vec3& normal, double offset, const Metric& metric,
					   double tolerance, std::vector<Contact>& contacts, PartnerStats& stats);
	// Of a triangle, which is node `index` of the partner's surface. beneath: what overlaps it may have sunk so far
	// through it; lower and upper are 0 where it has, and else a certified distance.
	void withTriangle(const Hierarchy& hierarchy, const Triangle& triangle, std::uint32_t index, const Vec3& beneath,
					  const Metric& metric, double tolerance, std::vector<Contact>& contacts, PartnerStats& stats);

private:
	template <class Separated, class Distance>
	void visit(const Hierarchy& hierarchy, const Metric& metric, const Separated& apart, const Distance& distanceOf,
			   std::uint32_t partner, std::vector<Contact>& contacts, PartnerStats& stats);
	std::vector<std::uint32_t> m_stack, m_visited;  // when each node, of any hierarchy, was visited last
	std::uint32_t m_visit = 0;
};
}  // namespace clod
