// SPDX-License-Identifier: Zlib
// The real faces of one node, moved into another body's frame, and which of them can meet the prism over a face there
// now or at the end of the step: four at a time, before any is clipped (ContactPoints.h).
#pragma once
#include <vector>

#include "clod/manifold/FacePrism.h"
#include "clod/collide/RelativeMotion.h"

namespace clod
{
inline constexpr std::uint32_t kFaceLanes = 4;
// Of each corner its x, y and z, a face a lane.
struct FaceLanes
{
	double corner[3][3][kFaceLanes], carried[3][3][kFaceLanes], normal[3][kFaceLanes];
};

// Of the four faces of a group, as bits: whose boxes meet a box; which can meet a prism (visitMeeting).
std::uint32_t nearFaces(const FaceLanes& group, const Vec3& low, const Vec3& high);
std::uint32_t meetingFaces(const FaceLanes& group, const FacePrism& prism, bool stepCounts, double arrivalTop);
// The same for any machine, for a test.
std::uint32_t nearFacesPlain(const FaceLanes& group, const Vec3& low, const Vec3& high);
std::uint32_t meetingFacesPlain(const FaceLanes& group, const FacePrism& prism, bool stepCounts, double arrivalTop);

class MovedPatch
{
public:
	// motion: of the node's body relative to the other frame's, in that frame.
	void move(const Hierarchy& hierarchy, const Node& node, const Transform& intoFrame, const RelativeMotion& motion);
	// Of the faces those whose boxes meet this one take part until the next call, and make up the bounds. False: none
	// does.
	bool keepNear(const Vec3& low, const Vec3& high);
	Vec3 low() const { return m_low; }
	Vec3 high() const { return m_high; }
	// Of a ball round all corners.
	const Vec3& center() const { return m_center; }
	double radius() const { return m_radius; }

	// Calls visit(index, triangle, carried) for every face taking part that has a corner on the inner side of each of
	// the prism's planes, or, if the step counts, where it is carried to, under arrivalTop instead of the prism's top;
	// unless the two normals agree better than kOpposingCosine. In the order of the faces.
	template <class Visit>
	void visitMeeting(const FacePrism& prism, bool stepCounts, double arrivalTop, const Visit& visit)
	{
		for (std::uint32_t group = 0; group < m_groups.size(); ++group)
			for (std::uint32_t bits = meeting(group, prism, stepCounts, arrivalTop); bits != 0; bits &= bits - 1)
			{
				const std::uint32_t i = kFaceLanes * group + std::uint32_t(__builtin_ctz(bits));
				visit(i, triangle(m_vertices, i), triangle(m_carried, i));
			}
	}

	// One face, unless its normal agrees better with the prism's.
	template <class Visit>
	void visitFace(std::uint32_t i, const FacePrism& prism, const Visit& visit)
	{
		const FaceLanes& group = m_groups[i / kFaceLanes];
		const std::uint32_t lane = i % kFaceLanes;
		const Vec3 normal{group.normal[0][lane], group.normal[1][lane], group.normal[2][lane]};
		if (dot(prism.normal, normal) < kOpposingCosine) visit(i, triangle(m_vertices, i), triangle(m_carried, i));
	}

private:
	std::uint32_t meeting(std::uint32_t group, const FacePrism& prism, bool stepCounts, double arrivalTop) const
	{
		if (m_near[group] == 0) return 0;
		return m_near[group] & meetingFaces(m_groups[group], prism, stepCounts, arrivalTop);
	}
	Triangle triangle(const std::vector<Vec3>& vertices, std::uint32_t face) const
	{
		const std::uint16_t* corner = m_faces[face].vertex;
		return {vertices[corner[0]], vertices[corner[1]], vertices[corner[2]]};
	}

	const Face* m_faces = nullptr;
	std::uint32_t m_faceCount = 0;
	std::vector<Vec3> m_vertices, m_carried;
	std::vector<FaceLanes> m_groups;   // lanes beyond the last face repeat it
	std::vector<std::uint8_t> m_near;  // of a group the faces that take part
	Vec3 m_low, m_high, m_center;
	double m_radius = 0;
};

}  // namespace clod
