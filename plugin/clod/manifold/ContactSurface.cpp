// SPDX-License-Identifier: Zlib
// A level's mesh from the records of its nodes.
#include "clod/manifold/ContactSurface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include <xxhash.h>

#include "clod/collide/Triangle.h"

namespace clod
{
namespace
{
constexpr std::uint32_t kLeafFaces = 4;
constexpr std::size_t kWorthTheTree = 32;  // faces of a polygon: searching fewer one by one is as fast

double squaredFromSegment(const Vec3& point, const Vec3& from, const Vec3& to)
{
	const Vec3 along = to - from;
	const double share = std::max(0.0, std::min(1.0, dot(point - from, along) / lengthSquared(along)));
	return lengthSquared(point - from - share * along);
}
}  // namespace

ContactSurface::ContactSurface(const Hierarchy& hierarchy, std::uint32_t levelIndex)
{
	const Level& level = hierarchy.levels()[levelIndex];
	m_firstNode = level.firstNode;
	if (hierarchy.isThinCore())
	{
		makeCore(hierarchy.hull(hierarchy.node(level.firstNode)));
		return;
	}
	weld(hierarchy, level);
	std::vector<std::uint32_t> firstFaceOfNode;
	for (std::uint32_t n = level.firstNode; n < level.firstNode + level.nodeCount; ++n)
		firstFaceOfNode.push_back(hierarchy.node(n).firstFace - level.firstFace);
	finish(double(hierarchy.asset().radius), firstFaceOfNode);
}

ContactSurface::ContactSurface(const std::vector<Triangle>& triangles, double size) : m_kind(Kind::kSheet)
{
	weld(triangles);
	joinSides();
	std::vector<std::uint32_t> firstFaceOfNode;
	for (std::uint32_t i = 0; i < triangles.size(); ++i) firstFaceOfNode.push_back(2 * i);
	finish(size, firstFaceOfNode);
}

ContactSurface::ContactSurface(const Vec3& normal, double offset, const Vec3& near, double size)
	: m_kind(Kind::kHalfSpace)
{
	constexpr double kWithoutEnd = 1e3;  // of the size
	const Vec3 foot = near - (dot(normal, near) - offset) * normal;
	const Vec3 across = normalized(cross(normal, std::abs(normal.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
	const Vec3 along = cross(normal, across);
	const double half = kWithoutEnd * size;
	m_vertices = {foot - half * across - half * along, foot + 2 * half * across, foot + 2 * half * along};
	m_faces = {SurfaceFace{{0, 1, 2}, {0, 0, 0}, 0, normal, offset}};
	m_pseudonormals.assign(3, normal);
	m_isCorner.assign(3, 0);
	m_faceOfVertex.assign(3, 0);
	m_firstFan.assign(4, 0);
	m_polygonFaces = {0};
	m_firstPolygonFace = {0, 1};
	m_polygonDiscs = {{foot, std::numeric_limits<double>::infinity()}};
	listNodes({0}, {});
}

void ContactSurface::makeCore(const HullView& vertices)
{
	m_kind = Kind::kCore;
	m_firstFan.assign(1, 0);
	for (std::uint32_t v = 0; v < vertices.count; ++v)
	{
		m_vertices.push_back(vertices.vertex(v));
		if (vertices.count > 1) m_fans.push_back(normalized(vertices.vertex(1 - v) - vertices.vertex(v)));
		m_firstFan.push_back(std::uint32_t(m_fans.size()));
		m_nodeVertices.push_back(v);
	}
	m_pseudonormals.assign(m_vertices.size(), Vec3{});
	m_isCorner.assign(m_vertices.size(), 1);
	m_faceOfVertex.assign(m_vertices.size(), kNone);
	if (m_vertices.size() > 1)
	{
		const double along = length(m_vertices[1] - m_vertices[0]);
		m_edges.push_back({{0, 1}, {kNone, kNone}, m_fans[0], along, {}, {}});
		m_nodeEdges.push_back(0);
	}
	m_firstPolygonFace.assign(1, 0);
	m_firstVertexOf = {0, std::uint32_t(m_nodeVertices.size())};
	m_firstEdgeOf = {0, std::uint32_t(m_nodeEdges.size())};
	m_firstPolygonOf = {0, 0};
	m_firstFaceOf = {0, 0};
}

// What follows from faces, vertices and neighbours.
void ContactSurface::finish(double size, const std::vector<std::uint32_t>& firstFaceOfNode)
{
	mergePolygons(size);
	findFans();
	findEdges(firstFaceOfNode);
	findDiscs();
}

// Neighbours share vertices; round a corner the walk over neighbours meets all faces that share it.
void ContactSurface::weld(const Hierarchy& hierarchy, const Level& level)
{
	m_faces.resize(level.faceCount);
	std::vector<std::array<Vec3, 3>> corners(level.faceCount);
	for (std::uint32_t n = level.firstNode; n < level.firstNode + level.nodeCount; ++n)
	{
		const Node& node = hierarchy.node(n);
		const HullView hull = hierarchy.hull(node);
		for (std::uint32_t i = 0; i < node.faceCount; ++i)
		{
			const Face& face = hierarchy.faces(node)[i];
			const std::uint32_t f = node.firstFace + i - level.firstFace;
			for (std::size_t c = 0; c < 3; ++c)
			{
				corners[f][c] = hull.vertex(face.vertex[c]);
				m_faces[f].neighbour[c] = face.neighbour[c] - level.firstFace;
				m_faces[f].vertex[c] = kNone;
			}
			const Vec3 normal = cross(corners[f][1] - corners[f][0], corners[f][2] - corners[f][0]);
			m_faces[f].normal = normalized(normal);
			if (m_faces[f].normal == Vec3{}) m_faces[f].normal = toVec3(face.normal);
		}
	}
	for (std::uint32_t f = 0; f < m_faces.size(); ++f)
		for (std::size_t c = 0; c < 3; ++c)
		{
			if (m_faces[f].vertex[c] != kNone) continue;
			const std::uint32_t vertex = std::uint32_t(m_vertices.size());
			const Vec3 place = corners[f][c];
			m_vertices.push_back(place);
			m_faceOfVertex.push_back(f);
			std::uint32_t at = f;
			do
			{
				std::size_t i = 0;
				while (i < 2 && corners[at][i] != place) ++i;
				m_faces[at].vertex[i] = vertex;
				at = m_faces[at].neighbour[(i + 2) % 3];
			} while (at != f);
		}
}

// Triangles, each followed by its back.
void ContactSurface::weld(const std::vector<Triangle>& triangles)
{
	std::vector<std::pair<Vec3, std::uint32_t>> corners;
	for (std::uint32_t t = 0; t < triangles.size(); ++t)
		for (std::uint32_t c = 0; c < 3; ++c) corners.push_back({triangles[t][c], 3 * t + c});
	std::sort(corners.begin(), corners.end(),
			  [](const auto& l, const auto& r)
			  {
				  return std::tie(l.first.x, l.first.y, l.first.z, l.second) < std::tie(r.first.x, r.first.y, r.first.z, r.second);
			  });
	m_faces.resize(2 * triangles.size());
	for (std::size_t i = 0; i < corners.size(); ++i)
	{
		const std::uint32_t front = 2 * (corners[i].second / 3), c = corners[i].second % 3;
		if (i == 0 || corners[i].first != corners[i - 1].first)
		{
			m_vertices.push_back(corners[i].first);
			m_faceOfVertex.push_back(front);
		}
		m_faces[front].vertex[c] = std::uint32_t(m_vertices.size() - 1);
	}
	for (std::size_t t = 0; t < triangles.size(); ++t)
	{
		SurfaceFace &front = m_faces[2 * t], &back = m_faces[2 * t + 1];
		const Vec3 &a = triangles[t][0], &b = triangles[t][1], &c = triangles[t][2];
		front.normal = normalized(cross(b - a, c - a));
		back.vertex = {front.vertex[0], front.vertex[2], front.vertex[1]};
		back.normal = -front.normal;
	}
}

// Of two triangles that share an edge each side of one goes on as a side of the other, whichever way they are wound; where
// one or more than two meet each side goes on as its own back.
void ContactSurface::joinSides()
{
	struct Side
	{
		std::pair<std::uint32_t, std::uint32_t> ends;  // the lower first
		std::uint32_t face, edge;
		bool operator<(const Side& other) const
		{ return std::tie(ends, face, edge) < std::tie(other.ends, other.face, other.edge); }
	};
	std::vector<Side> sides;
	for (std::uint32_t f = 0; f < m_faces.size(); f += 2)
		for (std::uint32_t e = 0; e < 3; ++e)
			sides.push_back({std::minmax({m_faces[f].vertex[e], m_faces[f].vertex[(e + 1) % 3]}), f, e});
	std::sort(sides.begin(), sides.end());
	// A back's corners are the front's 0, 2, 1.
	const auto backEdge = [](std::uint32_t e) { return 2 - e; };
	const auto join = [&](std::uint32_t f, std::uint32_t e, std::uint32_t g, std::uint32_t h)
	{
		m_faces[f].neighbour[e] = g;
		m_faces[g].neighbour[h] = f;
	};
	for (std::size_t first = 0, next = 0; first < sides.size(); first = next)
	{
		for (next = first; next < sides.size() && sides[next].ends == sides[first].ends;) ++next;
		const Side &one = sides[first], &other = sides[next - 1];
		if (next - first == 2)
		{
			const bool isWoundAlike =
				m_faces[one.face].vertex[one.edge] == m_faces[other.face].vertex[(other.edge + 1) % 3];
			const std::uint32_t front = isWoundAlike ? other.face : other.face + 1;
			const std::uint32_t edge = isWoundAlike ? other.edge : backEdge(other.edge);
			const std::uint32_t back = isWoundAlike ? other.face + 1 : other.face;
			join(one.face, one.edge, front, edge);
			join(one.face + 1, backEdge(one.edge), back, isWoundAlike ? backEdge(other.edge) : other.edge);
			continue;
		}
		for (std::size_t i = first; i < next; ++i)
			join(sides[i].face, sides[i].edge, sides[i].face + 1, backEdge(sides[i].edge));
	}
}

void ContactSurface::makeTree() const
{
	const auto build = [this]
	{
		m_order.resize(m_faces.size());
		std::iota(m_order.begin(), m_order.end(), 0U);
		std::vector<Vec3> sums;  // of each face's corners
		sums.reserve(m_faces.size());
		for (std::uint32_t f = 0; f < m_faces.size(); ++f)
		{
			const Triangle t = triangleOf(f);
			sums.push_back(t[0] + t[1] + t[2]);
		}
		m_boxes.resize(1);
		split(0, 0, std::uint32_t(m_faces.size()), sums);
	};
	std::call_once(m_treeMade, build);
}

void ContactSurface::split(std::uint32_t box, std::uint32_t first, std::uint32_t count,
						   const std::vector<Vec3>& sums) const
{
	const Vec3& start = m_vertices[m_faces[m_order[first]].vertex[0]];
	Box bounds{start, start};
	for (std::uint32_t i = first; i < first + count; ++i)
		for (const std::uint32_t v : m_faces[m_order[i]].vertex) bounds.add(m_vertices[v]);
	m_boxes[box] = {bounds, first, count};
	if (count <= kLeafFaces) return;
	const int axis = widestAxis(bounds.high - bounds.low);
	const auto isBefore = [&](std::uint32_t i, std::uint32_t j)
	{
		const double at = sums[i][axis], other = sums[j][axis];
		return at < other || (at == other && i < j);
	};
	const std::uint32_t half = count / 2;
	std::nth_element(m_order.begin() + first, m_order.begin() + first + half, m_order.begin() + first + count,
					 isBefore);
	const std::uint32_t children = std::uint32_t(m_boxes.size());
	m_boxes.resize(children + 2);
	m_boxes[box].first = children;
	m_boxes[box].count = 0;
	split(children, first, half, sums);
	split(children + 1, first + half, count - half, sums);
}

// feature as in NearestOnTriangle.
Vec3 ContactSurface::pseudonormalAt(std::uint32_t face, int feature) const
{
	const SurfaceFace& f = m_faces[face];
	if (feature < 3) return m_pseudonormals[f.vertex[std::size_t(feature)]];
	if (feature == 6) return f.normal;
	return normalized(f.normal + m_faces[f.neighbour[std::size_t(feature - 3)]].normal);
}

std::uint32_t ContactSurface::nearestFaceOf(std::uint32_t polygon, const Vec3& point) const
{
	const Span<std::uint32_t> faces = facesOf(polygon);
	constexpr double kFar = std::numeric_limits<double>::infinity();
	if (faces.size > kWorthTheTree) return searchTree(point, kFar, polygon).face;
	Found found{kFar};
	for (const std::uint32_t face : faces) found.add(face, nearestOnTriangle(triangleOf(face), point));
	return found.face;
}

double ContactSurface::squaredBeside(std::uint32_t polygon, const Vec3& point, double enough) const
{
	constexpr double kFar = std::numeric_limits<double>::infinity();
	const Span<std::uint32_t> faces = facesOf(polygon);
	const Vec3 foot = footOn(polygon, point);
	if (faces.size > kWorthTheTree)
	{
		const Found found = searchTree(foot, enough > 0 ? std::sqrt(enough) : kFar, polygon, enough);
		return found.face == kNone ? kFar : found.squared;
	}
	double best = kFar;
	for (std::size_t i = 0; i < faces.size && best > enough; ++i)
	{
		const std::array<std::uint32_t, 3>& v = m_faces[faces[i]].vertex;
		best = std::min(best, nearestOnTriangle(m_vertices[v[0]], m_vertices[v[1]], m_vertices[v[2]], foot).squared);
	}
	return best;
}

std::uint64_t ContactSurface::nameOfVertex(std::uint32_t vertex) const
{
	return isSheet() ? XXH3_64bits(&m_vertices[vertex], sizeof(Vec3)) : vertex;
}

std::uint64_t ContactSurface::nameOfEdge(std::uint32_t edge) const
{
	if (!isSheet()) return edge;
	const SurfaceEdge& e = m_edges[edge];
	const std::uint64_t names[] = {nameOfVertex(e.vertex[0]), nameOfVertex(e.vertex[1]), e.face[0] % 2};
	return XXH3_64bits(names, sizeof names);
}

// Of its first triangle, and by side.
std::uint64_t ContactSurface::nameOfPolygon(std::uint32_t polygon) const
{
	if (!isSheet()) return polygon;
	const std::uint32_t first = facesOf(polygon)[0];
	const std::array<std::uint32_t, 3>& v = m_faces[first].vertex;
	const std::uint64_t names[] = {nameOfVertex(v[0]), nameOfVertex(v[1]), nameOfVertex(v[2]), first % 2};
	return XXH3_64bits(names, sizeof names);
}

std::uint32_t ContactSurface::polygonIn(const Vec3& normal, const Vec3& point, double size) const
{
	constexpr double kSame = 1e-4;
	for (std::uint32_t polygon = 0; polygon < polygonCount(); ++polygon)
	{
		const SurfaceFace& face = planeOf(polygon);
		if (dot(face.normal, normal) > 1 - kSame && std::abs(dot(face.normal, point) - face.offset) < kSame * size)
			return polygon;
	}
	return kNone;
}

bool ContactSurface::isAround(std::uint32_t polygon, const Vec3& point, double radius) const
{
	if (isHalfSpace()) return true;
	if (!isOver(polygon, point, 1e-6 * radius)) return false;
	const Vec3 foot = footOn(polygon, point);
	const auto isClearOf = [&](std::uint32_t f)
	{
		const SurfaceFace& face = m_faces[f];
		for (std::size_t i = 0; i < 3; ++i)
		{
			const bool isSide = m_faces[face.neighbour[i]].polygon != polygon;
			const Vec3 &from = m_vertices[face.vertex[i]], &to = m_vertices[face.vertex[(i + 1) % 3]];
			if (isSide && squaredFromSegment(foot, from, to) < radius * radius) return false;
		}
		return true;
	};
	const Span<std::uint32_t> faces = facesOf(polygon);
	return std::all_of(faces.begin(), faces.end(), isClearOf);
}

// Of faces as near the first.
void ContactSurface::Found::add(std::uint32_t other, const NearestOnTriangle& there)
{
	if (there.squared > squared || (there.squared == squared && other >= face)) return;
	squared = there.squared;
	face = other;
	point = there.point;
	feature = there.feature;
}

// The nearest face, of a polygon or (kNone) of all; or the first found that is near enough.
ContactSurface::Found ContactSurface::searchTree(const Vec3& point, double within, std::uint32_t polygon,
											 double enough) const
{
	makeTree();
	const auto squaredTo = [&](std::uint32_t box) { return m_boxes[box].squaredTo({point, point}); };
	std::array<std::uint32_t, 64> stack;
	std::size_t size = 0;
	stack[size++] = 0;
	Found found{within * within};
	while (size > 0 && (found.face == kNone || found.squared > enough))
	{
		const std::uint32_t at = stack[--size];
		if (squaredTo(at) > found.squared) continue;
		const TreeBox& box = m_boxes[at];
		if (box.count == 0)
		{
			const bool firstIsNearer = squaredTo(box.first) <= squaredTo(box.first + 1);
			stack[size++] = box.first + (firstIsNearer ? 1 : 0);
			stack[size++] = box.first + (firstIsNearer ? 0 : 1);
			continue;
		}
		for (std::uint32_t i = box.first; i < box.first + box.count; ++i)
			if (polygon == kNone || m_faces[m_order[i]].polygon == polygon)
				found.add(m_order[i], nearestOnTriangle(triangleOf(m_order[i]), point));
	}
	return found;
}

ContactSurface::Nearest ContactSurface::nearest(const Vec3& point, double within) const
{
	const Found found = searchTree(point, within, kNone);
	Nearest nearest{std::sqrt(found.squared), found.face, found.point, {}};
	if (found.face == kNone) return nearest;
	nearest.normal = pseudonormalAt(found.face, found.feature);
	if (dot(point - nearest.point, nearest.normal) < 0) nearest.distance = -nearest.distance;
	return nearest;
}

bool ContactSurface::isInside(const Vec3& point) const
{
	if (m_kind == Kind::kSheet || m_kind == Kind::kCore) return false;
	if (m_kind == Kind::kHalfSpace) return dot(m_faces[0].normal, point) < m_faces[0].offset;
	makeTree();
	if (!m_boxes[0].meets({point, point}, 0)) return false;
	return nearest(point, std::numeric_limits<double>::infinity()).distance < 0;
}

const Level& coarsestWithin(const Hierarchy& hierarchy, double error)
{
	std::uint32_t level = 0;
	while (level < hierarchy.coarsestClodLevel() && double(hierarchy.levels()[level + 1].maxSurf) <= error) ++level;
	return hierarchy.levels()[level];
}

std::vector<Vec3> cornersOf(const Hierarchy& hierarchy, std::uint32_t firstNode, std::uint32_t count)
{
	std::vector<Vec3> corners;
	for (std::uint32_t n = firstNode; n < firstNode + count; ++n)
	{
		const HullView hull = hierarchy.hull(hierarchy.node(n));
		for (std::uint32_t i = 0; i < hull.count; ++i) corners.push_back(hull.vertex(i));
	}
	return corners;
}

ContactSurfaces::ContactSurfaces(const Hierarchy& hierarchy)
	: m_hierarchy(hierarchy), m_made(new std::atomic<const ContactSurface*>[hierarchy.levels().size]())
{
}

ContactSurfaces::~ContactSurfaces()
{
	for (std::size_t i = 0; i < m_hierarchy.levels().size; ++i) delete m_made[i].load(std::memory_order_relaxed);
}

const ContactSurface& ContactSurfaces::make(std::uint32_t level) const
{
	const std::lock_guard<std::mutex> lock(m_making);
	if (!m_made[level].load(std::memory_order_relaxed))
		m_made[level].store(new ContactSurface(m_hierarchy, level), std::memory_order_release);
	return *m_made[level].load(std::memory_order_relaxed);
}
}  // namespace clod
