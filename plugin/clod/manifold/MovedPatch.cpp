// SPDX-License-Identifier: Zlib
#include "clod/manifold/MovedPatch.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "clod/collide/InstructionSets.h"

namespace clod
{
namespace
{
#define CLOD_KERNEL "clod/manifold/MovedPatchKernel.h"
#include "clod/collide/CompiledTwice.h"

void setLane(double (&lanes)[3][kFaceLanes], std::uint32_t lane, const Vec3& v)
{
	lanes[0][lane] = v.x;
	lanes[1][lane] = v.y;
	lanes[2][lane] = v.z;
}
}  // namespace

void MovedPatch::move(const Hierarchy& hierarchy, const Node& node, const Transform& intoFrame,
					  const RelativeMotion& motion)
{
	m_faces = hierarchy.faces().data + node.firstFace;
	m_vertices.clear();
	m_carried.clear();
	const HullView hull = hierarchy.hull(node);
	for (std::uint32_t i = 0; i < hull.count; ++i)
	{
		const Vec3 here = intoFrame * hull.vertex(i);
		m_vertices.push_back(here);
		m_carried.push_back(here + motion.timeStep * motion.velocity(here));
	}
	Vec3 low = m_vertices[0], high = low;
	for (const Vec3& vertex : m_vertices)
		for (int axis = 0; axis < 3; ++axis)
		{
			low[axis] = std::min(low[axis], vertex[axis]);
			high[axis] = std::max(high[axis], vertex[axis]);
		}
	m_center = 0.5 * (low + high);
	m_radius = 0;
	for (const Vec3& vertex : m_vertices) m_radius = std::max(m_radius, lengthSquared(vertex - m_center));
	m_radius = std::sqrt(m_radius);
	const std::uint32_t count = m_faceCount = node.faceCount, groups = (count + kFaceLanes - 1) / kFaceLanes;
	m_groups.resize(groups);
	m_near.resize(groups);
	for (std::uint32_t i = 0; i < groups * kFaceLanes; ++i)
	{
		const Face& face = m_faces[std::min(i, count - 1)];
		FaceLanes& group = m_groups[i / kFaceLanes];
		for (int k = 0; k < 3; ++k)
		{
			setLane(group.corner[k], i % kFaceLanes, m_vertices[face.vertex[k]]);
			setLane(group.carried[k], i % kFaceLanes, m_carried[face.vertex[k]]);
		}
		const Vec3 normal{double(face.normal[0]), double(face.normal[1]), double(face.normal[2])};
		setLane(group.normal, i % kFaceLanes, intoFrame.rotation * normal);
	}
}

bool MovedPatch::keepNear(const Vec3& low, const Vec3& high)
{
	constexpr double kFar = std::numeric_limits<double>::max();
	m_low = {kFar, kFar, kFar};
	m_high = {-kFar, -kFar, -kFar};
	bool isAny = false;
	for (std::uint32_t i = 0; i < m_groups.size(); ++i)
	{
		const std::uint32_t faces = std::min(m_faceCount - kFaceLanes * i, kFaceLanes);
		m_near[i] = std::uint8_t(nearFaces(m_groups[i], low, high) & ((1U << faces) - 1));
		isAny = isAny || m_near[i] != 0;
		for (std::uint32_t bits = m_near[i]; bits != 0; bits &= bits - 1)
			for (const auto& corner : m_groups[i].corner)
				for (int axis = 0; axis < 3; ++axis)
				{
					const double x = corner[axis][__builtin_ctz(bits)];
					m_low[axis] = std::min(m_low[axis], x);
					m_high[axis] = std::max(m_high[axis], x);
				}
	}
	return isAny;
}

std::uint32_t nearFaces(const FaceLanes& group, const Vec3& low, const Vec3& high)
{
	return (kWide ? wide::nearFaces : plain::nearFaces)(group, low, high);
}
std::uint32_t meetingFaces(const FaceLanes& group, const FacePrism& prism, bool stepCounts, double arrivalTop)
{
	return (kWide ? wide::meetingFaces : plain::meetingFaces)(group, prism, stepCounts, arrivalTop);
}
std::uint32_t nearFacesPlain(const FaceLanes& group, const Vec3& low, const Vec3& high)
{
	return plain::nearFaces(group, low, high);
}
std::uint32_t meetingFacesPlain(const FaceLanes& group, const FacePrism& prism, bool stepCounts, double arrivalTop)
{
	return plain::meetingFaces(group, prism, stepCounts, arrivalTop);
}
}  // namespace clod
