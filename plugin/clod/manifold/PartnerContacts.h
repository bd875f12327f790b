// SPDX-License-Identifier: Zlib
// Accepted contacts of a hierarchy with what has none: a half space, or triangles of an engine's own mesh. The partner
// counts as exact (no error, unlimited contact area), so the same metric chooses the nodes that answer.
//
// Frame A is the hierarchy's; B is the partner, whose surface has one node (a half space) or one a triangle, in the order
// given (ContactSurface.h).
#pragma once
#include <functional>
#include <vector>

#include "clod/Export.h"
#include "clod/collide/Triangle.h"
#include "clod/query/Query.h"

namespace clod
{
struct PartnerStats
{
	std::uint32_t boxTests = 0, nodes = 0, finestLevel = kNone, coarsestLevel = 0;
	double errorBound = 0;  // the largest certified error of a node that answered
};

// Those of a sheet near a body, in the sheet's frame.
struct NearTriangles
{
	std::vector<Triangle> corners;
	std::vector<Vec3> normals;
	std::vector<std::uint8_t> mayMeet;  // the others are their neighbours only
	void clear()
	{
		corners.clear();
		normals.clear();
		mayMeet.clear();
	}
	// False, and left out, where it has no area.
	bool add(const Triangle& triangle, bool isToMeet = true)
	{
		const Vec3 normal = normalized(cross(triangle[1] - triangle[0], triangle[2] - triangle[0]));
		if (normal == Vec3{}) return false;
		corners.push_back(triangle);
		normals.push_back(normal);
		mayMeet.push_back(isToMeet);
		return true;
	}
};

class CLOD_API PartnerContacts
{
public:
	// Appends what is within the tolerance of the half space normal . p <= offset, however far: lower = upper = 0.
	void withHalfSpace(const Hierarchy& hierarchy, const Vec3& normal, double offset, const Metric& metric,
					   double tolerance, std::vector<Contact>& contacts, PartnerStats& stats);
	// To which side of a triangle's plane, frame A, does the body belong? Below zero: beneath.
	using SideOf = std::function<double(const Vec3& normal, double offset)>;
	// Of triangles, which are the nodes of the partner's surface; none where nothing is within the tolerance. lower and upper
	// are 0 where one has been sunk through, at most that deep, and else a certified distance.
	void withTriangles(const Hierarchy& hierarchy, const NearTriangles& triangles, const Transform& aFromB,
					   const SideOf& sideOf, double depth, const Metric& metric, double tolerance,
					   std::vector<Contact>& contacts, PartnerStats& stats);
	// By how much the pair may move (MotionBound.h) before withTriangles() can find something, whatever the sides; at most
	// `cap`. <= 0: it may already.
	double safeMotion(const Hierarchy& hierarchy, const NearTriangles& triangles, const Transform& aFromB,
					  const Metric& metric, double tolerance, double cap, PartnerStats& stats);

private:
	class Rule;
	template <class Separated, class Answer>
	void visit(const Hierarchy& hierarchy, const Rule& rule, const Separated& apart, const Answer& answer,
			   PartnerStats& stats);
	std::vector<std::uint32_t> m_stack, m_visited;  // when each node, of any hierarchy, was visited last
	std::uint32_t m_visit = 0;
};
}  // namespace clod
