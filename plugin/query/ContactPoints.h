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

#include "clod/query/Query.h"

namespace clod
{
// A candidate contact. Where B is a plane or a foreign triangle, nodeB is the part and faceB the index its owner gave.
struct ContactPoint
{
	Vec3 pointOnA, pointOnB;  // pointOnA - pointOnB = height * normal
	Vec3 normal;              // unit, from B to A
	double height;            // signed distance; negative is penetration
	double predicted;         // height at the end of the step if nothing intervened, lengths along the normal
	std::uint32_t nodeA, nodeB;
	std::uint32_t faceA, faceB;  // global face indices; kNone where there is none (a plane)
	bool referenceIsA;
	bool atBottom;  // where the reference face's stored thickness ends: the true depth may be larger
};

// Velocity field of A's material relative to B's, in some frame: velocity(p) = linear + angular x p.
struct RelativeMotion
{
	Vec3 linear, angular;
	double timeStep = 0;  // seconds; 0 = no prediction
	Vec3 velocity(const Vec3& point) const { return linear + cross(angular, point); }
};
// The same field in another frame; hereFromThere maps that frame into the field's.
RelativeMotion inFrame(const RelativeMotion& motion, const Transform& hereFromThere);

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
inline constexpr double kOpposingCosine = -0.3;     // faces whose normals agree better than this cannot touch
inline constexpr double kPredictionSlack = 1.1;     // a speculative point may be this much farther than its approach
inline constexpr double kUnderPatchShare = 0.0005;  // slack of "ends under the reference patch", share of length
inline constexpr double kTieCurvature = 1e-6;       // curvatures closer than this / length are equal

// A convex polygon left of a triangle after clipping.
struct ClippedPolygon
{
	static constexpr int kMost = 8;
	std::array<Vec3, kMost> vertex;
	int count = 0;
};

// The region a reference face answers for: over and under its triangle, between three side planes.
struct FacePrism
{
	Vec3 normal;
	double offset = 0;
	std::array<Vec3, 3> side;  // outward
	std::array<double, 3> sideOffset{};
	double top = 0, bottom = 0;  // heights, bottom <= top
	double heightOf(const Vec3& p) const { return dot(normal, p) - offset; }
	bool sidesHold(const Vec3& p) const
	{
		for (std::size_t i = 0; i < 3; ++i)
			if (dot(side[i], p) > sideOffset[i]) return false;
		return true;
	}
};

// Is a height that came out of clipToPrism the prism's bottom?
inline bool atBottom(const FacePrism& prism, double height)
{
	return height <= prism.bottom * (1 - 1e-9);
}

using Triangle = std::array<Vec3, 3>;

Triangle triangleOf(const Hierarchy& hierarchy, const Node& node, const Face& face);
// Side planes through the edges that bisect this face and its neighbours; bottom = -thickness, top = 0.
FacePrism prismOf(const Hierarchy& hierarchy, const Node& node, const Face& face);
// Side planes perpendicular to a triangle whose neighbours are unknown; false for a triangle without area.
bool prismOf(const Triangle& triangle, FacePrism& prism);
// The part of the triangle inside the prism; count 0 when there is none.
ClippedPolygon clipToPrism(const FacePrism& prism, const Triangle& triangle);

// Node::curvature, refined for ties: dihedral angles of the border edges included (half weight).
double bendWithBorder(const Hierarchy& hierarchy, const Node& node);

// Faces and vertices of one node, moved into the reference's frame. Grown once, reused.
struct MovedPatch
{
	std::vector<Vec3> vertices;
	std::vector<Vec3> normals;
	std::vector<Triangle> triangles;
	std::vector<std::uint32_t> faces;  // global indices of the faces kept
	struct Ball
	{
		Vec3 center;
		double radius;
	};
	std::vector<Ball> balls;  // each holds its triangle, where it is and where it is carried in the step
	Vec3 low, high;
};

// Turns node pairs into points. Holds only buffers: the same input gives the same points whatever came before.
class PointClipper
{
public:
	// Appends the points of all pairs, in the order of the contacts.
	void clip(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const std::vector<Contact>& contacts,
			  const PointRules& rules, std::vector<ContactPoint>& points);

private:
	struct Side;
	void clipPair(const Side& reference, const Side& other, std::vector<ContactPoint>& points);
	MovedPatch m_other;
	std::vector<std::uint32_t> m_referenceFaces;
	const PointRules* m_rules = nullptr;
	Transform m_aFromB;
};

// Which points of a clipped triangle count, all in the reference's frame; otherMotion is the other body's relative to
// the reference.
struct PointFilter
{
	const PointRules* rules;
	RelativeMotion otherMotion;
	double topFor(const FacePrism& prism, const Vec3& near, double reach) const;
	// Over a face, of points that are carried into its prism.
	double arrivalTop() const { return rules->margin + kUnderPatchShare * rules->length; }

	// Calls emit(point, height, predicted) for every point of the triangle that is in touch with the face under the
	// prism, or will be by the end of the step:
	//  - in the prism and at most the resting height over the face;
	//  - in the prism, higher, and carried under all planes of the reference patch (`under`);
	//  - beside the prism and carried into it, under its face: a body that slides towards a concave edge.
	template <class Planes, class Emit>
	void visit(const FacePrism& prism, const Triangle& triangle, const Planes& under, const Emit& emit) const
	{
		const ClippedPolygon here = clipToPrism(prism, triangle);
		for (int i = 0; i < here.count; ++i)
		{
			const Vec3& point = here.vertex[std::size_t(i)];
			double predicted = 0;
			if (keep(prism, point, under, predicted)) emit(point, prism.heightOf(point), predicted);
		}
		if (prism.top <= rules->margin + rules->resting) return;  // nothing moves
		visitCarried(prism, triangle, emit);
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
	void visitCarried(const FacePrism& prism, const Triangle& triangle, const Emit& emit) const
	{
		Triangle moved = triangle;
		for (Vec3& corner : moved) corner += otherMotion.timeStep * otherMotion.velocity(corner);
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
}  // namespace clod
