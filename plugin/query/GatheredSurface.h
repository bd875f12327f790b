// SPDX-License-Identifier: Zlib
// The real faces near a contact. Where both bodies answer with their input surfaces: for each node of one body that is
// near, those of its partners on the other body. A point of such a node that is inside the other body by less than the
// tolerance has its nearest face among them, as that face's node is then within the tolerance too, hence a partner.
// Coarser nodes answer for a part of a body that differs from partner to partner: the faces of all of them are looked
// at.
#pragma once
#include <vector>

#include "clod/query/DepthSearch.h"
#include "clod/query/QueryContext.h"

namespace clod
{
struct GatheredFace
{
	Triangle triangle;
	Vec3 normal;  // all but unit
	double top;   // the node's thickened hull is nowhere higher above center, along normal
	Vec3 center;
	double radius;  // of the sphere round center that encloses the triangle
	std::uint32_t level, face;
	double surf;  // of its node
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
		double apart;                              // max over partners of surf - distance, plus own reach
		Vec3 center;                               // of a ball that holds the faces, once gathered
		double radius;
		bool gathered, overlaps;  // overlaps: some partner's hull
	};
	const Hierarchy* hierarchy = nullptr;
	std::vector<Slot> slots;              // ascending by node
	std::vector<std::uint32_t> partners;  // slot indices of the other side
	std::vector<double> apart;            // how far at least the hulls of a partner are apart; 0: they overlap
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
	GatheredSurface(const ContactSide& own, ContactSide& other, bool inputOnly, double tolerance, QueryStats& stats)
		: m_own(own), m_other(other), m_inputOnly(inputOnly), m_tolerance(tolerance), m_stats(stats)
	{
	}
	// A point that looks inside by the tolerance or more may only be far from the few faces gathered: the input surface
	// decides, and gives the distance.
	SignedDistance signedDistance(std::uint32_t group, const Vec3& point, std::uint32_t hint);
	// A point of a coarse face that looks deeper than what is known is judged by the input surface.
	DepthSample sample(std::uint32_t group, const Vec3& point, std::uint32_t hint, const DepthBound& known);
	// What is within reach_a of a point of a node is no farther than this beyond the point's distance to a face from
	// what is within surf_b of that.
	double margin(std::uint32_t group, std::uint32_t face) const
	{
		return kUp * (double(nodeOf(group).reach) + m_other.faces[face].surf);
	}
	double leastMargin(std::uint32_t group) const { return double(nodeOf(group).reach); }
	// Of a triangle that crosses no hull of the other side and has a point outside: all of it is. Infinite where that
	// is not seen.
	double outside(std::uint32_t group, const Triangle& triangle);
	const Triangle& triangle(std::uint32_t face) const { return m_other.faces[face].triangle; }
	// Only faces of slots that were gathered: their surf is part of the certificate.
	std::uint32_t across(std::uint32_t face, int edge) const;

private:
	static constexpr double kUp = 1 + 1e-12;  // rounds a sum of a few terms up

	const Node& nodeOf(std::uint32_t group) const { return m_own.hierarchy->node(m_own.slots[group].node); }
	void scan(ContactSide::Slot& slot, const Vec3& point);
	double above(ContactSide::Slot& slot, const Triangle& triangle);
	void scanNearest(const Vec3& point);
	void meet(std::uint32_t face, const Vec3& point);

	const ContactSide& m_own;
	ContactSide& m_other;
	const bool m_inputOnly;
	const double m_tolerance;
	QueryStats& m_stats;
	double m_distance = 0;
	Vec3 m_point;
	std::uint32_t m_face = 0;
	int m_feature = 6;
};
}  // namespace clod
