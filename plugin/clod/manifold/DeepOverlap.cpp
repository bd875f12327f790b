// SPDX-License-Identifier: Zlib
#include "clod/manifold/DeepOverlap.h"

#include <algorithm>
#include <limits>

#include "clod/collide/ConvexPolyhedron.h"

namespace clod
{
namespace
{
constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kLeastDepth = 1e-3;  // of the length: shallower overlaps are left to the facets
constexpr double kOwnWay = 0.9;       // cosine: a place's own way out is the pair's
constexpr double kNearSurface = 0.5;  // of a node's thickness, which is half of a wall at most
constexpr double kDeepestOfFace = 0.03;  // of the radius: Face::thickness is no more
constexpr double kAlongWay = 0.3;  // cosine: of all that is so, edges in a corner of two walls among them
constexpr double kLeastShare = 1e-3;  // of an edge: the shortest part that is looked for inside
constexpr double kNotConvex = 0.03;   // of a body's volume: a hull with that much more is not the body
constexpr double kNotConvexError = 2e-3;  // of the radius, of the surface that is looked at: 0.6 % of a ball's volume
constexpr double kWholeError = 0.01;  // of the radius, of the surface that what is wholly inside comes out through
constexpr std::size_t kMostHullCorners = 64;
constexpr double kDifferencesError = 1e-4;  // of the length, of the hull of differences,
constexpr std::size_t kMostDifferences = 128;  // which has so many corners at most
constexpr std::size_t kMostProbed = 64;
constexpr std::size_t kMostVertices = 256;

// Is a body convex, or nearly so? One patch is. Else its volume is compared with that of two hulls: of its surface, as
// far as so many corners tell; and of the root node, whose few corners are all there, but which may lie within the body
// (a landscape's root is a box).
struct Bulk
{
	bool isConvex;
	explicit Bulk(const Hierarchy& hierarchy)
	{
		const double most = (1 + kNotConvex) * hierarchy.asset().volume;
		const Level& level = coarsestWithin(hierarchy, kNotConvexError * double(hierarchy.asset().radius));
		isConvex = level.nodeCount == 1 || (hullVolume(hierarchy, hierarchy.root(), 1) <= most &&
											hullVolume(hierarchy, level.firstNode, level.nodeCount) <= most);
	}

private:
	static double hullVolume(const Hierarchy& hierarchy, std::uint32_t firstNode, std::uint32_t count)
	{
		const ConvexPolyhedron inner = convexPolyhedron(cornersOf(hierarchy, firstNode, count), kMostHullCorners);
		double volume = 0;
		for (const auto& t : inner.triangles)
			volume += dot(inner.vertices[t[0]], cross(inner.vertices[t[1]], inner.vertices[t[2]])) / 6;
		return volume;
	}
};

// How far A has to go along the direction until the hulls of the two surfaces are apart.
double hullDepth(const ContactSurface& a, const ContactSurface& b, const Transform& aFromB, const Vec3& direction)
{
	double lowest = kFar, highest = -kFar;
	for (const Vec3& v : a.vertices()) lowest = std::min(lowest, dot(v, direction));
	const Vec3 there = transposed(aFromB.rotation) * direction;
	for (const Vec3& v : b.vertices()) highest = std::max(highest, dot(v, there));
	return highest + dot(aFromB.translation, direction) - lowest;
}

// The way out of two bodies' hulls: to the nearest face of the hull of their differences a - b.
Vec3 shortestWayOut(const FacetQuestion& q, const ContactSurface& a, const ContactSurface& b)
{
	const auto farthest = [](const ContactSurface& surface, const Vec3& direction)
	{
		const std::vector<Vec3>& v = surface.vertices();
		const auto isNearer = [&](const Vec3& l, const Vec3& r) { return dot(l, direction) < dot(r, direction); };
		return *std::max_element(v.begin(), v.end(), isNearer);
	};
	const auto support = [&](const Vec3& direction)
	{ return farthest(a, direction) - q.aFromB * farthest(b, -(transposed(q.aFromB.rotation) * direction)); };
	return -convexPolyhedron(support, kDifferencesError * q.length(), kMostDifferences).nearestPlane({}).normal;
}

// As Face::thickness, for what has none: half the way from a place on the surface straight inward to where it is left.
double halfWall(const ContactSurface& surface, const ContactSurface::Nearest& near, double radius)
{
	const Vec3 way = -2 * kDeepestOfFace * radius * surface.faces()[near.face].normal;
	double least = 1;
	const auto leave = [&](std::uint32_t face, double share)
	{
		if (dot(surface.faces()[face].normal, way) > 0) least = std::min(least, share);
	};
	surface.forEachCrossed(near.point, near.point + way, 0, leave);
	return 0.5 * least * length(way);
}

bool isConvex(const ContactBody& body)
{
	return body.hierarchy && body.hierarchy->derived<Bulk>().isConvex;
}
}  // namespace

bool DeepOverlap::areConvex(const FacetQuestion& q)
{
	return isConvex(q.a) && isConvex(q.b);
}

// place: in its own body's frame; there: the same in the other's, to whose surface it is `near`.
DeepOverlap::Inside DeepOverlap::insideAt(const FacetQuestion& q, const Contact& contact, bool ofA, const Vec3& place,
										  const Vec3& there, const ContactSurface::Nearest& near, std::uint32_t feature)
{
	const Vec3 way = near.point - there;
	const ContactBody& other = ofA ? q.b : q.a;
	const std::uint32_t node = ofA ? contact.nodeB : contact.nodeA;
	double wall = kNearSurface * other.thicknessOf(node);
	// Curved patches have no thickness, faces of stretched bodies neither.
	if (!other.only)
	{
		const double told =
			double(other.hierarchy->faces()[other.globalFace(other.levelOf(node), near.face)].thickness);
		wall = std::max(
			wall, told > 0 ? told : halfWall(other.surfaceOf(node), near, double(other.hierarchy->asset().radius)));
	}
	return {ofA ? place : there, ofA ? q.aFromB.rotation * way : -way, wall, contact.nodeA, contact.nodeB, feature, ofA};
}

// Finds the deepest of a node's corners inside the other body. Where bodies reach through each other without any corner
// inside (atCrossings), finds the deepest place on the parts of edges behind where they cross the other node's faces.
void DeepOverlap::probe(const FacetQuestion& q, const Contact& contact, bool ofA, bool atCrossings)
{
	const ContactSurface &a = q.a.surfaceOf(contact.nodeA), &b = q.b.surfaceOf(contact.nodeB);
	const ContactSurface &own = ofA ? a : b, &other = ofA ? b : a;
	if (other.isCore()) return;
	const Transform otherFromOwn = ofA ? inverse(q.aFromB) : q.aFromB;
	const std::uint32_t node = ofA ? contact.nodeA : contact.nodeB, otherNode = ofA ? contact.nodeB : contact.nodeA;
	// Patches are convex, so a place inside near the other's patch is beneath all faces of that patch.
	const std::uint32_t firstFace = other.firstFaceOf(otherNode);
	const auto patch = other.polygonsOf(otherNode);
	const double slack = kLeastDepth * q.length(), least = (atCrossings ? kInnerShare : kLeastDepth) * q.length();
	Inside deepest{};
	const auto look = [&](const Vec3& place, std::uint32_t feature)
	{
		const Vec3 there = otherFromOwn * place;
		const auto isUnder = [&](const ContactSurface::NodePolygon& polygon)
		{
			const SurfaceFace& plane = other.planeOf(polygon.polygon);
			return dot(plane.normal, there) <= plane.offset + slack;
		};
		if (!std::all_of(patch.begin(), patch.end(), isUnder)) return;
		const ContactSurface::Nearest near = other.nearest(there, kFar);
		if (near.distance > -least || -near.distance <= length(deepest.way)) return;
		deepest = insideAt(q, contact, ofA, place, there, near, feature);
	};
	// Looks from the crossing towards the edge's end, by halving, as the edge may come out again soon.
	const auto lookBehindCrossings = [&](const SurfaceEdge& edge, std::uint32_t feature)
	{
		const Vec3 &from = own.vertices()[edge.vertex[0]], &to = own.vertices()[edge.vertex[1]];
		const Vec3 start = otherFromOwn * from, end = otherFromOwn * to;
		const auto lookBehind = [&](std::uint32_t face, double share)
		{
			if (face - firstFace >= other.faceCountOf(otherNode)) return;
			const Vec3 crossing = from + share * (to - from);
			const Vec3 behind = (dot(other.faces()[face].normal, end - start) < 0 ? to : from) - crossing;
			for (double part = 1; part > kLeastShare; part *= 0.5) look(crossing + part * behind, feature);
		};
		other.forEachCrossed(start, end, slack, lookBehind);
	};
	if (atCrossings)
		for (const std::uint32_t e : own.edgesOf(node)) lookBehindCrossings(own.edges()[e], e);
	else
		for (const std::uint32_t v : own.verticesOf(node)) look(own.vertices()[v], v);
	if (deepest.way != Vec3{}) m_inside.push_back(deepest);
}

// For a body no part of which is near the other's surface: finds the way out of each of its vertices, of a coarse level
// that fills no hollow yet, or of some, evenly spread.
void DeepOverlap::probeWhole(const FacetQuestion& q, bool ofA)
{
	const auto nodeOf = [](const Hierarchy& h)
	{ return coarsestWithin(h, kWholeError * double(h.asset().radius)).firstNode; };
	const Contact contact{nodeOf(*q.a.hierarchy), nodeOf(*q.b.hierarchy), 0, 0, {}, {}, {}};
	const ContactSurface &a = q.a.surfaceOf(contact.nodeA), &b = q.b.surfaceOf(contact.nodeB), &other = ofA ? b : a;
	if (other.isCore()) return;
	const Transform otherFromOwn = ofA ? inverse(q.aFromB) : q.aFromB;
	const std::vector<Vec3>& vertices = (ofA ? a : b).vertices();
	for (std::uint32_t v = 0; v < vertices.size(); v += std::uint32_t(1 + vertices.size() / kMostVertices))
	{
		const Vec3 there = otherFromOwn * vertices[v];
		if (!other.isInside(there)) continue;
		m_inside.push_back(insideAt(q, contact, ofA, vertices[v], there, other.nearest(there, kFar), v));
	}
}

Vec3 DeepOverlap::meanWay() const
{
	Vec3 sum;
	for (const Inside& inside : m_inside) sum += inside.way;
	return normalized(sum);
}

// Of edges in a wall: do all come out the way that they came in, each near the surface there? Not asked of those in a
// convex body, which has no walls to be pushed through.
bool DeepOverlap::isShallow(const FacetQuestion& q, const Vec3& way) const
{
	bool isInWall = false;
	for (const Inside& inside : m_inside)
	{
		if (dot(inside.way, way) < kAlongWay * length(inside.way)) return false;
		if (isConvex(inside.ofA ? q.b : q.a)) continue;
		if (length(inside.way) > inside.wall) return false;
		isInWall = true;
	}
	return isInWall;
}

Vec3 DeepOverlap::find(const FacetQuestion& q, const std::vector<Contact>& contacts, bool isDeep, const Vec3& kept,
					   const Vec3& pushed, std::vector<Facet>& facets)
{
	m_inside.clear();
	// Not for half spaces, whose facets tell any depth, nor for sheets, which have no inside.
	if (q.b.hierarchy == nullptr) return {};
	const auto probeAll = [&](bool atCrossings)
	{
		std::size_t probed = 0;
		for (const Contact& contact : contacts)
		{
			if (contact.upper > 0 || probed++ >= kMostProbed) continue;
			probe(q, contact, true, atCrossings);
			probe(q, contact, false, atCrossings);
		}
	};
	probeAll(false);
	const bool isWhole = isDeep && m_inside.empty(), isCrossing = !isWhole && m_inside.empty();
	if (isCrossing) probeAll(true);
	if (isWhole)
		for (const bool ofA : {true, false}) probeWhole(q, ofA);
	if (m_inside.empty()) return {};
	const bool areHulls = !isWhole && areConvex(q);
	const auto add = [&](const Inside& inside, const Vec3& normal, double depth)
	{
		Facet facet{};
		facet.kind = Facet::Kind::kDeep;
		facet.reach = Facet::Reach::kOverlap;
		facet.nodeA = inside.nodeA;
		facet.nodeB = inside.nodeB;
		facet.levelA = q.a.levelOf(inside.nodeA);
		facet.levelB = q.b.levelOf(inside.nodeB);
		facet.featureA = inside.ofA ? inside.feature : inside.nodeA;
		facet.featureB = inside.ofA ? inside.nodeB : inside.feature;
		facet.normal = normal;
		facet.distance = facet.then = -depth;
		facet.span(inside.point, inside.ofA);
		facets.push_back(facet);
	};
	// No way of edges is kept: it would drive the pair into what it meets elsewhere meanwhile. That of corners is, or they
	// would come and go where bodies rest.
	const Vec3 mean = meanWay();
	if (kept == Vec3{} && isCrossing && !isWhole && !areHulls && isShallow(q, mean))
	{
		for (const Inside& inside : m_inside) add(inside, mean, length(inside.way));
		return {};
	}
	const auto firstWay = [&]
	{
		if (pushed != Vec3{}) return pushed;
		const auto isShallower = [](const Inside& l, const Inside& r)
		{ return lengthSquared(l.way) < lengthSquared(r.way); };
		if (isWhole) return normalized(std::min_element(m_inside.begin(), m_inside.end(), isShallower)->way);
		// The hulls tell nothing of concave bodies that reach into each other. They are asked only where no corner is
		// inside.
		if (!areHulls && !isCrossing && mean != Vec3{}) return mean;
		return shortestWayOut(q, q.a.surfaceOf(m_inside[0].nodeA), q.b.surfaceOf(m_inside[0].nodeB));
	};
	const Vec3 way = kept != Vec3{} ? kept : firstWay();
	if (way == Vec3{}) return {};
	// Where each place comes out that way by itself, its own way tells how deep it is. Else it may be near a surface on
	// its way through thin walls: the hulls tell how far it is out of them all, and the bodies part at the full speed
	// until nothing is inside.
	const auto isOwnWay = [&](const Inside& inside) { return dot(inside.way, way) >= kOwnWay * length(inside.way); };
	const bool areOwn = !areHulls && std::all_of(m_inside.begin(), m_inside.end(), isOwnWay);
	const double depth =
		areOwn ? 0 : hullDepth(q.a.surfaceOf(m_inside[0].nodeA), q.b.surfaceOf(m_inside[0].nodeB), q.aFromB, way);
	for (const Inside& inside : m_inside) add(inside, way, areOwn ? length(inside.way) : depth);
	return way;
}
}  // namespace clod
