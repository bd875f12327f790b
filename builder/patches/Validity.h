// SPDX-License-Identifier: GPL-3.0-or-later
// When a set of faces is a convex patch, within a tolerance eps:
//   edges   the far corners at an interior edge lie at most eps above the other face;
//   G1      every vertex of the patch lies at most 2 eps above every face's plane;
//   G2      no other face enters the hull of the patch deeper than 4 eps;
//   cover   where the hull is thinner than that (8 eps under a face's plane), its front is the patch itself or lies
//           inside the solid, within 8 eps: a flat hull must not span a notch.
// Sources: Ehmann & Lin 2001 (the convexity constraints); the paper, sec. 4.1. The last rule is ours.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "builder/patches/PatchMesh.h"
#include "builder/patches/SmallHull.h"

namespace clod::builder
{
// Two vertices u and w of the mesh imagined at one position; faces that hold both do not exist.
struct Move
{
	std::uint32_t u = kNone, w = kNone;
	Vec3 position;
	std::vector<std::uint32_t> faces;  // that survive with a moved corner
	std::vector<Plane> planes;         // theirs after the move
	bool moves(std::uint32_t vertex) const { return vertex == u || vertex == w; }
};

class Remainder;

class Validity
{
public:
	explicit Validity(const PatchMesh& mesh);
	double tolerance = 0;  // eps
	Move move;             // none by default
	// Whether the cover rule also holds for the mean plane of a patch that is thin as a whole, and areas that sheets
	// within the rule's depth cover twice count once. Asked for at level 0, which has no error that what a hull sticks
	// out could be part of.
	bool isExact = false;

	// Starts an empty patch; grow() adds faces to it as long as they keep it valid.
	void clear();
	bool grow(std::uint32_t face);
	std::vector<Plane> grownHull() const;
	// Whether the union of two patches is valid; hull() then holds its planes.
	bool canJoin(std::uint32_t a, std::uint32_t b);
	// Whether a patch that was valid keeps its edges and G1 under the move; then whether it keeps G2 and cover as well.
	bool keepsConvex(std::uint32_t patch);
	bool keepsInside(std::uint32_t patch);
	// Cover alone, for a patch whose own faces do not move.
	bool keepsCovered(std::uint32_t patch);
	// Cover of faces that are no patch yet, or a closed one.
	bool coversItself(const std::vector<std::uint32_t>& faces);
	// Whether the hull of a patch is flat and spans open space that is farther from the surface than twice the rule's
	// depth: what a file may not hold. Patches on the way to a level may.
	bool spansNotch(std::uint32_t patch);
	// Everything from scratch, edge-connectedness included.
	bool isValid(const std::vector<std::uint32_t>& faces);

	const std::vector<Plane>& hull() const { return m_hullPlanes; }
	// Faces of other patches that the last cover needed: moving them can uncover the patch.
	const std::vector<std::uint32_t>& supports() const { return m_supports; }
	TrianglePoints points(std::uint32_t face) const;

private:
	static constexpr double kDepth = 4;                            // eps: how deep a hull may be entered
	static constexpr double kBlind = 2 * kDepth;                   // eps: thinner hulls are judged by their cover
	double minimumHeight() const { return 1e-9 * m_mesh.radius; }  // of hull triangles whose planes are used
	void load(const std::vector<std::uint32_t>& faces);
	void addFace(std::uint32_t face);
	void addPoint(std::uint32_t vertex);
	bool contains(std::uint32_t face) const { return m_faceStamp[face] == m_stamp; }
	bool isMoved(std::uint32_t face) const;
	bool vanishes(std::uint32_t face) const;
	std::uint32_t neighbour(std::uint32_t face, int k) const;
	bool growsConvex(std::uint32_t face) const;
	bool edgesStayConvex(std::uint32_t patch) const;
	bool isBelowAllPlanes() const;
	bool isConnected() const;
	bool isInside(const SmallHull& hull);
	bool isCovered();
	// Cover.cpp
	struct Front;
	double depthUnderMean();
	bool spansNotch();
	std::optional<Front> frontOf(const Plane& plane, const Vec3& origin) const;
	bool frontIsCovered(const Plane& plane, const Vec3& origin);
	double shownCover(const Front& front);
	double dippingCover(const Front& front) const;
	double strips(const Front& front) const;
	double foreignCover(const Front& front);
	double doubleCover(const Front& front) const;
	Remainder remainderOf(const Front& front, double border, double depth, bool byAny) const;
	std::uint32_t nearestFace(const Vec3& p, double limit) const;
	// visit(face, points) -> bool for every face of the mesh, under the move, that meets the box and is not in the
	// patch.
	template <class Visit>
	bool searchForeign(const Box& box, Visit&& visit) const;

	const PatchMesh& m_mesh;
	std::vector<std::uint32_t> m_faceStamp, m_vertexStamp;
	std::uint32_t m_stamp = 0;
	std::vector<std::uint32_t> m_faces;
	std::vector<TrianglePoints> m_facePoints;
	std::vector<Plane> m_facePlanes;
	std::vector<Vec3> m_points;
	Box m_box;
	std::vector<std::uint32_t> m_supports;
	SmallHull m_hull, m_trial;
	std::vector<Plane> m_hullPlanes;
	Plane m_meanPlane;
	std::vector<char> m_covered;  // per face of the patch: judged with an earlier coplanar face
};
template <class Visit>
bool Validity::searchForeign(const Box& box, Visit&& visit) const
{
	const bool searched = m_mesh.faceTree.search(
		box, [&](std::uint32_t face) { return contains(face) || isMoved(face) || visit(face, m_mesh.points(face)); });
	if (!searched) return false;
	for (const std::uint32_t face : move.faces)
		if (!contains(face) && !visit(face, points(face))) return false;
	return true;
}
}  // namespace clod::builder
