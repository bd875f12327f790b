// SPDX-License-Identifier: Zlib
#include "clod/hierarchy/ConvexPiece.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "clod/hierarchy/BoundGrid.h"

namespace clod
{
namespace
{
constexpr double kArea = 0.01;                // of the radius: Asset::areaTolerance
constexpr double kRoom = 1 + 1e-6;            // for the rounding of sums

class Piece
{
public:
	Piece(const ConvexPolyhedron& polyhedron, double radius)
		: m_vertices(polyhedron.vertices), m_triangles(polyhedron.triangles), m_isThin(polyhedron.triangles.empty())
	{
		const std::uint32_t last = std::uint32_t(m_vertices.size() - 1);
		if (m_isThin) m_triangles = {{0, last, last}, {0, last, last}};
		asset(radius);
		node();
		faces();
		box();
		level();
	}
	HierarchyContent& content() { return m_content; }

private:
	void asset(double radius);
	void masses();
	void node();
	void faces();
	void linkFaces();
	void box();
	void level();

	const std::vector<Vec3>& m_vertices;
	std::vector<std::array<std::uint32_t, 3>> m_triangles;
	HierarchyContent m_content;
	Vec3 m_low, m_high, m_center;
	double m_extent = 0;  // of the vertices about the centre
	bool m_isThin = false;
};

void Piece::asset(double radius)
{
	constexpr double kFar = std::numeric_limits<double>::infinity();
	m_low = {kFar, kFar, kFar};
	m_high = -m_low;
	for (const Vec3& v : m_vertices)
		for (int i = 0; i < 3; ++i)
		{
			m_low[i] = std::min(m_low[i], v[i]);
			m_high[i] = std::max(m_high[i], v[i]);
		}
	const Vec3 middle = 0.5 * (m_low + m_high);
	for (const Vec3& v : m_vertices) m_extent = std::max(m_extent, length(v - middle));
	Asset& a = m_content.asset;
	a.radius = roundUp(std::max(m_extent + radius, double(std::numeric_limits<float>::min())));
	for (int i = 0; i < 3; ++i) a.sphereCenter[i] = nearestAnchor(middle[i], a.radius);
	m_center = toVec3(a.sphereCenter);
	m_extent = 0;
	for (const Vec3& v : m_vertices) m_extent = std::max(m_extent, length(v - m_center));
	a.radius = roundUp(std::max(double(a.radius), kRoom * (m_extent + radius)));
	store(a.boxMin, m_low);
	store(a.boxMax, m_high);
	a.storageTolerance = roundUp(kStorageShare * double(a.radius));
	a.areaTolerance = boundAtLeast(kArea * double(a.radius));
	a.triangleCount = std::uint32_t(m_triangles.size());
	a.componentCount = 1;
	a.flags = m_isThin ? kThinCore : 0;
	masses();
}

// Of the polyhedron alone: who moves an engine's shape knows its own.
void Piece::masses()
{
	Asset& a = m_content.asset;
	a.volume = a.inertia[0] = a.inertia[1] = a.inertia[2] = a.principal[3] = 1;
	if (m_isThin) return;
	double volume = 0, second[3] = {};
	for (const auto& t : m_triangles)
	{
		const Vec3 p[3] = {m_vertices[t[0]] - m_center, m_vertices[t[1]] - m_center, m_vertices[t[2]] - m_center};
		const double v = dot(p[0], cross(p[1], p[2])) / 6;
		const Vec3 sum = p[0] + p[1] + p[2];
		volume += v;
		for (int i = 0; i < 3; ++i)
		{
			double s = sum[i] * sum[i];
			for (const Vec3& q : p) s += q[i] * q[i];
			second[i] += v / 20 * s;
		}
	}
	a.volume = volume;
	for (int i = 0; i < 3; ++i) a.inertia[i] = second[(i + 1) % 3] + second[(i + 2) % 3];
}

void Piece::node()
{
	Node n{};
	n.flags = kClodNode;
	n.vertexCount = std::uint32_t(m_vertices.size());
	n.faceCount = std::uint32_t(m_triangles.size());
	n.inward[1] = -1;
	n.meanNormal[1] = 1;
	n.coneCosine = -1;
	// Without end, so that the partner's alone counts.
	n.contactArea = kLargestBound;
	m_content.nodes.push_back(n);
	for (std::size_t i = 0; i < (m_vertices.size() + kVertexLanes - 1) / kVertexLanes * kVertexLanes; ++i)
	{
		const Vec3& v = m_vertices[std::min(i, m_vertices.size() - 1)];
		m_content.hullX.push_back(roundToFloat(v.x));
		m_content.hullY.push_back(roundToFloat(v.y));
		m_content.hullZ.push_back(roundToFloat(v.z));
	}
}

void Piece::faces()
{
	for (const auto& t : m_triangles)
	{
		Face face{};
		for (std::size_t i = 0; i < 3; ++i) face.vertex[i] = std::uint16_t(t[i]);
		const Vec3 normal =
			normalized(cross(m_vertices[t[1]] - m_vertices[t[0]], m_vertices[t[2]] - m_vertices[t[0]]));
		store(face.normal, m_isThin ? Vec3{0, 1, 0} : normal);
		const Vec3 stored = toVec3(face.normal);
		double highest = -std::numeric_limits<double>::infinity();
		for (const std::uint32_t v : t) highest = std::max(highest, dot(stored, m_vertices[v]));
		face.offset = roundUp(highest);
		face.source = std::uint32_t(m_content.faces.size());
		m_content.faces.push_back(face);
	}
	if (!m_isThin) return linkFaces();
	for (std::uint32_t side = 0; side < 2; ++side)
		for (std::uint32_t& neighbour : m_content.faces[side].neighbour) neighbour = 1 - side;
}

void Piece::linkFaces()
{
	// Sides by the corner that they start at.
	std::vector<std::uint32_t> first(m_vertices.size() + 1), sides(3 * m_triangles.size());
	for (const auto& t : m_triangles)
		for (const std::uint32_t v : t) ++first[v];
	std::partial_sum(first.begin(), first.end(), first.begin());
	for (std::uint32_t side = 0; side < sides.size(); ++side) sides[--first[m_triangles[side / 3][side % 3]]] = side;
	for (std::uint32_t side = 0; side < sides.size(); ++side)
	{
		const std::uint32_t from = m_triangles[side / 3][side % 3], to = m_triangles[side / 3][(side + 1) % 3];
		std::uint32_t at = first[to];
		while (m_triangles[sides[at] / 3][(sides[at] + 1) % 3] != from) ++at;
		m_content.faces[side / 3].neighbour[side % 3] = sides[at] / 3;
	}
}

void Piece::box()
{
	const float radius = m_content.asset.radius;
	OrientedBox b{};
	double corner = 0;
	for (int i = 0; i < 3; ++i)
	{
		b.center[i] = nearestAnchor(0.5 * (m_low[i] + m_high[i]), radius);
		b.half[i] = boundAtLeast(kRoom * std::max(m_high[i] - double(b.center[i]), double(b.center[i]) - m_low[i]));
		b.axis[i][i] = 1;
		corner += double(b.half[i]) * double(b.half[i]);
	}
	double farthest = 0;
	for (const Vec3& v : m_vertices) farthest = std::max(farthest, length(v - toVec3(b.center)));
	b.radius = boundAtLeast(std::min(kRoom * farthest, kRoom * std::sqrt(corner)));
	m_content.cullBoxes.push_back(b);
}

void Piece::level()
{
	Level l{};
	l.nodeCount = 1;
	l.faceCount = std::uint32_t(m_triangles.size());
	l.flags = kClodNode;
	m_content.levels.push_back(l);
}
}  // namespace

Result<std::shared_ptr<const Hierarchy>> convexPiece(const ConvexPolyhedron& polyhedron, double radius)
{
	if (polyhedron.vertices.empty() || !std::isfinite(radius) || radius < 0)
		return Error{"a convex piece needs a vertex, and a finite radius that is not negative"};
	for (const Vec3& v : polyhedron.vertices)
		if (!isFinite(v)) return Error{"a vertex of a convex piece is not finite"};
	if (polyhedron.vertices.size() > std::numeric_limits<std::uint16_t>::max())
		return Error{"a convex piece has " + std::to_string(polyhedron.vertices.size()) +
					 " vertices, at most 65535 can be named"};
	if (polyhedron.triangles.empty() && polyhedron.vertices.size() > 2)
		return Error{"a convex piece has more than two vertices, but no triangles"};
	Piece piece(polyhedron, radius);
	if (!(piece.content().asset.volume > 0)) return Error{"a convex piece is flat"};
	return Hierarchy::fromOwnBytes(encode(piece.content()));
}
}  // namespace clod
