// SPDX-License-Identifier: Zlib
// The faces of the input surface near a contact: for each leaf of one body that is near, those of its partners on the
// other body. A point of such a leaf that is inside the other body by less than the tolerance has its nearest face
// among them, as that face's leaf is then within the tolerance too, hence a partner.
#pragma once
#include <vector>

#include "clod/distance/DepthSearch.h"
#include "clod/query/QueryContext.h"

namespace clod
{
struct GatheredFace
{
	Triangle triangle;
	Vec3 normal;  // all but unit
	double top;   // the node's thickened hull is nowhere higher above center, along normal; < 0: not yet asked for
	Vec3 center;
	double radius;  // of the sphere round center that encloses the triangle
	std::uint32_t face;
};

// A ball that holds some faces, a node of a binary tree over those of a slot: a convex body is one leaf of any size.
struct FaceBall
{
	Vec3 center;
	double radius;
	std::uint32_t first, count;  // into ContactSide::inBalls; count 0: the ball's halves are the next one and `first`
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
		std::uint32_t ball;                        // of all the faces, once gathered
		std::uint32_t apart;                       // a face that something was above
		bool gathered, overlaps;                   // overlaps: some partner's hull
	};
	const Hierarchy* hierarchy = nullptr;
	std::vector<Slot> slots;              // ascending by node
	std::vector<std::uint32_t> partners;  // slot indices of the other side
	std::vector<double> apart;            // how far at least the hulls of a partner are apart; 0: they overlap
	std::vector<std::uint32_t> order;     // contacts ascending by this side's node
	std::vector<GatheredFace> faces;
	std::vector<FaceBall> balls;
	std::vector<std::uint32_t> inBalls;  // faces, those of a ball together

	void gather(Slot& slot);

private:
	std::uint32_t addBall(std::uint32_t first, std::uint32_t count);
};

// Fills both sides from pairs of leaves sorted by (nodeA, nodeB).
void gatherSides(const QueryContext& context, const std::vector<Contact>& contacts, ContactSide& a, ContactSide& b);

// The surface of `other` as the nodes of `own` see it (DepthSearch.h); group = slot of own. Faces are numbered as in
// other.faces.
class GatheredSurface
{
public:
	// tolerance: of the pairs.
	GatheredSurface(const ContactSide& own, ContactSide& other, double tolerance, QueryStats& stats)
		: m_own(own), m_other(other), m_tolerance(tolerance), m_stats(stats)
	{
	}
	// A point that looks inside by the tolerance or more may only be far from the few faces gathered: the input surface
	// decides, and gives the distance.
	SignedDistance signedDistance(std::uint32_t group, const Vec3& point, std::uint32_t hint);
	// Outside by more than the tolerance it may be farther than it is said to be.
	DepthSample sample(std::uint32_t group, const Vec3& point, std::uint32_t hint);
	// The triangle crosses no hull of the other side.
	bool crossesNothing(std::uint32_t group, const Triangle& triangle);
	const Triangle& triangle(std::uint32_t face) const { return m_other.faces[face].triangle; }
	// Only faces of slots that were gathered.
	std::uint32_t across(std::uint32_t face, int edge) const;
	// Of a body that is a single leaf: its hull holds all of it.
	double below(std::uint32_t index, const Triangle& triangle);

private:
	void scan(std::uint32_t index, const Vec3& point);  // of a ball
	bool isAbove(ContactSide::Slot& slot, const Triangle& triangle);
	bool isAbove(const ContactSide::Slot& slot, GatheredFace& face, const Triangle& triangle) const;
	double topOf(const ContactSide::Slot& slot, GatheredFace& face) const;
	bool isSingleLeaf() const { return m_other.hierarchy->node(m_other.hierarchy->root()).childCount == 0; }
	void meet(std::uint32_t face, const Vec3& point);

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
