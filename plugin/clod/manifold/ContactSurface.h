// SPDX-License-Identifier: Zlib
// A surface as contacts see it: a mesh with all that contact facets ask of it, namely convex edges with the normals of
// both polygons, vertices with the edges that leave them, and a tree for the nearest face. Edges between coplanar
// triangles are no features, and reflex edges are touched by vertices only.
//
// A level of detail is a closed surface. A sheet, which is what an engine's own mesh is, has two sides: each triangle
// is there twice, back to back, and a border is an edge folded by half a turn; so it is closed, too, but has no inside.
// A half space is one face without end. A thin core (of a sphere or a capsule) is a vertex, or two vertices and the
// edge between them, without faces: the edge's normals and inward vectors are zero.
//
// Frame and unit: the body's, of a hierarchy. Immutable once made.
#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "clod/Export.h"
#include "clod/collide/Box.h"
#include "clod/hierarchy/Hierarchy.h"

namespace clod
{
struct SurfaceFace
{
	std::array<std::uint32_t, 3> vertex;     // counter-clockwise from outside
	std::array<std::uint32_t, 3> neighbour;  // across edge (vertex[i], vertex[i + 1])
	std::uint32_t polygon;                   // faces of one plane that hang together have the same
	Vec3 normal;                             // unit, outward
	double offset;                           // of its plane
};

// A convex edge. Unit vectors.
struct SurfaceEdge
{
	std::array<std::uint32_t, 2> vertex, face;
	Vec3 direction;               // from vertex[0] to vertex[1]
	double length;
	std::array<Vec3, 2> normal;   // of the faces
	std::array<Vec3, 2> inward;   // in the faces, away from the edge
};

class CLOD_API ContactSurface
{
public:
	struct Nearest
	{
		double distance = 0;  // negative inside
		std::uint32_t face = kNone;
		Vec3 point, normal;  // the pseudonormal there, unit
	};

	// A level's: made of its nodes' faces; of a thin core its vertices.
	ContactSurface(const Hierarchy& hierarchy, std::uint32_t level);
	// A sheet: one node a triangle, whose faces are the triangle and its back. size: tolerances are shares of it.
	// Triangles that share two corners to the bit are neighbours.
	ContactSurface(const std::vector<Triangle>& triangles, double size);
	// A half space, normal . p <= offset, as seen within `size` of a point: one node, one face.
	ContactSurface(const Vec3& normal, double offset, const Vec3& near, double size);

	// A name that is the same whenever the surface is made: the index or, of a sheet, which is gathered anew in every
	// step, a hash of where the feature lies.
	std::uint64_t nameOfVertex(std::uint32_t vertex) const;
	std::uint64_t nameOfEdge(std::uint32_t edge) const;
	std::uint64_t nameOfPolygon(std::uint32_t polygon) const;
	const std::vector<Vec3>& vertices() const { return m_vertices; }
	const std::vector<SurfaceFace>& faces() const { return m_faces; }
	const std::vector<SurfaceEdge>& edges() const { return m_edges; }
	// Unit vectors along all edges that leave a vertex.
	Span<Vec3> fan(std::uint32_t vertex) const { return slice(m_fans, m_firstFan, vertex); }
	// Unit; out of the solid.
	const Vec3& pseudonormal(std::uint32_t vertex) const { return m_pseudonormals[vertex]; }
	// Down along edges, from a vertex to one that has no lower neighbour.
	std::uint32_t lowestFrom(std::uint32_t vertex, const Vec3& up) const;
	// Can this vertex touch something first? Not if it lies inside a polygon, or has reflex edges so that no half space
	// holds all of its edges.
	bool isCorner(std::uint32_t vertex) const { return m_isCorner[vertex] != 0; }
	// One that has it; kNone of a core.
	std::uint32_t faceOfVertex(std::uint32_t vertex) const { return m_faceOfVertex[vertex]; }
	bool isClosed() const { return m_kind == Kind::kClosed; }
	bool isSheet() const { return m_kind == Kind::kSheet; }
	std::uint32_t polygonCount() const { return std::uint32_t(m_firstPolygonFace.size() - 1); }
	bool isHalfSpace() const { return m_kind == Kind::kHalfSpace; }
	bool isCore() const { return m_kind == Kind::kCore; }
	// What belongs to a node of this level: vertices; convex edges, whole even where only a part is the node's; and
	// polygons, with the corners of the node's own triangles of them as indices into its vertices.
	struct NodePolygon
	{
		std::uint32_t polygon, firstCorner, cornerCount;
	};
	Span<std::uint32_t> verticesOf(std::uint32_t node) const { return of(m_nodeVertices, m_firstVertexOf, node); }
	Span<std::uint32_t> edgesOf(std::uint32_t node) const { return of(m_nodeEdges, m_firstEdgeOf, node); }
	Span<NodePolygon> polygonsOf(std::uint32_t node) const { return of(m_nodePolygons, m_firstPolygonOf, node); }
	Span<std::uint16_t> cornersOf(const NodePolygon& polygon) const
	{
		return {m_polygonCorners.data() + polygon.firstCorner, polygon.cornerCount};
	}
	std::uint32_t firstFaceOf(std::uint32_t node) const { return m_firstFaceOf[node - m_firstNode]; }
	std::uint32_t faceCountOf(std::uint32_t node) const
	{
		return m_firstFaceOf[node - m_firstNode + 1] - m_firstFaceOf[node - m_firstNode];
	}

