// SPDX-License-Identifier: Zlib
// From node pairs within the tolerance to contact points, by one-way face clipping: of each pair the less convex patch
// is the reference; the other patch's real faces are clipped to the prisms over the reference's real faces; every
// vertex of what remains is a candidate point whose normal is the reference face's. Knows no physics engine.
//
// Frames and signs: everything in body A's frame; normals point from B to A; heights are signed, negative is
// penetration. Unit: the hierarchies' own. Departs from Otaduy & Lin 2003, sec. 5: witness points of hull pairs make
// ghost forces at patch borders in an engine that keeps bodies in touch, clipped real faces do not.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "clod/manifold/MovedPatch.h"
#include "clod/query/Query.h"
#include "clod/collide/RelativeMotion.h"

namespace clod
{
// A candidate contact. Where B is a plane or a foreign triangle, nodeB is the part and faceB the index its owner gave.
struct ContactPoint
{
	Vec3 pointOnA, pointOnB;  // pointOnA - pointOnB = (height + margin) * normal
	Vec3 normal;              // unit, from B to A
	double height;            // signed distance of the surfaces grown by the margin; negative is penetration
	double predicted;         // height at the end of the step if nothing intervened, lengths along the normal
	std::uint32_t nodeA, nodeB;
	std::uint32_t faceA, faceB;  // global face indices; kNone where there is none (a plane)
	bool referenceIsA;
	bool atBottom;  // where the reference face's stored thickness ends: the true depth may be larger
};

struct PointRules
{
	double length = 1;      // the smaller bounding radius of the pair: every tolerance below is a share of it
	double resting = 0;     // points up to this height are contacts whatever the motion
	double margin = 0;      // sum of both bodies' margins: surfaces touch at this height
	RelativeMotion motion;  // frame A
};

inline constexpr double kRestingShare = 0.001;  // default resting height, share of PointRules::length
// Bodies of a simulation rest this share of the length apart: a step over a curved surface overshoots by about as much
// (0.03 mm in the spoon-cup scene at 0.1 m/s), and full meshes shall not intersect. An adapter adds it to the margins.
inline constexpr double kSkinShare = 0.0005;
inline constexpr double kPredictionSlack = 1.1;     // a speculative point may be this much farther than its approach
inline constexpr double kUnderPatchShare = 0.0005;  // slack of "ends under the reference patch", share of length
inline constexpr double kTieCurvature = 1e-6;       // curvatures closer than this / length are equal

// Is A's patch the reference? The less convex one; ties by border angles, then by content, so that exchanging the
// bodies exchanges the roles.
bool referenceIsA(const Hierarchy& a, const Node& nodeA, const Hierarchy& b, const Node& nodeB, double length);

// Which points of a clipped triangle count, all in the reference's frame; otherMotion is the other body's relative to
// the reference.
struct PointFilter
{
	const PointRules* rules;
	RelativeMotion otherMotion;
	double topFor(const FacePrism& prism, const Vec3& near, double reach) const;
	// Over a face, of points that are carried into its prism.
	double arrivalTop() const { return rules->margin + kUnderPatchShare * rules->length; }

	// Whether a triangle is looked at where it is carried in the step, too.
	bool stepCounts(const FacePrism& prism) const { return prism.top > rules->margin + rules->resting; }
	Triangle carried(const Triangle& triangle) const
	{
		Triangle moved = triangle;
		for (Vec3& corner : moved) corner += otherMotion.timeStep * otherMotion.velocity(corner);
		return moved;
	}

	// Calls emit(point, height, predicted) for every point of the triangle that is in touch with the face under the
	// prism, or will be by the end of the step:
	//  - in the prism and at most the resting height over the face;
	//  - in the prism, higher, and carried under all planes of the reference patch (`under`);
	//  - beside the prism and carried into it, under its face: a body that slides towards a concave edge.
	// moved: the triangle, carried.
	template <class Planes, class Emit>
	void visit(const FacePrism& prism, const Triangle& triangle, const Triangle& moved, const Planes& under,
			   const Emit& emit) const
	{
		const ClippedPolygon here = clipToPrism(prism, triangle);
		for (int i = 0; i < here.count; ++i)
		{
			const Vec3& point = here.vertex[std::size_t(i)];
			double predicted = 0;
			if (keep(prism, point, under, predicted)) emit(point, prism.heightOf(point), predicted);
		}
		if (stepCounts(prism)) visitCarried(prism, moved, emit);
	}

