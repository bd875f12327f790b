// SPDX-License-Identifier: Zlib
// Contact points of one hierarchy against what has no hierarchy: a plane, or triangles of an engine's own mesh. The
// partner counts as exact (no error, unlimited contact area), so the same metric chooses the nodes that answer.
// Frame A is the hierarchy's; B is the partner. Signs as in ContactPoints.h.
#pragma once
#include "clod/Export.h"
#include "clod/manifold/ContactPoints.h"

namespace clod
{
struct ForeignStats
{
	std::uint32_t boxTests = 0, nodes = 0, finestLevel = kNone, coarsestLevel = 0;
	double errorBound = 0;  // the largest certified error of a node that answered
};

class CLOD_API ForeignClipper
{
public:
	// Half space { p : dot(normal, p) <= offset } is solid.
	void clipPlane(const Hierarchy& hierarchy, const Vec3& normal, double offset, const Metric& metric,
				   const PointRules& rules, std::vector<ContactPoint>& points, ForeignStats& stats);
	// One triangle, thin and two-sided: the side is the one the hierarchy's surface faces. (part, index) name it.
	void clipTriangle(const Hierarchy& hierarchy, const Triangle& triangle, std::uint32_t part, std::uint32_t index,
					  const Metric& metric, const PointRules& rules, std::vector<ContactPoint>& points,
					  ForeignStats& stats);

private:
	template <class Separated, class Sink>
	void visit(const Hierarchy& hierarchy, const Metric& metric, const Separated& separated, const Sink& sink,
			   ForeignStats& stats);
	std::vector<std::uint32_t> m_stack, m_visited;
	std::vector<char> m_met;
	std::uint32_t m_visit = 0;
};
}  // namespace clod