	Span<std::uint32_t> facesOf(std::uint32_t polygon) const { return slice(m_polygonFaces, m_firstPolygonFace, polygon); }
	const SurfaceFace& planeOf(std::uint32_t polygon) const
	{
		return m_faces[m_polygonFaces[m_firstPolygonFace[polygon]]];
	}
	// Mean of a polygon's corners.
	const Vec3& centerOf(std::uint32_t polygon) const { return m_polygonDiscs[polygon].center; }
	double radiusOf(std::uint32_t polygon) const { return m_polygonDiscs[polygon].radius; }
	// Mean length of the edges; of what has none, infinity.
	double grain() const { return m_grain; }
	Vec3 footOn(std::uint32_t polygon, const Vec3& point) const
	{
		const SurfaceFace& plane = planeOf(polygon);
		return point - (dot(plane.normal, point) - plane.offset) * plane.normal;
	}
	// Squared distance of a point's foot on a polygon's plane from the polygon; or what is found first that is no more
	// than `enough`.
	double squaredBeside(std::uint32_t polygon, const Vec3& point, double enough = 0) const;
	// Within so much?
	bool isOver(std::uint32_t polygon, const Vec3& point, double slack) const
	{
		const Disc& disc = m_polygonDiscs[polygon];
		const double fromCenter = lengthSquared(footOn(polygon, point) - disc.center);
		const double farthest = slack + disc.radius, sure = slack - disc.radius;
		if (fromCenter > farthest * farthest) return false;
		return (sure > 0 && fromCenter <= sure * sure) || squaredBeside(polygon, point, slack * slack) <= slack * slack;
	}
	// A node of a sheet that has a triangle of the polygon.
	std::uint32_t sheetNodeOf(std::uint32_t polygon) const { return facesOf(polygon)[0] / 2; }
	// One in the plane through a point, facing that way; kNone if there is none. size: what tolerances are shares of.
	std::uint32_t polygonIn(const Vec3& normal, const Vec3& point, double size) const;
	// Does the polygon hold all of a disc round a point's foot?
	bool isAround(std::uint32_t polygon, const Vec3& point, double radius) const;
	// Of the polygon.
	std::uint32_t nearestFaceOf(std::uint32_t polygon, const Vec3& point) const;
	// Distance of a point to the surface, negative inside; what is farther than `within` is not looked for (face
	// kNone). Precondition: it has faces.
	Nearest nearest(const Vec3& point, double within) const;
	bool isInside(const Vec3& point) const;
	// Calls each(face, share of the way) for every face that the way between two points leads through, or passes by no
	// farther than `beside`.
	template <class Each>
	void forEachCrossed(const Vec3& from, const Vec3& to, double beside, Each each) const;
	// Calls each(face) for every face that a point, no farther than that from its plane, lies over.
	template <class Each>
	void forEachOver(const Vec3& point, double within, Each each) const;
	// Makes the tree now, which otherwise the first overlap makes.
	void makeTree() const;

private:
	static constexpr double kOnShare = 1e-3;  // of how near it is looked for: so far beside a face a point is over it still
	enum class Kind
	{
		kClosed,
		kSheet,
		kHalfSpace,
		kCore
	};
	struct TreeBox : Box
	{
		std::uint32_t first, count;  // faces in m_order; count 0: the two boxes from `first`
	};
	struct Found
	{
		double squared;  // of the distance
		std::uint32_t face = kNone;
		Vec3 point = {};
		int feature = 6;
		void add(std::uint32_t other, const NearestOnTriangle& there);
	};
	// Calls each(face) for the faces of all leaves of the tree that come so near to a box.
	template <class Each>
	void forEachNear(const Box& place, double within, Each each) const;
	Found searchTree(const Vec3& point, double within, std::uint32_t polygon, double enough = 0) const;
	template <class T>
	static Span<T> slice(const std::vector<T>& list, const std::vector<std::uint32_t>& first, std::uint32_t i)
	{
		return {list.data() + first[i], first[i + 1] - first[i]};
	}
	template <class T>
	Span<T> of(const std::vector<T>& list, const std::vector<std::uint32_t>& first, std::uint32_t node) const
	{
		return slice(list, first, node - m_firstNode);
	}
	Triangle triangleOf(std::uint32_t face) const
	{
		const std::array<std::uint32_t, 3>& v = m_faces[face].vertex;
		return {m_vertices[v[0]], m_vertices[v[1]], m_vertices[v[2]]};
	}
	void makeCore(const HullView& vertices);
	void finish(double size, const std::vector<std::uint32_t>& firstFaceOfNode);
	void weld(const Hierarchy& hierarchy, const Level& level);
	void weld(const std::vector<Triangle>& triangles);
	void joinSides();
	void mergePolygons(double size);
	bool isBorderCorner(const SurfaceFace& face, std::size_t corner) const;
	void findFans();
	struct TriangleEdge
	{
		std::array<std::uint32_t, 2> vertex, face;
	};
	std::vector<TriangleEdge> triangleEdges() const;
	SurfaceEdge edgeOf(const TriangleEdge& part) const;
	using EdgeOfFace = std::pair<std::uint32_t, std::uint32_t>;  // face, edge; sorted by the face
	void findEdges(const std::vector<std::uint32_t>& firstFaceOfNode);
	void findDiscs();
	void listNodes(const std::vector<std::uint32_t>& firstFaceOfNode, const std::vector<EdgeOfFace>& edgesOfFaces);
	void split(std::uint32_t box, std::uint32_t first, std::uint32_t count, const std::vector<Vec3>& sums) const;
	Vec3 pseudonormalAt(std::uint32_t face, int feature) const;

