// SPDX-License-Identifier: GPL-3.0-or-later
// A closed triangle mesh with what brute force asks of it: edges, pseudonormals, a tree of boxes, mass. Shares nothing
// with the contact code.
//
// Sources: Baerentzen & Aanaes, Signed distance computation using the angle weighted pseudonormal (2005).
#pragma once
#include "tests/oracle/Subject.h"

namespace clod::oracle
{
struct Box
{
	Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
	void add(const Vec3& p);
	void add(const Box& box);
	double distanceSquared(const Vec3& p) const;
};
// The largest gap along an axis; negative where they meet.
double gap(const Box& a, const Box& b);
Box transformed(const Box& box, const Transform& transform);

struct BoxNode
{
	Box box;
	std::uint32_t first, count;  // count > 0: faces order[first ...]; else children first and first + 1
};

struct Edge
{
	std::uint32_t vertex[2];
	std::uint32_t face[2];
};

class Solid
{
public:
	// Throws std::runtime_error where the mesh is not closed and oriented. Density 1.
	explicit Solid(const TriangleMesh& mesh);

	const TriangleMesh& mesh() const { return m_mesh; }
	const std::vector<Edge>& edges() const { return m_edges; }
	// The edges whose first face is this one: every edge has one owner.
	const std::vector<std::uint32_t>& ownEdges(std::uint32_t face) const { return m_ownEdges[face]; }
	const std::vector<BoxNode>& nodes() const { return m_nodes; }
	std::uint32_t ordered(std::uint32_t i) const { return m_order[i]; }
	const Vec3& corner(std::uint32_t face, std::size_t i) const { return m_mesh.vertices[m_mesh.triangles[face][i]]; }
	const Vec3& normal(std::uint32_t face) const { return m_normals[face]; }
	const Box& faceBox(std::uint32_t face) const { return m_faceBoxes[face]; }
	// One vertex of each component.
	const std::vector<std::uint32_t>& seeds() const { return m_seeds; }

	// Signed distance to the surface, negative inside; brute force over the tree.
	double signedDistance(const Vec3& point) const { return nearest(point).distance; }
	struct Nearest
	{
		double distance;  // signed
		Vec3 point;
	};
	Nearest nearest(const Vec3& point) const;
	// How far along the unit direction the surface is left for good nearest: the first face met from inside, or `most`.
	double exitDistance(const Vec3& from, const Vec3& direction, double most) const;

	double volume() const { return m_volume; }
	const Vec3& center() const { return m_center; }  // of mass
	const Mat3& inertia() const { return m_inertia; }  // about it
	double radius() const { return m_radius; }  // of the sphere round it

private:
	void findEdges();
	void findPseudonormals();
	void findMass();
	void findSeeds();
	void split(std::uint32_t node, std::uint32_t first, std::uint32_t count);

	TriangleMesh m_mesh;
	std::vector<Edge> m_edges;
	std::vector<std::vector<std::uint32_t>> m_ownEdges;
	std::vector<std::array<std::uint32_t, 3>> m_faceEdges;  // edge i from corner i to the next
	std::vector<Vec3> m_normals, m_edgeNormals, m_vertexNormals;
	std::vector<BoxNode> m_nodes;
	std::vector<Box> m_faceBoxes;
	std::vector<std::uint32_t> m_order, m_seeds;
	double m_volume = 0, m_radius = 0;
	Vec3 m_center;
	Mat3 m_inertia;
};
}  // namespace clod::oracle