	// False drops a point over the face; predicted receives its height at the end of the step, margins taken off.
	template <class Planes>
	bool keep(const FacePrism& prism, const Vec3& point, const Planes& under, double& predicted) const
	{
		const Vec3 velocity = otherMotion.velocity(point);
		const double approach = -dot(velocity, prism.normal) * otherMotion.timeStep;
		const double height = prism.heightOf(point) - rules->margin;
		predicted = height - (approach > 0 ? approach : 0);
		if (height <= rules->resting) return true;
		if (height > rules->resting + kPredictionSlack * approach) return false;
		const Vec3 moved = point + otherMotion.timeStep * velocity;
		const double slack = rules->margin + kUnderPatchShare * rules->length;
		for (const auto& face : under)
			if (dot(face.first, moved) - face.second > slack) return false;
		return true;
	}

private:
	template <class Emit>
	void visitCarried(const FacePrism& prism, const Triangle& moved, const Emit& emit) const
	{
		FacePrism arrival = prism;
		arrival.top = arrivalTop();
		const ClippedPolygon there = clipToPrism(arrival, moved);
		for (int i = 0; i < there.count; ++i)
		{
			const Vec3& end = there.vertex[std::size_t(i)];
			const Vec3 point = end - otherMotion.timeStep * otherMotion.velocity(end);
			const double height = prism.heightOf(point);
			// Under the face's plane already, or in the prism: the face's own points tell.
			if (height < rules->margin || prism.sidesHold(point)) continue;
			emit(point, height, prism.heightOf(end) - rules->margin);
		}
	}
};
// Turns node pairs into points. Holds only buffers: the same faces give the same points whatever came before.
class PointClipper
{
public:
	// Where on A, and about where on B, frame A; how far from there faces take part, and points are wanted.
	struct Near
	{
		Vec3 onA, onB;
		double within, withinOther, limit;
	};
	// Of the pairs that follow. The hierarchies must live till then.
	void start(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const PointRules& rules);
	// Appends the points of a pair; if a place is given, of those of its faces only that are near it.
	void clip(const Contact& contact, bool referenceIsA, const Near* near, std::vector<ContactPoint>& points);
	// Of two of its faces, named as in ContactPoint.
	void clipFaces(const Contact& contact, bool referenceIsA, std::uint32_t faceA, std::uint32_t faceB,
				   std::vector<ContactPoint>& points);

private:
	// One of the bodies as the reference of a pair.
	struct Role
	{
		const Hierarchy *reference = nullptr, *other = nullptr;
		Transform referenceFromOther;
		PointFilter filter;
		bool isA = false;
	};
	// What was worked out of a node for another pair, a few at a time: patches lie beside many others.
	struct Prepared
	{
		std::uint32_t moved = kNone, reference = kNone;  // nodes
		bool movedIsOfA = false, referenceIsOfA = false;
		MovedPatch patch;
		std::vector<FacePrism> prisms;  // of the reference's faces, where they are known
		std::vector<char> isKnown;
		Vec3 low, high;  // of the reference
		double deepest;  // any face's thickness
	};
	struct Pair
	{
		const Role& role;
		std::uint32_t nodeIndex, otherIndex;
		const Node &node, &other;
	};
	Pair pairOf(const Contact& contact, bool referenceIsA) const;
	MovedPatch& moved(const Pair& pair);
	Prepared& preparedReference(const Pair& pair);
	const FacePrism& prismOfFace(const Pair& pair, Prepared& prepared, std::uint32_t face) const;
	void chooseFaces(const Pair& pair, Prepared& prepared, const Near* near);
	template <class Visit>
	void clipFace(const Pair& pair, const MovedPatch& patch, FacePrism prism, std::uint32_t face, const Near* near,
				  const Visit& visitFaces, std::vector<ContactPoint>& points) const;

	static constexpr std::size_t kPrepared = 16;
	std::array<Prepared, kPrepared> m_prepared;
	PointRules m_rules;
	Transform m_aFromB;
	std::array<Role, 2> m_roles;         // A as the reference, B
	std::vector<std::uint32_t> m_faces;  // of the reference, to be clipped
};
}  // namespace clod
