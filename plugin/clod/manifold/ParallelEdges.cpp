// SPDX-License-Identifier: Zlib
// Two convex edges, one of either body, that are almost parallel. As edges they hardly have a normal of their own, and
// vertices at their ends lie over the faces on either side, at places far from each other. All these facets belong to one
// convex ridge of the Minkowski difference: of a way that passes it on one side only that side's hold. Unlike at other
// ridges (FacetChoice::dropRidges) the side is known from the edges themselves, at the beginning and the end of the step.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

#include "clod/manifold/FacetChoice.h"

namespace clod
{
namespace
{
constexpr double kAlmostParallel = 0.1;  // sine
constexpr double kNear = 0.1;            // of the length: how far from each other the edges may be
constexpr double kOneSide = 0.998;       // cosine of normals: there is no ridge between flats that meet at less
constexpr double kOfSide = 0.9995;       // cosine of normals: of a side's facets
constexpr double kDeeper = 3;            // margins: what overlaps may become so much deeper on its way out

enum Side
{
	kLeft,
	kRight,
	kCrossing,  // over where the edges cross
	kSides
};

// The edges at a pose, in frame A. What separates the bodies there is a direction between the normals of two faces, and
// they are as far apart as the edges are in it.
struct Ridge
{
	bool isRidge = false;          // can they meet along a piece of both?
	Vec3 along;                    // unit
	Vec3 normal[kSides];           // from B to A, at right angles to that
	bool crosses = false;          // does the normal of where they cross lie between the others?
	Vec3 offset[2];                // of A from B, at the ends of that piece
	double from = 0, to = 0;       // where it is, along A's edge
	Vec3 placeOn(double at, const Vec3& start, const Vec3& direction) const
	{
		return start + (at / dot(along, direction)) * direction;
	}
	double height(const Vec3& direction) const { return std::min(dot(direction, offset[0]), dot(direction, offset[1])); }
	// Of a facet with that normal, if it is not the crossing; kSides: of none.
	Side sideOf(const Vec3& facetNormal) const
	{
		if (std::abs(dot(facetNormal, along)) > 2 * kAlmostParallel) return kSides;
		const Vec3 flat = normalized(facetNormal - dot(facetNormal, along) * along);
		const double toLeft = dot(flat, normal[kLeft]), toRight = dot(flat, normal[kRight]);
		return std::max(toLeft, toRight) < kOfSide ? kSides : toLeft > toRight ? kLeft : kRight;
	}
};

// Does a direction at right angles to `along` lie between two others, up to rounding?
bool isBetween(const Vec3& direction, const Vec3& first, const Vec3& second, const Vec3& along)
{
	constexpr double kSlack = 1e-6;
	const double sign = dot(along, cross(first, second)) < 0 ? -1 : 1;
	return sign * dot(along, cross(first, direction)) >= -kSlack && sign * dot(along, cross(direction, second)) >= -kSlack &&
		   dot(direction, first + second) > 0;
}

// far: edges that are farther from each other make none.
Ridge ridgeAt(const ContactSurface& a, const SurfaceEdge& ofA, const ContactSurface& b, const SurfaceEdge& ofB,
			  const Transform& aFromB, double far)
{
	Ridge ridge;
	Vec3 direction = aFromB.rotation * ofB.direction;
	const Vec3& startA = a.vertices()[ofA.vertex[0]];
	Vec3 startB = aFromB * b.vertices()[ofB.vertex[0]], endB = aFromB * b.vertices()[ofB.vertex[1]];
	if (dot(direction, ofA.direction) < 0)
	{
		direction = -direction;
		std::swap(startB, endB);
	}
	const Vec3 along = ridge.along = normalized(ofA.direction + direction);
	const double begins = dot(along, startB - startA);
	ridge.from = std::max(0.0, begins);
	ridge.to = std::min(dot(along, ofA.direction) * ofA.length, dot(along, endB - startA));
	if (!(ridge.from < ridge.to)) return ridge;
	for (const int i : {0, 1})
	{
		const double at = i == 0 ? ridge.from : ridge.to;
		ridge.offset[i] = ridge.placeOn(at, startA, ofA.direction) - ridge.placeOn(at - begins, startB, direction);
	}
	if (std::max(lengthSquared(ridge.offset[0]), lengthSquared(ridge.offset[1])) > far * far) return ridge;
	const auto flat = [&](const Vec3& normal) { return normalized(normal - dot(normal, along) * along); };
	const Vec3 ofFacesA[2] = {flat(-ofA.normal[0]), flat(-ofA.normal[1])},
			   ofFacesB[2] = {flat(aFromB.rotation * ofB.normal[0]), flat(aFromB.rotation * ofB.normal[1])};
	int count = 0;
	const auto take = [&](const Vec3& normal, const Vec3 (&others)[2])
	{
		if (!isBetween(normal, others[0], others[1], along)) return;
		for (int i = 0; i < count; ++i)
			if (dot(ridge.normal[i], normal) > kOneSide) return;
		if (count < 2) ridge.normal[count] = normal;
		++count;
	};
	for (const Vec3& normal : ofFacesB) take(normal, ofFacesA);
	for (const Vec3& normal : ofFacesA) take(normal, ofFacesB);
	ridge.isRidge = count == 2;
	Vec3& crossing = ridge.normal[kCrossing] = normalized(cross(along, ridge.offset[1] - ridge.offset[0]));
	if (dot(crossing, ridge.normal[kLeft] + ridge.normal[kRight]) < 0) crossing = -crossing;
	ridge.crosses = crossing != Vec3{} && isBetween(crossing, ridge.normal[kLeft], ridge.normal[kRight], along);
	return ridge;
}

// Above the planes of all sides, in the beginning and at the end.
struct Heights
{
	double now[kSides], then[kSides];
};

Heights heightsOf(const Ridge& now, const Ridge& then)
{
	constexpr double kNowhere = -std::numeric_limits<double>::max();
	const bool isSwapped = dot(now.normal[kLeft], then.normal[kLeft]) < dot(now.normal[kLeft], then.normal[kRight]);
	Heights heights{{now.height(now.normal[isSwapped ? kRight : kLeft]), now.height(now.normal[isSwapped ? kLeft : kRight]), kNowhere},
					{then.height(then.normal[kLeft]), then.height(then.normal[kRight]), kNowhere}};
	if (!now.crosses && !then.crosses) return heights;
	heights.now[kCrossing] = now.height((now.crosses ? now : then).normal[kCrossing]);
	heights.then[kCrossing] = then.height((then.crosses ? then : now).normal[kCrossing]);
	return heights;
}

// Where a step leads past a ridge.
struct Passage
{
	Side side = kLeft;
	bool isFree = false;   // does the way end there, or does it lead in from there?
	bool wasApart = false;
};

// The ways between the beginning and the end are taken as straight.
std::optional<Passage> passageOf(const Heights& heights, double touch, double margin)
{
	const auto& [now, then] = heights;
	const double highest = *std::max_element(now, now + kSides);
	Passage passage;
	passage.side = then[kLeft] >= then[kRight] ? kLeft : kRight;
	if (then[passage.side] < 0 && then[kCrossing] > then[passage.side]) passage.side = kCrossing;
	passage.isFree = then[passage.side] >= -touch;
	passage.wasApart = highest >= -touch;
	if (!passage.wasApart && !passage.isFree) return {};
	// May the way lead through, so deep?
	const double low = std::max(0.0, -highest) + (!passage.isFree ? touch : passage.wasApart ? margin : kDeeper * margin);
	double leaves = -1, comes = 1;
	Side last = kLeft;
	for (const Side side : {kLeft, kRight, kCrossing})
	{
		const bool isAbove = now[side] >= -low, endsAbove = then[side] >= -low;
		const double meets = isAbove == endsAbove ? 2 : (now[side] + low) / (now[side] - then[side]);
		if (isAbove && meets > leaves) leaves = meets, last = side;
		if (!isAbove) comes = std::min(comes, meets);
	}
	if (leaves < comes)
	{
		if (!passage.wasApart) return {};
		passage.side = last;
		passage.isFree = false;
	}
	else if (!passage.wasApart)
	{
		// What overlaps is led out the shortest of the ways that are open.
		for (const Side side : {kLeft, kRight, kCrossing})
			if (then[side] >= -touch && now[side] > now[passage.side]) passage.side = side;
	}
	return passage;
}

// A facet of the edges where they come nearest to crossing at the end of the step, with the normal that they have there.
Facet facetOfCrossing(const FacetQuestion& q, const FacetRecord& record, const Ridge& then)
{
	Facet facet{};
	static_cast<FacetRecord&>(facet) = record;
	const ContactSurface &a = q.a.surface(facet.levelA), &b = q.b.surface(facet.levelB);
	const SurfaceEdge& edge = a.edges()[facet.featureA];
	const Vec3 across = then.offset[1] - then.offset[0];
	const double squared = lengthSquared(across);
	const double share = squared > 0 ? std::clamp(-dot(then.offset[0], across) / squared, 0.0, 1.0) : 0.5;
	const Vec3 onA = then.placeOn(then.from + share * (then.to - then.from), a.vertices()[edge.vertex[0]], edge.direction);
	const Vec3 onBThen = onA - (then.offset[0] + share * across);
	facet.feature = featureOf(a, b, facet);
	facet.normal = then.normal[kCrossing];
	facet.distance = dot(facet.normal, onA - q.aFromB * (inverse(q.aFromBThen) * onBThen));
	facet.reach = facet.distance <= q.touching() ? Facet::Reach::kNear : Facet::Reach::kPath;
	facet.span(onA, true);
	facet.setLinear(q.rules.motion());
	facet.then = then.height(facet.normal);
	return facet;
}

bool isOf(const ContactSurface& surface, Part part, std::uint32_t feature, std::uint32_t edge)
{
	const SurfaceEdge& e = surface.edges()[edge];
	switch (part)
	{
		case Part::kVertex: return e.vertex[0] == feature || e.vertex[1] == feature;
		case Part::kEdge: return edge == feature;
		case Part::kPolygon:
			return surface.faces()[e.face[0]].polygon == feature || surface.faces()[e.face[1]].polygon == feature;
		case Part::kPlace: break;
	}
	return false;
}

// Is it of the edge, or an edge that shares a vertex with it?
bool touchesEdge(const ContactSurface& surface, Part part, std::uint32_t feature, std::uint32_t edge)
{
	if (part != Part::kEdge) return isOf(surface, part, feature, edge);
	const auto [v, w] = surface.edges()[feature].vertex;
	return isOf(surface, Part::kVertex, v, edge) || isOf(surface, Part::kVertex, w, edge);
}
}  // namespace

// Lists the pairs of such edges that a facet's features belong to.
void FacetChoice::listParallels(const std::vector<Facet>& facets, std::uint32_t index)
{
	const FacetQuestion& q = *m_question;
	const Facet& facet = facets[index];
	const ContactSurface &a = q.a.surface(facet.levelA), &b = q.b.surface(facet.levelB);
	const auto [ofA, ofB] = facet.parts();
	for (const std::uint32_t edgeA : a.edgesOf(facet.nodeA))
	{
		if (!isOf(a, ofA, facet.featureA, edgeA)) continue;
		const Vec3 along = transposed(q.aFromBThen.rotation) * a.edges()[edgeA].direction;
		for (const std::uint32_t edgeB : b.edgesOf(facet.nodeB))
			if (isOf(b, ofB, facet.featureB, edgeB) &&
				lengthSquared(cross(along, b.edges()[edgeB].direction)) < kAlmostParallel * kAlmostParallel)
				m_parallels.push_back({facet.levelA, facet.levelB, edgeA, edgeB, index});
	}
}

void FacetChoice::passParallels(const JoinedBodies& joined, std::vector<Facet>& facets)
{
	const FacetQuestion& q = *m_question;
	m_waysOut.clear();
	if (facets.size() < 2 || q.isRound() || (q.b.only && !q.b.only->isClosed())) return;
	const auto isOfOneSide = [&](const Facet& facet) { return dot(facet.normal, facets[0].normal) > kOneSide; };
	if (std::all_of(facets.begin(), facets.end(), isOfOneSide)) return;
	m_parallels.clear();
	for (std::uint32_t i = 0; i < facets.size(); ++i)
		if (facets[i].hasFeatures() && !facets[i].isOfMiddle() && !facets[i].isThrough && !facets[i].isAside)
			listParallels(facets, i);
	const auto nameOf = [](const Parallels& p) { return std::tie(p.levelA, p.levelB, p.edgeA, p.edgeB); };
	const auto orderOf = [](const Parallels& p) { return std::tie(p.levelA, p.levelB, p.edgeA, p.edgeB, p.facet); };
	std::sort(m_parallels.begin(), m_parallels.end(), [&](const Parallels& l, const Parallels& r) { return orderOf(l) < orderOf(r); });
	m_isKept.assign(facets.size(), 1);
	for (std::size_t from = 0, to = 0; from < m_parallels.size(); from = to)
	{
		while (to < m_parallels.size() && nameOf(m_parallels[to]) == nameOf(m_parallels[from])) ++to;
		passParallels({m_parallels.data() + from, to - from}, joined, facets);
	}
	removeDropped(facets);
}

// All facets that are of the same two edges.
void FacetChoice::passParallels(Span<Parallels> ofFacets, const JoinedBodies& joined, std::vector<Facet>& facets)
{
	const Parallels& edges = ofFacets[0];
	const auto isOfFirstSide = [&](const Parallels& p) { return dot(facets[p.facet].normal, facets[edges.facet].normal) > kOneSide; };
	if (std::all_of(ofFacets.begin(), ofFacets.end(), isOfFirstSide)) return;
	const FacetQuestion& q = *m_question;
	const double length = q.length(), touch = kInnerShare * length;
	const ContactSurface &a = q.a.surface(edges.levelA), &b = q.b.surface(edges.levelB);
	const SurfaceEdge &edgeA = a.edges()[edges.edgeA], &edgeB = b.edges()[edges.edgeB];
	const Ridge then = ridgeAt(a, edgeA, b, edgeB, q.aFromBThen, kNear * length);
	if (!then.isRidge) return;
	const Ridge now = ridgeAt(a, edgeA, b, edgeB, q.aFromB, length);
	if (!now.isRidge) return;
	Heights heights = heightsOf(now, then);
	const double highest = *std::max_element(heights.now, heights.now + kSides);
	const Facet& like = facets[edges.facet];
	const FacetRecord record{Facet::Kind::kEdgeEdge, Facet::Reach::kNear, false, false, edges.levelA, edges.levelB,
							 like.nodeA, like.nodeB, edges.edgeA, edges.edgeB, 0, 0, 0};
	if (!joined.isEmpty() && isAtSeam(q, joined, facetOfCrossing(q, record, then))) return;
	// The facets here: those of the edges, and of edges that share a vertex with these.
	const auto isHere = [&](const Facet& facet)
	{
		if (facet.levelA != edges.levelA || facet.levelB != edges.levelB || !facet.hasFeatures() || facet.isOfMiddle()) return false;
		const auto [ofA, ofB] = facet.parts();
		return touchesEdge(a, ofA, facet.featureA, edges.edgeA) && touchesEdge(b, ofB, facet.featureB, edges.edgeB);
	};
	const auto isCrossing = [&](const Facet& facet)
	{ return facet.kind == Facet::Kind::kEdgeEdge && facet.featureA == edges.edgeA && facet.featureB == edges.edgeB; };
	m_order.clear();
	bool isFound = false, overlapsElsewhere = false;
	for (std::uint32_t i = 0; i < facets.size(); ++i)
	{
		if (!m_isKept[i]) continue;
		if (!isHere(facets[i]))
		{
			overlapsElsewhere = overlapsElsewhere || facets[i].reach == Facet::Reach::kOverlap;
			continue;
		}
		m_order.push_back(i);
		if (!isCrossing(facets[i])) continue;
		isFound = true;
		// Rows know the crossing of what turns to first order only.
		if (highest < -touch)
			heights.then[kCrossing] = std::min(heights.then[kCrossing], facets[i].distance + facets[i].linear);
	}
	const std::optional<Passage> passage = passageOf(heights, touch, q.rules.margin);
	if (!passage) return;

	const auto sideOf = [&](const Facet& facet) { return isCrossing(facet) ? kCrossing : then.sideOf(facet.normal); };
	const auto isBeyond = [&](Side side, const Facet& facet)
	{
		if (side == kSides || side == passage->side) return false;
		if (facet.reach == Facet::Reach::kOverlap && !passage->isFree) return false;
		return std::max(std::abs(heights.then[side] - heights.then[passage->side]),
						std::abs(heights.now[side] - heights.now[passage->side])) >= kTie * length;
	};
	m_beside.clear();
	bool hasFacet = false;
	for (const std::uint32_t i : m_order)
	{
		const Side side = sideOf(facets[i]);
		const bool isOverlap = facets[i].reach == Facet::Reach::kOverlap;
		if (isBeyond(side, facets[i]))
			m_beside.push_back(i);
		else
			overlapsElsewhere = overlapsElsewhere || isOverlap;
		if (side != passage->side) continue;
		hasFacet = hasFacet || facets[i].reach < Facet::Reach::kPossible;
		if (!isOverlap || !passage->isFree || passage->wasApart) continue;
		facets[i].reach = Facet::Reach::kPath;
		m_waysOut.push_back({facets[i].feature, highest});
	}
	// Edges that are parallel now have a normal only where they cross at the end of the step.
	if (passage->side == kCrossing && then.crosses && !isFound)
	{
		facets.push_back(facetOfCrossing(q, record, then));
		m_waysOut.push_back({facets.back().feature, std::min(0.0, highest)});
		m_isKept.push_back(1);
		hasFacet = true;
	}
	// What overlaps elsewhere would count without them.
	if (!hasFacet && (!passage->isFree || overlapsElsewhere)) return;
	for (const std::uint32_t i : m_beside) m_isKept[i] = 0;
}

// What overlaps is led out by these, and normals that are only to come say nothing of a depth: none claims more than the
// bodies have. Their rows stay.
void FacetChoice::limitWaysOut(std::vector<Facet>& facets) const
{
	for (const WayOut& way : m_waysOut)
		for (Facet& facet : facets)
		{
			if (facet.feature != way.feature || !(facet.distance < way.distance)) continue;
			facet.distance = way.distance;
			const bool isOfB = facet.kind == Facet::Kind::kFaceVertex;
			facet.span(isOfB ? facet.onB : facet.onA, !isOfB);
		}
}
}  // namespace clod