	std::vector<Vec3> m_vertices, m_pseudonormals, m_fans;
	std::vector<std::uint32_t> m_firstFan, m_faceOfVertex;
	std::vector<char> m_isCorner;
	std::vector<SurfaceFace> m_faces;
	std::vector<SurfaceEdge> m_edges;
	Kind m_kind = Kind::kClosed;
	std::uint32_t m_firstNode = 0;  // of the level, in the hierarchy
	std::vector<std::uint32_t> m_polygonFaces, m_firstPolygonFace;
	struct Disc  // holds a polygon
	{
		Vec3 center;
		double radius;
	};
	std::vector<Disc> m_polygonDiscs;
	double m_grain = std::numeric_limits<double>::infinity();
	std::vector<std::uint32_t> m_nodeVertices, m_nodeEdges, m_firstVertexOf, m_firstEdgeOf, m_firstPolygonOf, m_firstFaceOf;
	std::vector<NodePolygon> m_nodePolygons;
	std::vector<std::uint16_t> m_polygonCorners;
	// Only overlaps and large polygons ask for them.
	mutable std::once_flag m_treeMade;
	mutable std::vector<TreeBox> m_boxes;
	mutable std::vector<std::uint32_t> m_order;
};

template <class Each>
void ContactSurface::forEachNear(const Box& place, double within, Each each) const
{
	makeTree();
	std::array<std::uint32_t, 64> stack;
	std::size_t size = 0;
	stack[size++] = 0;
	while (size > 0)
	{
		const TreeBox& box = m_boxes[stack[--size]];
		if (!box.meets(place, within)) continue;
		if (box.count == 0)
		{
			stack[size++] = box.first;
			stack[size++] = box.first + 1;
		}
		for (std::uint32_t i = box.first; i < box.first + box.count; ++i) each(m_order[i]);
	}
}

template <class Each>
void ContactSurface::forEachCrossed(const Vec3& from, const Vec3& to, double beside, Each each) const
{
	Box way{from, from};
	way.add(to);
	forEachNear(way, beside,
				[&](std::uint32_t f)
				{
					const SurfaceFace& face = m_faces[f];
					const double start = dot(face.normal, from) - face.offset, end = dot(face.normal, to) - face.offset;
					if (!(start * end < 0)) return;
					const double share = start / (start - end);
					if (nearestOnTriangle(triangleOf(f), from + share * (to - from)).squared <= beside * beside) each(f, share);
				});
}

template <class Each>
void ContactSurface::forEachOver(const Vec3& point, double within, Each each) const
{
	forEachNear({point, point}, within,
				[&](std::uint32_t f)
				{
					const SurfaceFace& face = m_faces[f];
					const double height = dot(face.normal, point) - face.offset;
					if (std::abs(height) > within) return;
					const double beside = nearestOnTriangle(triangleOf(f), point).squared - height * height;
					if (beside <= kOnShare * kOnShare * within * within) each(face);
				});
}

// The coarsest level whose surface is nowhere farther than that from the input's; level 0 if there is none.
const Level& coarsestWithin(const Hierarchy& hierarchy, double error);
// Of the hulls of successive nodes.
std::vector<Vec3> cornersOf(const Hierarchy& hierarchy, std::uint32_t firstNode, std::uint32_t count);

// All levels of a hierarchy, each made when first asked for. Kept with it (Hierarchy::derived).
class CLOD_API ContactSurfaces
{
public:
	explicit ContactSurfaces(const Hierarchy& hierarchy);
	~ContactSurfaces();
	// May be called by several threads.
	const ContactSurface& level(std::uint32_t level) const
	{
		const ContactSurface* made = m_made[level].load(std::memory_order_acquire);
		return made ? *made : make(level);
	}

private:
	const ContactSurface& make(std::uint32_t level) const;
	const Hierarchy& m_hierarchy;
	mutable std::mutex m_making;
	std::unique_ptr<std::atomic<const ContactSurface*>[]> m_made;
};
}  // namespace clod
