// SPDX-License-Identifier: Zlib
// The real faces near a contact: for each node of one body that is in contact, those of its partners on the other body.
// A point of such a node that is inside the other body by less than the tolerance has its nearest face among them, as
// that face's node is then within the tolerance too, hence a partner.
#pragma once
#include <vector>

#include "clod/query/QueryContext.h"
#include "clod/query/SurfaceFaces.h"

namespace clod
{
struct GatheredFace
{
	Triangle triangle;
	Vec3 center;
	double radius;  // of the sphere round center that encloses the triangle
	std::uint32_t level, face;
};

// One body's side of the contact list.
struct ContactSide
{
	struct Slot
	{
		std::uint32_t node;
		std::uint32_t firstPartner, partnerCount;  // into partners
		std::uint32_t firstFace, faceCount;        // into faces, once gathered
		std::uint32_t nearest;                     // contact with the smallest distance
		bool gathered, overlaps;                   // overlaps: some partner's hull
	};
	const Hierarchy* hierarchy = nullptr;
	std::vector<Slot> slots;              // ascending by node
	std::vector<std::uint32_t> partners;  // slot indices of the other side
	std::vector<std::uint32_t> order;     // contacts ascending by this side's node
	std::vector<GatheredFace> faces;

	void gather(Slot& slot);
};

// Fills both sides from contacts sorted by (nodeA, nodeB).
void gatherSides(const QueryContext& context, const std::vector<Contact>& contacts, ContactSide& a, ContactSide& b);

// The surface of `other` as the nodes of `own` see it (DepthSearch.h); group = slot of own. Faces are numbered as in
// other.faces.
class GatheredSurface
{
public:
	// tolerance: of the contact list.
	GatheredSurface(const ContactSide& own, ContactSide& other, double tolerance, QueryStats& stats)
		: m_own(own), m_other(other), m_tolerance(tolerance), m_stats(stats)
	{
	}
	// A point that looks inside by the tolerance or more may only be far from the few faces gathered: the input surface
	// decides, and gives the distance.
	SignedDistance signedDistance(std::uint32_t group, const Vec3& point);
	const Triangle& triangle(std::uint32_t face) const { return m_other.faces[face].triangle; }
	// Only faces of slots that were gathered: their surf is part of the certificate.
	std::uint32_t across(std::uint32_t face, int edge) const;
	// Distance to the faces of every slot, whoever's partner it is.
	double distanceToAll(const Vec3& point);

private:
	void scan(ContactSide::Slot& slot, const Vec3& point);

	const ContactSide& m_own;
	ContactSide& m_other;
	const double m_tolerance;
	QueryStats& m_stats;
	double m_distance = 0;
	Vec3 m_point;
	std::uint32_t m_face = 0;
	int m_feature = 6;
};
}  // namespace clod
