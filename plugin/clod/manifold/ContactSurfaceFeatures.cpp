// SPDX-License-Identifier: Zlib
// What is found on a mesh: flat polygons, vertices that are corners, edges between polygons, and what a node has of them.
#include <algorithm>
#include <cmath>
#include <utility>

#include "clod/manifold/ContactSurface.h"

namespace clod
{
namespace
{
// Coordinates are stored in float: planes whose vertices agree so well (share of the radius) are one.
constexpr double kCoplanar = 2e-6;
constexpr double kCoplanarCosine = 0.9999;  // and their normals
constexpr double kFlatEdge = 1e-4;          // sine; edges folded less are no features
constexpr double kStraight = 1e-4;          // sine; edges that turn less at a vertex are one

double angleBetween(const Vec3& a, const Vec3& b)
{
	return std::atan2(length(cross(a, b)), dot(a, b));
}

// Is there a direction with which none of these makes an obtuse angle? If so one is at right angles to two of them, or
// the guess is one.
bool fitHalfSpace(Span<Vec3> directions, const Vec3& guess)
{
	const auto holds = [&directions](const Vec3& axis)
	{
		const double lowest = -1e-3 * length(axis);
		return std::all_of(directions.begin(), directions.end(), [&](const Vec3& d) { return dot(d, axis) >= lowest; });
	};
	if (guess != Vec3{} && holds(guess)) return true;
	for (std::size_t i = 0; i < directions.size; ++i)
		for (std::size_t j = 0; j < i; ++j)
		{
			const Vec3 axis = cross(directions[i], directions[j]);
			if (length(axis) > 1e-6 && (holds(axis) || holds(-axis))) return true;
		}
	return false;
}

std::uint32_t otherEnd(const std::array<std::uint32_t, 2>& ends, std::uint32_t end)
{
	return ends[0] == end ? ends[1] : ends[0];
}

// Where an edge goes on straight. Of a vertex with two edges between polygons, which then are the same two polygons'.
struct EdgeEnds
{
	std::uint32_t count = 0;
	std::array<std::uint32_t, 2> edge{};
	bool isStraight = false;
};
}  // namespace

// Faces are added to the plane of the polygon's largest face.
void ContactSurface::mergePolygons(double size)
{
	std::vector<std::pair<double, std::uint32_t>> bySize(m_faces.size());  // largest first
	for (std::uint32_t f = 0; f < m_faces.size(); ++f)
	{
		const Triangle t = triangleOf(f);
		bySize[f] = {-length(cross(t[1] - t[0], t[2] - t[0])), f};
		m_faces[f].polygon = kNone;
	}
	std::sort(bySize.begin(), bySize.end());
	m_firstPolygonFace.reserve(m_faces.size() + 1);
	m_polygonFaces.reserve(m_faces.size());
	std::vector<std::uint32_t> open;
	for (const auto& [area, seed] : bySize)
	{
		if (m_faces[seed].polygon != kNone) continue;
		const Vec3 normal = m_faces[seed].normal;
		const double offset = dot(normal, m_vertices[m_faces[seed].vertex[0]]);
		const auto isOnPlane = [&](std::uint32_t v)
		{ return std::abs(dot(normal, m_vertices[v]) - offset) < kCoplanar * size; };
		open.assign(1, seed);
		const std::uint32_t polygon = std::uint32_t(m_firstPolygonFace.size());
		m_firstPolygonFace.push_back(std::uint32_t(m_polygonFaces.size()));
		m_faces[seed].polygon = polygon;
		while (!open.empty())
		{
			m_polygonFaces.push_back(open.back());
			SurfaceFace& face = m_faces[open.back()];
			open.pop_back();
			face.normal = normal;
			face.offset = offset;
			for (const std::uint32_t next : face.neighbour)
			{
				SurfaceFace& other = m_faces[next];
				if (other.polygon != kNone || dot(other.normal, normal) < kCoplanarCosine) continue;
				if (!std::all_of(other.vertex.begin(), other.vertex.end(), isOnPlane)) continue;
				other.polygon = polygon;
				open.push_back(next);
			}
		}
	}
	m_firstPolygonFace.push_back(std::uint32_t(m_polygonFaces.size()));
}

// Has the face's own back beyond an edge at that corner?
bool ContactSurface::isBorderCorner(const SurfaceFace& face, std::size_t corner) const
{
	const std::uint32_t own = std::uint32_t(&face - m_faces.data()) / 2;
	return face.neighbour[corner] / 2 == own || face.neighbour[(corner + 2) % 3] / 2 == own;
}

void ContactSurface::findFans()
{
	m_pseudonormals.assign(m_vertices.size(), Vec3{});
	m_firstFan.assign(m_vertices.size() + 1, 0);
	for (const SurfaceFace& face : m_faces)
		for (const std::uint32_t v : face.vertex) ++m_firstFan[v + 1];
	for (std::size_t v = 0; v < m_vertices.size(); ++v) m_firstFan[v + 1] += m_firstFan[v];
	m_fans.resize(m_firstFan.back());
	std::vector<std::uint32_t> end = m_firstFan, polygon(m_vertices.size(), kNone);
	std::vector<char> isFlat(m_vertices.size(), 1);
	for (const SurfaceFace& face : m_faces)
		for (std::size_t i = 0; i < 3; ++i)
		{
			const std::uint32_t v = face.vertex[i];
			const Vec3 next = normalized(m_vertices[face.vertex[(i + 1) % 3]] - m_vertices[v]);
			const Vec3 previous = normalized(m_vertices[face.vertex[(i + 2) % 3]] - m_vertices[v]);
			m_pseudonormals[v] += angleBetween(next, previous) * face.normal;
			m_fans[end[v]++] = next;
			if (polygon[v] == kNone) polygon[v] = face.polygon;
			const bool isBack = m_kind == Kind::kSheet && !isBorderCorner(face, i) &&
								dot(face.normal, planeOf(polygon[v]).normal) < -kCoplanarCosine;
			if (polygon[v] != face.polygon && !isBack) isFlat[v] = 0;
		}
	m_isCorner.resize(m_vertices.size());
	for (std::uint32_t v = 0; v < m_vertices.size(); ++v)
	{
		m_pseudonormals[v] = normalized(m_pseudonormals[v]);
		Vec3 guess = -m_pseudonormals[v];
		if (m_kind == Kind::kSheet)
			for (const Vec3& direction : fan(v)) guess += direction;
		m_isCorner[v] = isFlat[v] == 0 && fitHalfSpace(fan(v), guess);
	}
}

// Between two triangles of different polygons, by both.
std::vector<ContactSurface::TriangleEdge> ContactSurface::triangleEdges() const
{
	std::vector<TriangleEdge> edges;
	edges.reserve(3 * m_faces.size() / 2);
	for (std::uint32_t f = 0; f < m_faces.size(); ++f)
		for (std::size_t i = 0; i < 3; ++i)
		{
			const SurfaceFace& face = m_faces[f];
			const std::uint32_t g = face.neighbour[i];
			if (g < f || face.polygon == m_faces[g].polygon) continue;
			edges.push_back({{face.vertex[i], face.vertex[(i + 1) % 3]}, {f, g}});
		}
	return edges;
}

SurfaceEdge ContactSurface::edgeOf(const TriangleEdge& part) const
{
	SurfaceEdge edge;
	edge.vertex = part.vertex;
	edge.face = part.face;
	const Vec3 along = m_vertices[edge.vertex[1]] - m_vertices[edge.vertex[0]];
	edge.length = length(along);
	edge.direction = normalized(along);
	edge.normal = {m_faces[part.face[0]].normal, m_faces[part.face[1]].normal};
	edge.inward = {normalized(cross(edge.normal[0], edge.direction)), normalized(cross(edge.direction, edge.normal[1]))};
	return edge;
}

// Edges of triangles that go on straight are one; reflex ones are no features. Corners lie at an edge's ends only.
void ContactSurface::findEdges(const std::vector<std::uint32_t>& firstFaceOfNode)
{
	const std::vector<TriangleEdge> parts = triangleEdges();
	const auto directionOf = [this](const TriangleEdge& part)
	{ return normalized(m_vertices[part.vertex[1]] - m_vertices[part.vertex[0]]); };
	std::vector<EdgeEnds> ends(m_vertices.size());
	for (std::uint32_t e = 0; e < parts.size(); ++e)
		for (const std::uint32_t v : parts[e].vertex)
		{
			if (ends[v].count < 2) ends[v].edge[ends[v].count] = e;
			++ends[v].count;
		}
	for (std::uint32_t v = 0; v < m_vertices.size(); ++v)
	{
		if (ends[v].count != 2) continue;
		const TriangleEdge &one = parts[ends[v].edge[0]], &other = parts[ends[v].edge[1]];
		const auto polygonsOf = [this](const TriangleEdge& part)
		{ return m_faces[part.face[0]].polygon + m_faces[part.face[1]].polygon; };
		ends[v].isStraight = polygonsOf(one) == polygonsOf(other) && otherEnd(one.vertex, v) != otherEnd(other.vertex, v) &&
							 length(cross(directionOf(one), directionOf(other))) < kStraight;
		if (ends[v].isStraight) m_isCorner[v] = 0;
	}
	std::vector<EdgeOfFace> edgesOfFaces;
	std::vector<char> isUsed(parts.size(), 0);
	m_edges.reserve(parts.size());
	for (std::uint32_t first = 0; first < parts.size(); ++first)
	{
		if (isUsed[first]) continue;
		SurfaceEdge edge = edgeOf(parts[first]);
		// Convex: the second face falls away from the first one's plane, or is its back.
		const bool isBorder = m_kind == Kind::kSheet && edge.face[0] / 2 == edge.face[1] / 2;
		if (!isBorder && dot(edge.normal[0], edge.inward[1]) > -kFlatEdge) continue;
		const std::uint32_t index = std::uint32_t(m_edges.size());
		const auto use = [&](std::uint32_t part)
		{
			isUsed[part] = 1;
			for (const std::uint32_t f : parts[part].face) edgesOfFaces.push_back({f, index});
		};
		use(first);
		for (std::size_t side = 0; side < 2; ++side)
			for (std::uint32_t part = first; ends[edge.vertex[side]].isStraight;)
			{
				const EdgeEnds& at = ends[edge.vertex[side]];
				part = otherEnd(at.edge, part);
				if (isUsed[part]) break;
				use(part);
				edge.vertex[side] = otherEnd(parts[part].vertex, edge.vertex[side]);
			}
		edge.length = length(m_vertices[edge.vertex[1]] - m_vertices[edge.vertex[0]]);
		m_edges.push_back(edge);
	}
	m_edges.shrink_to_fit();
	double lengths = 0;
	for (const SurfaceEdge& edge : m_edges) lengths += edge.length;
	if (!m_edges.empty()) m_grain = lengths / double(m_edges.size());
	std::sort(edgesOfFaces.begin(), edgesOfFaces.end());
	listNodes(firstFaceOfNode, edgesOfFaces);
}

void ContactSurface::findDiscs()
{
	m_polygonDiscs.reserve(polygonCount());
	for (std::uint32_t p = 0; p < polygonCount(); ++p)
	{
		const Span<std::uint32_t> faces = facesOf(p);
		Vec3 center;
		for (const std::uint32_t f : faces)
			for (const std::uint32_t v : m_faces[f].vertex) center += (1.0 / double(3 * faces.size)) * m_vertices[v];
		double squared = 0;
		for (const std::uint32_t f : faces)
			for (const std::uint32_t v : m_faces[f].vertex) squared = std::max(squared, lengthSquared(m_vertices[v] - center));
		m_polygonDiscs.push_back({center, std::sqrt(squared)});
	}
}

void ContactSurface::listNodes(const std::vector<std::uint32_t>& firstFaceOfNode, const std::vector<EdgeOfFace>& edgesOfFaces)
{
	m_firstFaceOf = firstFaceOfNode;
	m_firstFaceOf.push_back(std::uint32_t(m_faces.size()));
	m_polygonCorners.reserve(3 * m_faces.size());
	std::vector<std::uint32_t> vertices, edges;
	std::vector<std::array<std::uint32_t, 2>> polygons;  // polygon, face
	std::vector<std::uint16_t> placeInNode(m_vertices.size());
	std::vector<std::uint32_t> listedFor(m_vertices.size(), 0);  // so many polygons
	auto edgeOfFace = edgesOfFaces.begin();
	const auto sortUnique = [](std::vector<std::uint32_t>& list)
	{
		std::sort(list.begin(), list.end());
		list.erase(std::unique(list.begin(), list.end()), list.end());
	};
	for (std::size_t n = 0; n < firstFaceOfNode.size(); ++n)
	{
		m_firstVertexOf.push_back(std::uint32_t(m_nodeVertices.size()));
		m_firstEdgeOf.push_back(std::uint32_t(m_nodeEdges.size()));
		m_firstPolygonOf.push_back(std::uint32_t(m_nodePolygons.size()));
		vertices.clear();
		edges.clear();
		polygons.clear();
		for (std::uint32_t f = m_firstFaceOf[n]; f < m_firstFaceOf[n + 1]; ++f)
		{
			vertices.insert(vertices.end(), m_faces[f].vertex.begin(), m_faces[f].vertex.end());
			for (; edgeOfFace != edgesOfFaces.end() && edgeOfFace->first == f; ++edgeOfFace) edges.push_back(edgeOfFace->second);
			polygons.push_back({m_faces[f].polygon, f});
		}
		sortUnique(vertices);
		for (std::size_t i = 0; i < vertices.size(); ++i) placeInNode[vertices[i]] = std::uint16_t(i);
		sortUnique(edges);
		if (!std::is_sorted(polygons.begin(), polygons.end())) std::sort(polygons.begin(), polygons.end());
		m_nodeVertices.insert(m_nodeVertices.end(), vertices.begin(), vertices.end());
		m_nodeEdges.insert(m_nodeEdges.end(), edges.begin(), edges.end());
		for (const auto& [polygon, face] : polygons)
		{
			if (m_nodePolygons.size() == m_firstPolygonOf.back() || m_nodePolygons.back().polygon != polygon)
				m_nodePolygons.push_back({polygon, std::uint32_t(m_polygonCorners.size()), 0});
			const std::uint32_t current = std::uint32_t(m_nodePolygons.size());
			for (const std::uint32_t v : m_faces[face].vertex)
			{
				if (std::exchange(listedFor[v], current) == current) continue;
				m_polygonCorners.push_back(placeInNode[v]);
				++m_nodePolygons.back().cornerCount;
			}
		}
	}
	m_firstVertexOf.push_back(std::uint32_t(m_nodeVertices.size()));
	m_firstEdgeOf.push_back(std::uint32_t(m_nodeEdges.size()));
	m_firstPolygonOf.push_back(std::uint32_t(m_nodePolygons.size()));
}

std::uint32_t ContactSurface::lowestFrom(std::uint32_t vertex, const Vec3& up) const
{
	for (std::uint32_t lowest = vertex;; vertex = lowest)
	{
		std::uint32_t f = m_faceOfVertex[vertex];
		do
		{
			const SurfaceFace& face = m_faces[f];
			const std::size_t at = face.vertex[0] == vertex ? 0 : face.vertex[1] == vertex ? 1 : 2;
			const std::uint32_t next = face.vertex[(at + 1) % 3];
			if (dot(up, m_vertices[next]) < dot(up, m_vertices[lowest])) lowest = next;
			f = face.neighbour[(at + 2) % 3];
		} while (f != m_faceOfVertex[vertex]);
		if (lowest == vertex) return lowest;
	}
}
}  // namespace clod
