// SPDX-License-Identifier: Zlib
// Facets of the middles of bodies. An impact may turn a body so far within a step that rows at its surface points do
// not tell where it ends. But however it turns about its middle (its centre of mass): over a face as wide as the body
// the middle stays at least the least height of the body's hull about it above the face.
#include "clod/collide/ConvexPolyhedron.h"
#include "clod/manifold/FacetFinder.h"

namespace clod
{
namespace
{
constexpr double kMostTurn = 0.5;  // radians a step: of bodies that turn by less, rows at surface points tell enough
constexpr std::size_t kInnerVertices = 32;
constexpr double kInnerError = 0.01;  // of the radius

// A convex body inside the hull of the body: the hull of the coarsest level that is near the surface, less its distance
// from it.
struct InnerHull
{
	ConvexPolyhedron inner;
	double error;
	explicit InnerHull(const Hierarchy& hierarchy)
	{
		const Level& level = coarsestWithin(hierarchy, kInnerError * double(hierarchy.asset().radius));
		error = double(level.maxSurf);
		inner = convexPolyhedron(cornersOf(hierarchy, level.firstNode, level.nodeCount), kInnerVertices);
	}
	// The least height of the hull about a point, over all directions; negative where the point is outside.
	double leastHeight(const Vec3& center) const
	{
		return inner.triangles.empty() ? 0 : inner.nearestPlane(center).height - error;
	}
};
}  // namespace

void FacetFinder::placeMiddles()
{
	const FacetQuestion& q = *m_question;
	for (const bool isOfA : {true, false})
	{
		Middle& middle = isOfA ? m_middleA : m_middleB;
		const ContactBody& body = isOfA ? q.a : q.b;
		const PairBody& moved = isOfA ? q.rules.a : q.rules.b;
		middle.height = 0;
		if (m_turn <= kMostTurn || !body.hierarchy || body.hierarchy->isThinCore() || !(moved.inverseMass > 0)) continue;
		const auto otherFrom = [&](const Transform& aFromB) { return isOfA ? inverse(aFromB) : aFromB; };
		middle.own = isOfA ? moved.center : m_bFromA * moved.center;
		middle.height = body.hierarchy->derived<InnerHull>().leastHeight(middle.own);
		const Asset& asset = body.hierarchy->asset();
		middle.radius = length(middle.own - toVec3(asset.sphereCenter)) + double(asset.radius);
		middle.now = otherFrom(q.aFromB) * middle.own;
		middle.then = otherFrom(q.aFromBThen) * middle.own;
	}
}

void FacetFinder::middleOverFace(const Middle& middle, std::uint32_t polygon, bool middleIsOfA)
{
	const FacetQuestion& q = *m_question;
	const ContactSurface& faces = middleIsOfA ? *m_pair.b : *m_pair.a;
	const SurfaceFace& face = faces.planeOf(polygon);
	const double now = dot(face.normal, middle.now) - face.offset - middle.height;
	const double then = dot(face.normal, middle.then) - face.offset - middle.height;
	const double end = now + kPathReach * (then - now);
	if (!(now > 0 && end <= q.rules.margin)) return;
	const Vec3 move = kPathReach * (middle.then - middle.now);
	if (!faces.isAround(polygon, middle.now + now / (now - end) * move, middle.radius)) return;
	Facet facet;
	facet.kind = middleIsOfA ? Facet::Kind::kMiddleFace : Facet::Kind::kFaceMiddle;
	facet.reach = Facet::Reach::kPath;
	facet.featureA = middleIsOfA ? kNone : polygon;
	facet.featureB = middleIsOfA ? polygon : kNone;
	facet.distance = now;
	facet.then = then;
	facet.normal = middleIsOfA ? q.aFromB.rotation * face.normal : -face.normal;
	const Vec3 lowest = middle.height * facet.normal;
	facet.span(middleIsOfA ? q.rules.a.center - lowest : q.rules.b.center + lowest, middleIsOfA);
	add(facet);
}
}  // namespace clod
