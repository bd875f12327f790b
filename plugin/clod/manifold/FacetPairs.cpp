// SPDX-License-Identifier: Zlib
// Pairs of nodes within reach: the features of either that come near the other in the step, each asked of each.
#include <algorithm>
#include <cmath>
#include <limits>

#include "clod/collide/Constants.h"
#include "clod/manifold/FacetFinder.h"

namespace clod
{
namespace
{
constexpr double kFar = std::numeric_limits<double>::infinity();
// Facets are looked for no farther off the predicted way than so many grains (mean edges) of the coarser surface.
constexpr double kRoamGrains = 1;
}  // namespace

// How far the corners and edges of B, if it is one node, stay from the sphere of A's levels: what is much wider than A,
// as a floor is, meets it with faces alone, and these meet corners.
double FacetFinder::borderApart(const std::vector<Contact>& contacts)
{
	const FacetQuestion& q = *m_question;
	const Asset& asset = q.a.hierarchy->asset();
	const bool isSmall = q.b.hierarchy && q.b.hierarchy->asset().radius <= asset.radius;
	if (contacts.empty() || isSmall || !m_nodesB.isOne() || m_middleB.height > 0) return 0;
	const std::uint32_t node = contacts[0].nodeB;
	const MovedNode& moved = m_nodesB.of(node);
	const ContactSurface& b = q.b.surface(moved.level);
	const Vec3 center = m_bFromA * toVec3(asset.sphereCenter);
	double apart = kFar;
	for (const std::uint32_t v : b.verticesOf(node))
		if (b.isCorner(v)) apart = std::min(apart, length(b.vertices()[v] - center));
	for (const std::uint32_t e : b.edgesOf(node))
	{
		const Vec3& from = b.vertices()[b.edges()[e].vertex[0]];
		apart = std::min(apart, distanceToSegment(from - center, b.vertices()[b.edges()[e].vertex[1]] - from));
	}
	float protrude = 0;
	for (const Contact& contact : contacts) protrude = std::max(protrude, q.a.hierarchy->node(contact.nodeA).protrude);
	return apart - kPathReach * moved.displaced - double(asset.radius) - double(protrude);
}

// How far beneath the faces of either what overlaps may be.
double FacetFinder::depthOf(const Contact& contact, const ContactSurface& b) const
{
	const FacetQuestion& q = *m_question;
	if (!b.isHalfSpace()) return q.a.thicknessOf(contact.nodeA) + q.b.thicknessOf(contact.nodeB);
	const OrientedBox& box = q.a.hierarchy->cullBox(contact.nodeA);
	const SurfaceFace& plane = b.faces()[0];
	return std::max(0.0, plane.offset - dot(plane.normal, m_bFromA * toVec3(box.center)) + double(box.radius));
}

FacetFinder::Pair FacetFinder::pairOf(const Contact& contact)
{
	const FacetQuestion& q = *m_question;
	MovedNode& nodeB = m_nodesB.of(contact.nodeB);
	const bool mayOverlap = contact.upper <= 0;
	const ContactSurface &a = q.a.surfaceOf(contact.nodeA), &b = q.b.surface(nodeB.level);
	const double most = m_roamShare * nodeB.displaced;
	const double roam = std::max(q.rules.shove, std::min(most, kRoamGrains * std::max(a.grain(), b.grain())));
	if (roam < most) m_sought = std::min(m_sought, roam);
	const double beside = kFootShare * q.length() + roam;
	double reach = q.touching() + q.rules.heldReach + beside;
	// The features of a facet are as far apart as its height and, at a right angle to it, as far as its foot is from
	// both features, when it is nearest. For a ball this straight distance leaves out most that boxes grown by the
	// reach hold.
	const double aside = 2 * beside + std::max(0.0, 0.5 - m_roamShare) * nodeB.displaced;
	const double straight = !mayOverlap && b.isCore() ? std::sqrt(reach * reach + aside * aside) : kFar;
	if (mayOverlap) reach += depthOf(contact, b);
	const bool meetsFaces = kRootOf3 * reach < m_borderApart;
	const Near near = m_nodesB.isOne() ? Near(nodeB.box, reach, straight, mayOverlap, meetsFaces) : Near();
	MovedNode& nodeA = m_nodesA.of(contact.nodeA, near);
	Pair pair{&a, &b, &nodeA, &nodeB, mayOverlap};
	pair.roam = roam;
	pair.deepest = mayOverlap ? kFar : kInnerShare * q.length();
	pair.reach = reach;
	return pair;
}

// A box that holds all that one node of B has near nodes of A.
Box FacetFinder::placesNearA() const
{
	constexpr double kRounding = 1 + 1e-9;
	Box places = Box::none();
	for (const Pair& pair : m_pairs)
	{
		const Box& box = pair.movedA->box;
		const double reach = kRounding * pair.reach;
		const Vec3 far{reach, reach, reach};
		if (box.low.x <= box.high.x) places.add({box.low - far, box.high + far});
	}
	return places;
}

void FacetFinder::findPair(const Pair& pair)
{
	m_pair = pair;
	gather(*pair.movedA, *pair.movedB, pair.mayOverlap);
	verticesOverFaces();
	edgesOverEdges(pair.mayOverlap);
	if (m_middleA.height > 0)
		for (const auto& polygon : m_polygonsB) middleOverFace(m_middleA, polygon->index, true);
	if (m_middleB.height > 0)
		for (const auto& polygon : m_polygonsA) middleOverFace(m_middleB, polygon->index, false);
	if (m_question->isRound()) findRound();
}

void FacetFinder::verticesOverFaces()
{
	forEachNew(m_cornersA, m_polygonsB,
			   [this](const MovedCorner& a, const MovedPolygon& b) { vertexOverFace(a, b, true); });
	forEachNew(m_cornersB, m_polygonsA,
			   [this](const MovedCorner& b, const MovedPolygon& a) { vertexOverFace(b, a, false); });
}

// Where the hulls overlap, edges may have sunk past each other by any depth: no box leaves them out.
void FacetFinder::edgesOverEdges(bool mayOverlap)
{
	const auto ask = [&](const MovedEdge& b, const MovedEdge& a)
	{
		if (mayOverlap || a.box.meets(b.box, m_pair.reach)) edgeOverEdge(a, b);
	};
	forEachNew(m_edgesB, m_edgesA, ask);
}

// Lists the features of either node that come near the other node in the step, and of each the nodes by which
// forEachNew() knows what was asked: of faces and of A's edges those that they were near to before, of what is asked
// against them those that share it. Where hulls overlap more is looked for than elsewhere, and all is asked.
void FacetFinder::gather(MovedNode& nodeA, MovedNode& nodeB, bool mayOverlap)
{
	const double reach = m_pair.reach;
	const auto gatherOf = [reach](auto& features, const Box& other, auto& list, const auto& nodesOf)
	{
		list.clear();
		for (auto& feature : features)
			if (feature.box.meets(other, reach)) list.push_back({&feature, nodesOf(feature)});
	};
	const auto near = [mayOverlap](MovedNodes& nodes, const MovedNodes& others, const MovedNode& other)
	{
		return [&, mayOverlap](const MovedFeature& feature)
		{
			const std::uint64_t before = nodes.noteNear(feature.number, others.blocks(), other.place);
			return mayOverlap ? 0 : before;
		};
	};
	const auto ofCornerA = [&](MovedCorner& corner)
	{
		if (!corner.isPlaced) m_nodesA.place(*m_pair.a, corner);
		return m_nodesA.sharing(corner.number, nodeA.place);
	};
	// As far as third bodies may carry one, all nodes were looked round.
	const double displaced = m_pair.roam > m_question->rules.shove ? m_pair.roam / m_roamShare : 0;
	const std::uint64_t asWide = m_nodesB.displaced(displaced, nodeB.place);
	const auto ofB = [&](const MovedFeature& feature)
	{ return m_nodesB.sharing(feature.number, nodeB.place) & asWide; };
	const auto ofEdgeB = [&](MovedEdge& edge)
	{
		if (!edge.isPlaced) m_nodesB.place(*m_pair.b, edge);
		return ofB(edge);
	};
	const auto nearA = near(m_nodesA, m_nodesB, nodeB), nearB = near(m_nodesB, m_nodesA, nodeA);
	gatherOf(nodeA.corners, nodeB.box, m_cornersA, ofCornerA);
	gatherOf(nodeA.edges, nodeB.box, m_edgesA, nearA);
	gatherOf(nodeA.polygons, nodeB.box, m_polygonsA, nearA);
	gatherOf(nodeB.corners, nodeA.box, m_cornersB, ofB);
	gatherOf(nodeB.edges, nodeA.box, m_edgesB, ofEdgeB);
	gatherOf(nodeB.polygons, nodeA.box, m_polygonsB, nearB);
}
}  // namespace clod
