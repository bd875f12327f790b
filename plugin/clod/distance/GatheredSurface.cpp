// SPDX-License-Identifier: Zlib
// Gathering of contact partners and nearest-face scans over them.
#include "clod/distance/GatheredSurface.h"

#include <algorithm>
#include <limits>

#include "clod/distance/Constants.h"

namespace clod
{
namespace
{
std::uint32_t nodeOf(const Contact& contact, bool isA)
{
	return isA ? contact.nodeA : contact.nodeB;
}

std::uint32_t slotOf(const ContactSide& side, std::uint32_t node)
{
	const auto found = std::lower_bound(side.slots.begin(), side.slots.end(), node,
										[](const ContactSide::Slot& slot, std::uint32_t n) { return slot.node < n; });
	return std::uint32_t(found - side.slots.begin());
}

void collectSlots(const std::vector<Contact>& contacts, bool isA, ContactSide& side)
{
	side.order.resize(contacts.size());
	for (std::uint32_t i = 0; i < contacts.size(); ++i) side.order[i] = i;
	if (!isA)
		std::sort(side.order.begin(), side.order.end(),
				  [&](std::uint32_t l, std::uint32_t r)
				  { return contacts[l].nodeB != contacts[r].nodeB ? contacts[l].nodeB < contacts[r].nodeB : l < r; });
	side.slots.clear();
	side.faces.clear();
	side.balls.clear();
	side.inBalls.clear();
	for (std::uint32_t i = 0; i < side.order.size(); ++i)
	{
		const Contact& contact = contacts[side.order[i]];
		const std::uint32_t node = nodeOf(contact, isA);
		if (side.slots.empty() || side.slots.back().node != node)
			side.slots.push_back({node, i, 0, 0, 0, side.order[i], 0, 0, false, false});
		ContactSide::Slot& slot = side.slots.back();
		++slot.partnerCount;
		slot.overlaps |= contact.upper <= 0;
		if (contact.upper < contacts[slot.nearest].upper) slot.nearest = side.order[i];
	}
}
}  // namespace

void ContactSide::gather(Slot& slot)
{
	const Node& owner = hierarchy->node(slot.node);
	slot.gathered = true;
	slot.firstFace = slot.apart = std::uint32_t(faces.size());
	slot.faceCount = owner.faceCount;
	for (std::uint32_t i = 0; i < owner.faceCount; ++i)
	{
		GatheredFace face{};
		face.triangle = triangleOf(*hierarchy, owner, hierarchy->faces(owner)[i]);
		face.face = owner.firstFace + i;
		face.top = -1;
		const Triangle& corner = face.triangle;
		face.center = (1.0 / 3) * (corner[0] + corner[1] + corner[2]);
		double squared = 0;
		for (int k = 0; k < 3; ++k) squared = std::max(squared, lengthSquared(corner[k] - face.center));
		face.radius = std::sqrt(squared);
		// Shorter than a unit by more than rounding: along it nothing looks farther than it is. None of a sliver.
		const Vec3 normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
		const double area = length(normal);
		if (area > kSliver * squared) face.normal = (kBelowUnit / area) * normal;
		inBalls.push_back(std::uint32_t(faces.size()));
		faces.push_back(face);
	}
	slot.ball = addBall(slot.firstFace, slot.faceCount);
}

std::uint32_t ContactSide::addBall(std::uint32_t first, std::uint32_t count)
{
	FaceBall ball{{0, 0, 0}, 0, first, count};
	for (std::uint32_t i = first; i < first + count; ++i) ball.center += (1.0 / count) * faces[inBalls[i]].center;
	double squared = 0;
	Vec3 spread{0, 0, 0};
	for (std::uint32_t i = first; i < first + count; ++i)
	{
		const GatheredFace& face = faces[inBalls[i]];
		for (const Vec3& corner : face.triangle) squared = std::max(squared, lengthSquared(corner - ball.center));
		const Vec3 offset = face.center - ball.center;
		spread += {offset.x * offset.x, offset.y * offset.y, offset.z * offset.z};
	}
	ball.radius = kSumUp * std::sqrt(squared);
	const std::uint32_t index = std::uint32_t(balls.size());
	balls.push_back(ball);
	if (count <= kFacesInBall) return index;
	const int axis = widestAxis(spread);
	const auto begin = inBalls.begin() + first;
	std::nth_element(begin, begin + count / 2, begin + count,
					 [&](std::uint32_t l, std::uint32_t r)
					 {
						 const double ofL = faces[l].center[axis], ofR = faces[r].center[axis];
						 return ofL != ofR ? ofL < ofR : l < r;
					 });
	addBall(first, count / 2);
	const std::uint32_t second = addBall(first + count / 2, count - count / 2);
	balls[index].first = second;
	balls[index].count = 0;
	return index;
}

void gatherSides(const QueryContext& context, const std::vector<Contact>& contacts, ContactSide& a, ContactSide& b)
{
	a.hierarchy = &context.a;
	b.hierarchy = &context.b;
	collectSlots(contacts, true, a);
	collectSlots(contacts, false, b);
	for (ContactSide* side : {&a, &b})
	{
		side->partners.resize(contacts.size());
		side->apart.resize(contacts.size());
		for (std::uint32_t i = 0; i < contacts.size(); ++i) side->apart[i] = contacts[side->order[i]].lower;
	}
	for (std::uint32_t i = 0; i < contacts.size(); ++i)
	{
		a.partners[i] = slotOf(b, contacts[a.order[i]].nodeB);
		b.partners[i] = slotOf(a, contacts[b.order[i]].nodeA);
	}
}

void GatheredSurface::scan(std::uint32_t index, const Vec3& point)
{
	const FaceBall& ball = m_other.balls[index];
	const double ofBall = m_distance + ball.radius;
	if (lengthSquared(point - ball.center) > ofBall * ofBall) return;
	if (ball.count == 0)
	{
		std::uint32_t near = index + 1, far = ball.first;
		if (lengthSquared(point - m_other.balls[far].center) < lengthSquared(point - m_other.balls[near].center))
			std::swap(near, far);
		scan(near, point);
		scan(far, point);
		return;
	}
	for (std::uint32_t i = ball.first; i < ball.first + ball.count; ++i)
	{
		const GatheredFace& face = m_other.faces[m_other.inBalls[i]];
		const double within = m_distance + face.radius;
		const Vec3 offset = point - face.center;
		if (lengthSquared(offset) <= within * within && std::abs(dot(offset, face.normal)) <= m_distance)
			meet(m_other.inBalls[i], point);
	}
}

// The triangle is above the thickened hull of a node, along the normal of this face of it: they are apart.
bool GatheredSurface::isAbove(const ContactSide::Slot& slot, GatheredFace& face, const Triangle& triangle) const
{
	double lowest = std::numeric_limits<double>::infinity();
	for (const Vec3& corner : triangle) lowest = std::min(lowest, dot(face.normal, corner - face.center));
	return lowest > 0 && lowest > topOf(slot, face);
}

double GatheredSurface::topOf(const ContactSide::Slot& slot, GatheredFace& face) const
{
	if (face.top >= 0) return face.top;
	const ConvexHull thickened = contactHull(*m_other.hierarchy, m_other.hierarchy->node(slot.node));
	face.top = 0;
	for (std::uint32_t k = 0; k < thickened.vertices.count; ++k)
		face.top = std::max(face.top, dot(face.normal, thickened.vertices.vertex(k) - face.center));
	face.top += std::max(0.0, dot(face.normal, thickened.sweep));
	return face.top;
}

// A point inside that goes along the normal is outside once it is above all of the hull.
double GatheredSurface::below(std::uint32_t index, const Triangle& triangle)
{
	GatheredFace& face = m_other.faces[index];
	if (!isSingleLeaf() || !(lengthSquared(face.normal) > 0)) return std::numeric_limits<double>::infinity();
	double lowest = std::numeric_limits<double>::infinity();
	for (const Vec3& corner : triangle) lowest = std::min(lowest, dot(face.normal, corner - face.center));
	return (kSumUp / kBelowUnit) * std::max(0.0, topOf(m_other.slots[0], face) - lowest);
}

bool GatheredSurface::isAbove(ContactSide::Slot& slot, const Triangle& triangle)
{
	if (!slot.gathered) m_other.gather(slot);
	if (isAbove(slot, m_other.faces[slot.apart], triangle)) return true;
	for (std::uint32_t i = slot.firstFace; i < slot.firstFace + slot.faceCount; ++i)
		if (isAbove(slot, m_other.faces[i], triangle))
		{
			slot.apart = i;
			return true;
		}
	return false;
}

bool GatheredSurface::crossesNothing(std::uint32_t group, const Triangle& triangle)
{
	const ContactSide::Slot& own = m_own.slots[group];
	for (std::uint32_t i = own.firstPartner; i < own.firstPartner + own.partnerCount; ++i)
		if (!(m_own.apart[i] > 0) && !isAbove(m_other.slots[m_own.partners[i]], triangle)) return false;
	return true;
}

void GatheredSurface::meet(std::uint32_t face, const Vec3& point)
{
	const NearestOnTriangle here = nearestOnTriangle(m_other.faces[face].triangle, point);
	if (here.squared >= m_distance * m_distance) return;
	m_distance = std::sqrt(here.squared);
	m_point = here.point;
	m_face = face;
	m_feature = here.feature;
}

SignedDistance GatheredSurface::signedDistance(std::uint32_t group, const Vec3& point, std::uint32_t hint)
{
	++m_stats.pointQueries;
	m_distance = std::numeric_limits<double>::infinity();
	if (hint != kNone) meet(hint, point);
	const ContactSide::Slot& own = m_own.slots[group];
	for (std::uint32_t i = 0; i < own.partnerCount; ++i)
	{
		ContactSide::Slot& slot = m_other.slots[m_own.partners[own.firstPartner + i]];
		if (!slot.gathered) m_other.gather(slot);
		scan(slot.ball, point);
	}
	const GatheredFace& nearest = m_other.faces[m_face];
	const Vec3 normal = pseudonormal(*m_other.hierarchy, nearest.face, m_feature);
	const bool outside = dot(point - m_point, normal) >= 0;
	if (!outside && m_distance >= m_tolerance && !isSingleLeaf())
		return {distanceToInput(*m_other.hierarchy, point, m_stats.boxTests, kSumUp * m_distance).distance, m_face,
				m_feature};
	return {outside ? m_distance : -m_distance, m_face, m_feature};
}

DepthSample GatheredSurface::sample(std::uint32_t group, const Vec3& point, std::uint32_t hint)
{
	ContactSide::Slot& slot = m_other.slots[0];
	if (isSingleLeaf() && slot.gathered)
	{
		GatheredFace& face = m_other.faces[slot.apart];
		const double height = dot(face.normal, point - face.center) - topOf(slot, face);
		if (height > m_tolerance) return {-height, height, slot.apart};
	}
	const SignedDistance near = signedDistance(group, point, hint);
	if (isSingleLeaf() && near.distance > m_tolerance) slot.apart = near.face;
	return {-near.distance, std::abs(near.distance), near.face};
}

std::uint32_t GatheredSurface::across(std::uint32_t face, int edge) const
{
	const GatheredFace& here = m_other.faces[face];
	const std::uint32_t neighbour = m_other.hierarchy->faces()[here.face].neighbour[edge];
	const std::uint32_t owner = ownerOf(*m_other.hierarchy, neighbour);
	const std::uint32_t index = slotOf(m_other, owner);
	if (index >= m_other.slots.size()) return kNone;
	const ContactSide::Slot& slot = m_other.slots[index];
	if (slot.node != owner || !slot.gathered) return kNone;
	return slot.firstFace + (neighbour - m_other.hierarchy->node(owner).firstFace);
}
}  // namespace clod
