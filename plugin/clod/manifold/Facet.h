// SPDX-License-Identifier: Zlib
// Contacts as facets of the Minkowski difference: two polyhedral surfaces touch where the origin reaches its boundary,
// and that boundary is made of a vertex of one body over a face of the other, and of two crossing edges. A facet is one
// constraint: points on both bodies, the normal, the signed distance. Bodies grown by a radius touch with vertices, besides:
// of one over an edge or a vertex of the other, along the way between the nearest points.
//
// Everything in body A's frame, normals from B to A, distances without margins unless named height. Unit: the
// hierarchies' own.
//
// Based on: Gregorius, The separating axis test between convex polyhedra, GDC 2013 (arcs); Mirtich, V-Clip, 1998
// (Voronoi regions). Departs from Otaduy & Lin 2003, sec. 5: witness points of hull pairs make ghost forces at patch
// borders in an engine that keeps bodies in touch.
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>

#include "clod/manifold/ContactPoints.h"
#include "clod/manifold/ContactSurface.h"

namespace clod
{
inline constexpr double kAgainst = -0.1;        // cosine of normals that oppose
inline constexpr double kSameNormal = 0.99995;  // cosine: of one polygon's facets, and of polygons all but in one plane

// What of a body makes a facet.
enum class Part
{
	kVertex,
	kEdge,
	kPolygon,
	kPlace  // its middle, or a place that is no feature
};

// What a facet is, and how far apart its features are: with its contact point, all of it.
struct FacetRecord
{
	enum class Kind : std::uint8_t
	{
		kVertexFace,  // of A, of B
		kFaceVertex,
		kEdgeEdge,
		kVertexEdge,
		kEdgeVertex,
		kVertexVertex,
		kMiddleFace,  // the middle of A that it turns about, of a face of B
		kFaceMiddle,
		kDeep,  // no facet, but a way out (DeepOverlap.h)
		kHeld   // of levels no longer asked for: a point of the last step that goes on (LevelSwitch.h)
	};
	enum class Reach : std::uint8_t  // what says more comes first
	{
		kNear,
		kOverlap,
		kPath,
		kPossible,  // none of these by the motion predicted, but by what contacts, or third bodies, may make of it
		kBeside     // its features are aside of each other: it counts in valleys and hollow corners (FacetChoice)
	};
	Kind kind;
	Reach reach;
	bool isThrough = false;  // a vertex that went in through the face, and may be out beyond
	bool isAside = false;    // a vertex that counts although it is aside of the face, by a rule of FacetChoice
	std::uint32_t levelA, levelB, nodeA, nodeB;
	std::uint32_t featureA, featureB;  // vertex, edge, or polygon of the level's surface
	std::uint64_t feature = 0;         // the two, the same in every step (featureOf)
	double distance;                   // now
	double then;                       // at the end of the step if nothing intervened, of the same facet
	// Is it made of two features, which tell of it at any pose?
	bool hasFeatures() const { return kind != Kind::kDeep && kind != Kind::kHeld; }
	// Of a vertex and a face: these, and which body has the vertex.
	bool isOfVertex() const { return kind == Kind::kVertexFace || kind == Kind::kFaceVertex; }
	bool vertexIsOfA() const { return kind == Kind::kVertexFace; }
	std::uint32_t vertex() const { return vertexIsOfA() ? featureA : featureB; }
	std::uint32_t polygon() const { return vertexIsOfA() ? featureB : featureA; }
	bool isOfMiddle() const { return kind == Kind::kMiddleFace || kind == Kind::kFaceMiddle; }
	struct Parts
	{
		Part ofA, ofB;
	};
	Parts parts() const
	{
		constexpr Part kVertex = Part::kVertex, kEdge = Part::kEdge, kPolygon = Part::kPolygon, kPlace = Part::kPlace;
		static constexpr Parts kOfKinds[] = {{kVertex, kPolygon}, {kPolygon, kVertex}, {kEdge, kEdge}, {kVertex, kEdge},
											 {kEdge, kVertex}, {kVertex, kVertex}, {kPlace, kPolygon}, {kPolygon, kPlace},
											 {kPlace, kPlace}, {kPlace, kPlace}};
		return kOfKinds[std::size_t(kind)];
	}
};

struct Facet : FacetRecord
{
	Vec3 onA, onB, normal;
	Vec3 ofA, ofB;  // the points of the bodies that meet on the way, where they are now: one of the two, or aside of them
	double linear;          // what the motion closes by, to first order: negative closes
	double multiplier = 0;  // of the pair's own solve, an impulse
	double slowOverlap = 0;  // of what lies below the margin: came with a change of level, and is left slowly
	void setLinear(const RelativeMotion& motion) { linear = dot(motion.velocity(onA), normal) * motion.timeStep; }
	double curvature() const { return then - distance - linear; }  // what the first order misses
	// The points: this one, of A's surface or of B's, and the other's across from it.
	void span(const Vec3& place, bool isOnA)
	{
		onA = isOnA ? place : place + distance * normal;
		onB = isOnA ? place - distance * normal : place;
		ofA = onA;
		ofB = onB;
	}
};

// Of each point that a solver got last, with what it was made of: each(old, record).
template <class Each>
void forEachReduced(const ClusterSet& points, const std::vector<FacetRecord>& records, Each each)
{
	auto record = records.begin();
	for (const ContactCluster& cluster : points.slots)
		for (std::size_t i = 0; i < std::size_t(cluster.count) && record != records.end(); ++i) each(cluster.points[i], *record++);
}

// A body of a pair: the surfaces of a hierarchy's levels, or the one surface of what has none.
struct ContactBody
{
	const Hierarchy* hierarchy = nullptr;
	const ContactSurfaces* levels = nullptr;  // the hierarchy's
	const ContactSurface* only = nullptr;
	const ContactSurface& surface(std::uint32_t level) const { return only ? *only : levels->level(level); }
	std::uint32_t levelOf(std::uint32_t node) const { return only ? 0 : hierarchy->node(node).level; }
	const ContactSurface& surfaceOf(std::uint32_t node) const { return surface(levelOf(node)); }
	// How far beneath its faces what is inside a node's hull may be.
	double thicknessOf(std::uint32_t node) const
	{
		return only ? std::numeric_limits<double>::infinity() : double(hierarchy->node(node).thickness);
	}
	// Index of a surface's face among all of the body's.
	std::uint32_t globalFace(std::uint32_t level, std::uint32_t face) const
	{
		return only || face == kNone ? face : hierarchy->levels()[level].firstFace + face;
	}
};
inline ContactBody contactBody(const Hierarchy& hierarchy)
{
	return {&hierarchy, &hierarchy.derived<ContactSurfaces>(), nullptr};
}
inline ContactBody contactBody(const ContactSurface& surface)
{
	return {nullptr, nullptr, &surface};
}

// What is asked of a pair in a step.
struct FacetQuestion
{
	ContactBody a, b;
	Transform aFromB, aFromBThen;  // now, and at the end of the step if nothing intervened,
	Transform aFromBUnforced;      // and if forces did not act either
	PointRules rules;
	double length() const { return rules.length; }
	double touching() const { return rules.margin + rules.resting; }  // contacts up to here, whatever the motion
	// Do vertices over edges and vertices count?
	bool isRound() const { return rules.nearest || rules.radiusA + rules.radiusB > 0; }
	// How far off its facet a foot may be.
	double footSlack(double distance) const;
	// The same of a facet in a valley: as far as either body goes in the step at that place, at most kBesideMost.
	double besideSlack(const Vec3& place, double distance) const;
};

// What makes a facet, hashed: the same in whichever step it is found.
inline std::uint64_t featureOf(const ContactSurface& a, const ContactSurface& b, const FacetRecord& facet)
{
	const auto nameIn = [](const ContactSurface& surface, Part part, std::uint32_t index) -> std::uint64_t
	{
		switch (part)
		{
			case Part::kVertex: return surface.nameOfVertex(index);
			case Part::kEdge: return surface.nameOfEdge(index);
			case Part::kPolygon: return surface.nameOfPolygon(index);
			case Part::kPlace: break;
		}
		return index;
	};
	const auto [ofA, ofB] = facet.parts();
	const std::uint64_t name =
		nameIn(a, ofA, facet.featureA) * 0x9E3779B97F4A7C15u ^ nameIn(b, ofB, facet.featureB);
	return name * 0xD6E8FEB86659FD93u + (std::uint64_t(facet.kind) << 16 | facet.levelA << 8 | facet.levelB);
}

// Places a facet of a vertex and a polygon, known by their names, where it is now.
inline void placeAgain(const FacetQuestion& q, Facet& facet)
{
	const ContactSurface &a = q.a.surface(facet.levelA), &b = q.b.surface(facet.levelB);
	const bool isOfA = facet.vertexIsOfA();
	const Vec3& own = (isOfA ? a : b).vertices()[facet.vertex()];
	const SurfaceFace& face = (isOfA ? b : a).planeOf(facet.polygon());
	const Vec3 place = isOfA ? inverse(q.aFromB) * own : q.aFromB * own;
	facet.feature = featureOf(a, b, facet);
	facet.distance = dot(face.normal, place) - face.offset;
	facet.normal = isOfA ? q.aFromB.rotation * face.normal : -face.normal;
	facet.span(isOfA ? own : place, isOfA);
}

// Makes a contact of a vertex beneath a polygon that it went in through.
inline void placeThrough(const FacetQuestion& q, Facet& facet)
{
	facet.reach = Facet::Reach::kOverlap;
	facet.isThrough = true;
	placeAgain(q, facet);
}

inline constexpr double kFootShare = 1e-3;      // of the length: how far off its facet a foot may be
inline constexpr double kDeepFootShare = 1e-2;  // and at most where bodies overlap
inline constexpr double kArcSlack = 0.01;       // radians: of cones and arcs
inline constexpr double kInnerShare = 1e-4;     // of the length: overlaps below it are touch
inline constexpr double kParallelSine = 1e-3;   // edges that cross at less have no normal of their own

inline constexpr double kBesideMost = 0.1;      // how far off its facet a foot may be in a valley

inline double FacetQuestion::footSlack(double distance) const
{
	return std::max(kFootShare * length(), std::min(-distance, kDeepFootShare * length()));
}

inline double FacetQuestion::besideSlack(const Vec3& place, double distance) const
{
	const Vec3 ofA = rules.a.velocityAt(place), ofB = rules.b.velocityAt(place);
	const double squared = std::max({lengthSquared(ofA), lengthSquared(ofB), lengthSquared(ofA - ofB)});
	return footSlack(distance) + std::min(kBesideMost * length(), rules.timeStep * std::sqrt(squared));
}

// Of two lines along their common normal, to the side of `normal`; where they have none along that.
inline double distanceOfLines(const Vec3& startA, const Vec3& directionA, const Vec3& startB, const Vec3& directionB,
							  const Vec3& normal)
{
	const Vec3 between = startA - startB;
	Vec3 across = cross(directionA, directionB);
	const double sine = length(across);
	if (sine < kParallelSine) return dot(normal, between);
	across = (1 / sine) * across;
	return dot(across, normal) < 0 ? -dot(across, between) : dot(across, between);
}

// From the nearest point of a line.
inline Vec3 fromLine(const Vec3& start, const Vec3& direction, const Vec3& point)
{
	const Vec3 between = point - start;
	return between - dot(between, direction) * direction;
}

// From the nearest point of B's feature to that of A's, with a vertex on one side at least.
inline Vec3 betweenAt(const FacetRecord& facet, const ContactSurface& a, const ContactSurface& b, const Transform& aFromB)
{
	if (facet.kind == FacetRecord::Kind::kVertexVertex) return a.vertices()[facet.featureA] - aFromB * b.vertices()[facet.featureB];
	if (facet.kind == FacetRecord::Kind::kVertexEdge)
	{
		const SurfaceEdge& k = b.edges()[facet.featureB];
		return fromLine(aFromB * b.vertices()[k.vertex[0]], aFromB.rotation * k.direction, a.vertices()[facet.featureA]);
	}
	const SurfaceEdge& e = a.edges()[facet.featureA];
	return -fromLine(a.vertices()[e.vertex[0]], e.direction, aFromB * b.vertices()[facet.featureB]);
}

// Where two lines are nearest, as lengths along them. Precondition: not parallel.
struct LinesCrossing
{
	double alongA, alongB;
};
inline LinesCrossing crossingOf(const Vec3& startA, const Vec3& directionA, const Vec3& startB, const Vec3& directionB)
{
	const Vec3 between = startA - startB;
	const double cosine = dot(directionA, directionB), a = dot(directionA, between), b = dot(directionB, between);
	const double sineSquared = 1 - cosine * cosine;
	return {(cosine * b - a) / sineSquared, (b - cosine * a) / sineSquared};
}
}  // namespace clod
