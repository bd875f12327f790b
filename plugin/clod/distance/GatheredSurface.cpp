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
	for (std::uint32_t i = 0; i < side.order.size(); ++i)
	{
		const Contact& contact = contacts[side.order[i]];
		const std::uint32_t node = nodeOf(contact, isA);
		if (side.slots.empty() || side.slots.back().node != node)
			side.slots.push_back({node, i, 0, 0, 0, side.order[i], {}, 0, false, false});
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
	const ConvexHull thickened = contactHull(*hierarchy, owner);
	const HullView& hull = thickened.vertices;
	slot.gathered = true;
	slot.firstFace = std::uint32_t(faces.size());
	slot.faceCount = owner.faceCount;
	for (std::uint32_t i = 0; i < owner.faceCount; ++i)
	{
		GatheredFace face{};
		face.triangle = triangleOf(*hierarchy, owner, hierarchy->faces(owner)[i]);
		face.face = owner.firstFace + i;
		const Triangle& corner = face.triangle;
		face.center = (1.0 / 3) * (corner[0] + corner[1] + corner[2]);
		double squared = 0;
		for (int k = 0; k < 3; ++k) squared = std::max(squared, lengthSquared(corner[k] - face.center));
		face.radius = std::sqrt(squared);
		// Shorter than a unit by more than rounding: along it nothing looks farther than it is. None of a sliver.
		const Vec3 normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
		const double area = length(normal);
		if (area > kSliver * squared) face.normal = (kBelowUnit / area) * normal;
		for (std::uint32_t k = 0; k < hull.count; ++k)
			face.top = std::max(face.top, dot(face.normal, hull.vertex(k) - face.center));
		face.top += std::max(0.0, dot(face.normal, thickened.sweep));
		faces.push_back(face);
	}
	for (std::uint32_t i = 0; i < hull.count; ++i) slot.center += (1.0 / hull.count) * hull.vertex(i);
	double squared = 0;
	for (std::uint32_t i = 0; i < hull.count; ++i)
		squared = std::max(squared, lengthSquared(hull.vertex(i) - slot.center));
	slot.radius = kSumUp * std::sqrt(squared);
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

void GatheredSurface::scan(ContactSide::Slot& slot, const Vec3& point)
{
	if (!slot.gathered) m_other.gather(slot);
	const double ofBall = m_distance + slot.radius;
	if (lengthSquared(point - slot.center) > ofBall * ofBall) return;
	for (std::uint32_t i = slot.firstFace; i < slot.firstFace + slot.faceCount; ++i)
	{
		const GatheredFace& face = m_other.faces[i];
		const double within = m_distance + face.radius;
		const Vec3 offset = point - face.center;
		if (lengthSquared(offset) <= within * within && std::abs(dot(offset, face.normal)) <= m_distance)
			meet(i, point);
	}
}

// How far the triangle is above the thickened hull of a node, along the normal of one of its faces. > 0: they are
// apart.
double GatheredSurface::above(ContactSide::Slot& slot, const Triangle& triangle)
{
	if (!slot.gathered) m_other.gather(slot);
	double best = -std::numeric_limits<double>::infinity();
	for (std::uint32_t i = slot.firstFace; i < slot.firstFace + slot.faceCount; ++i)
	{
		const GatheredFace& face = m_other.faces[i];
		double lowest = std::numeric_limits<double>::infinity();
		for (const Vec3& corner : triangle) lowest = std::min(lowest, dot(face.normal, corner - face.center));
		best = std::max(best, lowest - face.top);
	}
	return best;
}

bool GatheredSurface::crossesNothing(std::uint32_t group, const Triangle& triangle)
{
	const ContactSide::Slot& own = m_own.slots[group];
	for (std::uint32_t i = own.firstPartner; i < own.firstPartner + own.partnerCount; ++i)
		if (!(m_own.apart[i] > 0) && !(above(m_other.slots[m_own.partners[i]], triangle) > 0)) return false;
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
		scan(m_other.slots[m_own.partners[own.firstPartner + i]], point);
	const GatheredFace& nearest = m_other.faces[m_face];
	const Vec3 normal = pseudonormal(*m_other.hierarchy, nearest.face, m_feature);
	const bool outside = dot(point - m_point, normal) >= 0;
	if (!outside && m_distance >= m_tolerance)
		return {distanceToInput(*m_other.hierarchy, point, m_stats.boxTests, kSumUp * m_distance).distance, m_face,
				m_feature};
	return {outside ? m_distance : -m_distance, m_face, m_feature};
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
