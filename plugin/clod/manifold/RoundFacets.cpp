// SPDX-License-Identifier: Zlib
// Facets of round bodies: a vertex of one over an edge or a vertex of the other, along the way between them.
#include <algorithm>
#include <cmath>

#include "clod/manifold/FacetFinder.h"

namespace clod
{
namespace
{
// Bodies whose way has a smaller sagitta than this in the step are taken as they are now.
constexpr double kSlowTurn = 0.125 * kArcSlack;
constexpr double kKeptOfMargin = 0.5;  // of the margin: features nearer to each other have no reliable direction

// The share of the way at which two features are nearest, that are `now` from each other and move on by `ahead`.
double nearestShare(const Vec3& now, const Vec3& ahead)
{
	const double squared = lengthSquared(ahead);
	return squared > 0 ? std::max(0.0, std::min(1.0, -dot(now, ahead) / squared)) : 0;
}
// The direction nearest to `there` along which `now` is no nearer than the margin. Precondition: it is farther away
// than that.
Vec3 towards(const Vec3& there, const Vec3& now, double margin)
{
	if (dot(there, now) >= margin * length(there)) return there;
	const double cosine = margin / length(now);
	const Vec3 from = normalized(now), aside = normalized(there - dot(there, from) * from);
	return cosine * from + std::sqrt(1 - cosine * cosine) * aside;
}
}  // namespace

void FacetFinder::findRound()
{
	for (const auto& corner : m_cornersA)
		for (const auto& edge : m_edgesB)
			if (corner->box.meets(edge->box, m_pair.reach)) vertexOverEdge(*corner, *edge, true);
	for (const auto& corner : m_cornersB)
		for (const auto& edge : m_edgesA)
			if (corner->box.meets(edge->box, m_pair.reach)) vertexOverEdge(*corner, *edge, false);
	for (const auto& ofA : m_cornersA)
		for (const auto& ofB : m_cornersB)
			if (ofA->box.meets(ofB->box, m_pair.reach)) vertexOverVertex(*ofA, *ofB);
}

// How two features meet, given the vectors between them now and at the end of the step, with forces and without; the
// way is taken as straight. Features that only the forces bring together may be held apart by another body, which is
// not known here (a ball that rolls from one body onto the next one lying flush with it). They are deflected as little
// as possible: the direction is the one where they come nearest.
std::optional<FacetFinder::Approach> FacetFinder::approach(const Vec3& now, const Vec3& then, const Vec3& unforced) const
{
	const FacetQuestion& q = *m_question;
	if (lengthSquared(now) <= q.touching() * q.touching()) return Approach{Facet::Reach::kNear, 0, now};
	const Vec3 ahead = kPathReach * (then - now), aheadUnforced = kPathReach * (unforced - now);
	const double squared = lengthSquared(ahead), along = dot(now, ahead);
	const double nearest = nearestShare(now, ahead);
	const double least = lengthSquared(now + nearest * ahead), margin = q.rules.margin;
	if (nearest > 0 && least <= margin * margin)
	{
		const double past = std::max(0.0, margin - 2 * kInnerShare * q.length()), kept = kKeptOfMargin * margin;
		const Vec3 there = now + nearest * ahead, unforcedThere = now + nearestShare(now, aheadUnforced) * aheadUnforced;
		if (lengthSquared(unforcedThere) >= past * past && least > kept * kept)
			return Approach{Facet::Reach::kPath, kPathReach * nearest, towards(there, now, margin)};
		const double root = std::sqrt(std::max(0.0, along * along - squared * (lengthSquared(now) - margin * margin)));
		const double first = std::max(0.0, (-along - root) / squared);
		return Approach{Facet::Reach::kPath, kPathReach * first, now + first * ahead};
	}
	const double highest = q.touching() + m_pair.roam;
	if (least <= highest * highest) return Approach{Facet::Reach::kPossible, kPathReach * nearest, now + nearest * ahead};
	return {};
}

// Corrects the direction where bodies turn: between the features is what lies between them at the pose of that share of
// the way, and what forces add; unless the straight way is so far off that it tells nothing of where they meet.
void FacetFinder::bend(const FacetRecord& facet, const Vec3& now, const Vec3& forced, Approach& met)
{
	if (met.reach != Facet::Reach::kPath || m_sagitta < kSlowTurn) return;
	const double margin = m_question->rules.margin;
	const Vec3 there = betweenAt(facet, *m_pair.a, *m_pair.b, poseAt(met.share / kPathReach)) + met.share * forced;
	const double apart = length(there);
	if (apart >= kKeptOfMargin * margin && kKeptOfMargin * apart <= margin) met.between = towards(there, now, margin);
}

// The direction in B's frame as B has turned by the time they meet. The pose is that of the nearest multiple of
// 1 / kArcParts of the way; coneSlack() allows for the difference.
Vec3 FacetFinder::intoB(const Approach& met, const Vec3& direction)
{
	if (m_sagitta < kSlowTurn) return m_bFromA.rotation * direction;
	return transposed(poseAt(std::round(kArcParts * met.share / kPathReach) / kArcParts).rotation) * direction;
}
double FacetFinder::coneSlack() const
{
	return m_sagitta < kSlowTurn ? kArcSlack : kArcSlack + 0.5 * 8 * m_sagitta / kArcParts;
}

// May the vertex touch something in this direction, which points out of its body, in that body's frame?
bool FacetFinder::isInCone(const ContactSurface& surface, const MovedCorner& vertex, const Vec3& away) const
{
	const double slack = coneSlack();
	for (const Vec3& d : surface.fan(vertex.index))
		if (dot(d, away) < -slack) return false;
	return true;
}

// place: where the vertex is, in frame A.
void FacetFinder::addRound(Facet& facet, const Approach& approach, const Vec3& now, const Vec3& then, const Vec3& normal,
						   const Vec3& place)
{
	facet.reach = approach.reach;
	facet.normal = normal;
	facet.distance = dot(normal, now);
	facet.then = std::copysign(length(then), dot(normal, then));
	facet.span(place, facet.parts().ofA == Part::kVertex);
	add(facet);
}

void FacetFinder::vertexOverEdge(const MovedCorner& vertex, const MovedEdge& moved, bool vertexIsOfA)
{
	const Vec3 place = vertexIsOfA ? m_pair.a->vertices()[vertex.index] : vertex.now;
	const Vec3 placeThen = vertexIsOfA ? place : vertex.then;
	const SurfaceEdge& edge = (vertexIsOfA ? m_pair.b : m_pair.a)->edges()[moved.index];
	const Vec3& start = vertexIsOfA ? moved.start : m_pair.a->vertices()[edge.vertex[0]];
	const Vec3& startThen = vertexIsOfA ? moved.thenStart : start;
	const Vec3& direction = vertexIsOfA ? moved.direction : edge.direction;
	const Vec3& directionThen = vertexIsOfA ? moved.thenDirection : direction;
	const double sign = vertexIsOfA ? 1 : -1;
	const Vec3 now = sign * fromLine(start, direction, place);
	const Vec3 then = sign * fromLine(startThen, directionThen, placeThen);
	const Vec3 unforced = sign * (vertexIsOfA ? fromLine(moved.unforcedStart, directionThen, place)
											  : fromLine(start, direction, vertex.unforced));
	std::optional<Approach> met = approach(now, then, unforced);
	if (!met) return;
	Facet facet;
	facet.kind = vertexIsOfA ? Facet::Kind::kVertexEdge : Facet::Kind::kEdgeVertex;
	facet.featureA = vertexIsOfA ? vertex.index : moved.index;
	facet.featureB = vertexIsOfA ? moved.index : vertex.index;
	bend(facet, now, then - unforced, *met);
	const double alongNow = dot(direction, place - start);
	const double alongThen = dot(directionThen, placeThen - startThen);
	const double along = alongNow + met->share * (alongThen - alongNow);
	const double slack = met->reach == Facet::Reach::kPossible ? m_pair.roam
														  : m_sagitta * met->share * std::abs(alongThen - alongNow);
	if (along < -slack || along > edge.length + slack) return;
	const Vec3 normal = normalized(met->between);
	if (normal == Vec3{}) return;
	const Vec3 outOfB = -intoB(*met, normal), away = vertexIsOfA ? outOfB : normal;
	if (!isInCone(vertexIsOfA ? *m_pair.a : *m_pair.b, vertex, vertexIsOfA ? normal : outOfB)) return;
	if (dot(away, edge.inward[0]) < -coneSlack() || dot(away, edge.inward[1]) < -coneSlack()) return;
	addRound(facet, *met, now, then, normal, place);
}

void FacetFinder::vertexOverVertex(const MovedCorner& ofA, const MovedCorner& ofB)
{
	const Vec3& place = m_pair.a->vertices()[ofA.index];
	const Vec3 now = place - ofB.now, then = place - ofB.then;
	std::optional<Approach> met = approach(now, then, place - ofB.unforced);
	if (!met) return;
	Facet facet;
	facet.kind = Facet::Kind::kVertexVertex;
	facet.featureA = ofA.index;
	facet.featureB = ofB.index;
	bend(facet, now, ofB.unforced - ofB.then, *met);
	const Vec3 normal = normalized(met->between);
	if (normal == Vec3{} || !isInCone(*m_pair.a, ofA, normal) || !isInCone(*m_pair.b, ofB, -intoB(*met, normal))) return;
	addRound(facet, *met, now, then, normal, place);
}
}  // namespace clod
