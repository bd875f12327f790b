// SPDX-License-Identifier: Zlib
// A level's mesh from the records of its nodes.
#include "clod/manifold/ContactSurface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "clod/collide/Triangle.h"

namespace clod
{
namespace
{
// Coordinates are stored in float: planes whose vertices agree so well (share of the radius) are one.
constexpr double kCoplanar = 2e-6;
constexpr double kCoplanarCosine = 0.9999;  // and their normals
constexpr double kFlatEdge = 1e-4;          // sine; edges folded less are no features
constexpr std::uint32_t kLeafFaces = 4;

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
}  // namespace

ContactSurface::ContactSurface(const Hierarchy& hierarchy, std::uint32_t levelIndex)
{
	const Level& level = hierarchy.levels()[levelIndex];
	m_firstNode = level.firstNode;
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
	listNodes({0});
}

// What follows from faces, vertices and neighbours.
void ContactSurface::finish(double size, const std::vector<std::uint32_t>& firstFaceOfNode)
{
	mergePolygons(size);
	findFans();
	findEdges();
	listNodes(firstFaceOfNode);
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
				  if (l.first.x != r.first.x) return l.first.x < r.first.x;
				  if (l.first.y != r.first.y) return l.first.y < r.first.y;
				  return l.first.z != r.first.z ? l.first.z < r.first.z : l.second < r.second;
			  });
	m_faces.resize(2 * triangles.size());
	for (std::size_t i = 0; i < corners.size(); ++i)
	{
		const std::uint32_t t = corners[i].second / 3, c = corners[i].second % 3;
		if (i == 0 || corners[i].first != corners[i - 1].first)
		{
			m_vertices.push_back(corners[i].first);
			m_faceOfVertex.push_back(2 * t);
		}
		m_faces[2 * t].vertex[c] = std::uint32_t(m_vertices.size() - 1);
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
		std::uint32_t low, high, face, edge;
	};
	std::vector<Side> sides;
	for (std::uint32_t f = 0; f < m_faces.size(); f += 2)
		for (std::uint32_t e = 0; e < 3; ++e)
		{
			const std::uint32_t v = m_faces[f].vertex[e], w = m_faces[f].vertex[(e + 1) % 3];
			sides.push_back({std::min(v, w), std::max(v, w), f, e});
		}
	std::sort(sides.begin(), sides.end(),
			  [](const Side& l, const Side& r)
			  {
				  if (l.low != r.low) return l.low < r.low;
				  if (l.high != r.high) return l.high < r.high;
				  return l.face != r.face ? l.face < r.face : l.edge < r.edge;
			  });
	// A back's corners are the front's 0, 2, 1.
	const auto backEdge = [](std::uint32_t e) { return 2 - e; };
	const auto join = [&](std::uint32_t f, std::uint32_t e, std::uint32_t g, std::uint32_t h)
	{
		m_faces[f].neighbour[e] = g;
		m_faces[g].neighbour[h] = f;
	};
	for (std::size_t first = 0, next; first < sides.size(); first = next)
	{
		for (next = first; next < sides.size() && sides[next].low == sides[first].low &&
						   sides[next].high == sides[first].high;)
			++next;
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

// Faces are added to the plane of the polygon's largest face.
void ContactSurface::mergePolygons(double radius)
{
	std::vector<std::uint32_t> bySize(m_faces.size());
	std::vector<double> area(m_faces.size());
	for (std::uint32_t f = 0; f < m_faces.size(); ++f)
	{
		bySize[f] = f;
		const std::array<std::uint32_t, 3>& v = m_faces[f].vertex;
		area[f] = length(cross(m_vertices[v[1]] - m_vertices[v[0]], m_vertices[v[2]] - m_vertices[v[0]]));
		m_faces[f].polygon = kNone;
	}
	std::sort(bySize.begin(), bySize.end(),
			  [&](std::uint32_t i, std::uint32_t j) { return area[i] != area[j] ? area[i] > area[j] : i < j; });
	std::vector<std::uint32_t> open;
	for (const std::uint32_t seed : bySize)
	{
		if (m_faces[seed].polygon != kNone) continue;
		const Vec3 normal = m_faces[seed].normal;
		const double offset = dot(normal, m_vertices[m_faces[seed].vertex[0]]);
		open.assign(1, seed);
		m_faces[seed].polygon = seed;
		while (!open.empty())
		{
			SurfaceFace& face = m_faces[open.back()];
			open.pop_back();
			face.normal = normal;
			face.offset = offset;
			for (const std::uint32_t next : face.neighbour)
			{
				SurfaceFace& other = m_faces[next];
				if (other.polygon != kNone || dot(other.normal, normal) < kCoplanarCosine) continue;
				const bool isFlat = std::all_of(other.vertex.begin(), other.vertex.end(),
												[&](std::uint32_t v)
												{
													return std::abs(dot(normal, m_vertices[v]) - offset) <
														   kCoplanar * radius;
												});
				if (!isFlat) continue;
				other.polygon = seed;
				open.push_back(next);
			}
		}
	}
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
			const SurfaceFace& first = m_faces[polygon[v]];
			const bool isBack = m_kind == Kind::kSheet && dot(face.normal, first.normal) < -kCoplanarCosine &&
								!isBorderCorner(face, i);
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

void ContactSurface::findEdges()
{
	for (std::uint32_t f = 0; f < m_faces.size(); ++f)
		for (std::size_t i = 0; i < 3; ++i)
		{
			const SurfaceFace& face = m_faces[f];
			const std::uint32_t g = face.neighbour[i];
			if (g < f || face.polygon == m_faces[g].polygon) continue;
			SurfaceEdge edge;
			edge.vertex = {face.vertex[i], face.vertex[(i + 1) % 3]};
			edge.face = {f, g};
			const Vec3 along = m_vertices[edge.vertex[1]] - m_vertices[edge.vertex[0]];
			edge.length = length(along);
			edge.direction = normalized(along);
			edge.normal = {face.normal, m_faces[g].normal};
			edge.inward = {normalized(cross(edge.normal[0], edge.direction)),
						   normalized(cross(edge.direction, edge.normal[1]))};
			// Convex: the second face falls away from the first one's plane, or is its back.
			const bool isBorder = m_kind == Kind::kSheet && g / 2 == f / 2;
			if (!isBorder && dot(edge.normal[0], edge.inward[1]) > -kFlatEdge) continue;
			m_edges.push_back(edge);
		}
}

void ContactSurface::listNodes(const std::vector<std::uint32_t>& firstFaceOfNode)
{
	std::vector<std::array<std::uint32_t, 3>> edgeOf(m_faces.size(), {kNone, kNone, kNone});
	for (std::uint32_t e = 0; e < m_edges.size(); ++e)
		for (const std::uint32_t f : m_edges[e].face)
			for (std::size_t i = 0; i < 3; ++i)
			{
				const std::uint32_t v = m_faces[f].vertex[i], w = m_faces[f].vertex[(i + 1) % 3];
				if ((v == m_edges[e].vertex[0] && w == m_edges[e].vertex[1]) ||
					(v == m_edges[e].vertex[1] && w == m_edges[e].vertex[0]))
					edgeOf[f][i] = e;
			}
	m_firstFaceOf = firstFaceOfNode;
	m_firstFaceOf.push_back(std::uint32_t(m_faces.size()));
	std::vector<std::uint32_t> found;
	for (std::size_t n = 0; n < firstFaceOfNode.size(); ++n)
	{
		const std::uint32_t first = m_firstFaceOf[n], last = m_firstFaceOf[n + 1];
		m_firstVertexOf.push_back(std::uint32_t(m_nodeVertices.size()));
		m_firstEdgeOf.push_back(std::uint32_t(m_nodeEdges.size()));
		found.clear();
		for (std::uint32_t f = first; f < last; ++f)
			found.insert(found.end(), m_faces[f].vertex.begin(), m_faces[f].vertex.end());
		std::sort(found.begin(), found.end());
		found.erase(std::unique(found.begin(), found.end()), found.end());
		m_nodeVertices.insert(m_nodeVertices.end(), found.begin(), found.end());
		const auto localOf = [&found](std::uint32_t vertex)
		{ return std::uint16_t(std::lower_bound(found.begin(), found.end(), vertex) - found.begin()); };
		for (std::uint32_t f = first; f < last; ++f)
		{
			const std::array<std::uint32_t, 3>& v = m_faces[f].vertex;
			m_faceCorners.push_back({localOf(v[0]), localOf(v[1]), localOf(v[2])});
			for (const std::uint32_t e : edgeOf[f])
			{
				// Of two faces of the node the first one has the edge.
				if (e == kNone || (m_edges[e].face[0] != f && m_edges[e].face[0] >= first && m_edges[e].face[0] < last))
					continue;
				m_nodeEdges.push_back({e, localOf(m_edges[e].vertex[0]), localOf(m_edges[e].vertex[1])});
			}
		}
	}
	m_firstVertexOf.push_back(std::uint32_t(m_nodeVertices.size()));
	m_firstEdgeOf.push_back(std::uint32_t(m_nodeEdges.size()));
}

void ContactSurface::buildTree() const
{
	m_order.resize(m_faces.size());
	for (std::uint32_t f = 0; f < m_faces.size(); ++f) m_order[f] = f;
	m_boxes.resize(1);
	split(0, 0, std::uint32_t(m_faces.size()));
}

void ContactSurface::split(std::uint32_t box, std::uint32_t first, std::uint32_t count) const
{
	constexpr double kFar = std::numeric_limits<double>::infinity();
	Vec3 low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
	for (std::uint32_t i = first; i < first + count; ++i)
		for (const std::uint32_t v : m_faces[m_order[i]].vertex)
			for (int k = 0; k < 3; ++k)
			{
				low[k] = std::min(low[k], m_vertices[v][k]);
				high[k] = std::max(high[k], m_vertices[v][k]);
			}
	m_boxes[box] = {low, high, first, count};
	if (count <= kLeafFaces) return;
	const Vec3 size = high - low;
	const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
	const auto key = [&](std::uint32_t f)
	{
		const std::array<std::uint32_t, 3>& v = m_faces[f].vertex;
		return m_vertices[v[0]][axis] + m_vertices[v[1]][axis] + m_vertices[v[2]][axis];
	};
	const std::uint32_t half = count / 2;
	std::nth_element(m_order.begin() + first, m_order.begin() + first + half, m_order.begin() + first + count,
					 [&](std::uint32_t i, std::uint32_t j)
					 {
						 const double a = key(i), b = key(j);
						 return a != b ? a < b : i < j;
					 });
	const std::uint32_t children = std::uint32_t(m_boxes.size());
	m_boxes.resize(children + 2);
	m_boxes[box].first = children;
	m_boxes[box].count = 0;
	split(children, first, half);
	split(children + 1, first + half, count - half);
}

// feature as in NearestOnTriangle.
Vec3 ContactSurface::pseudonormalAt(std::uint32_t face, int feature) const
{
	const SurfaceFace& f = m_faces[face];
	if (feature < 3) return m_pseudonormals[f.vertex[std::size_t(feature)]];
	if (feature == 6) return f.normal;
	return normalized(f.normal + m_faces[f.neighbour[std::size_t(feature - 3)]].normal);
}

double ContactSurface::squaredBeside(std::uint32_t faceIndex, const Vec3& point) const
{
	const SurfaceFace& face = m_faces[faceIndex];
	const Vec3 foot = point - (dot(face.normal, point) - face.offset) * face.normal;
	return nearestOnTriangle(
			   Triangle{m_vertices[face.vertex[0]], m_vertices[face.vertex[1]], m_vertices[face.vertex[2]]}, foot)
		.squared;
}

ContactSurface::Nearest ContactSurface::nearest(const Vec3& point, double within) const
{
	std::call_once(m_treeMade, [this] { buildTree(); });
	const auto squaredTo = [&](std::uint32_t box)
	{
		double sum = 0;
		for (int k = 0; k < 3; ++k)
		{
			const double out = std::max(m_boxes[box].low[k] - point[k], point[k] - m_boxes[box].high[k]);
			if (out > 0) sum += out * out;
		}
		return sum;
	};
	std::array<std::uint32_t, 64> stack;
	std::size_t size = 0;
	stack[size++] = 0;
	double best = within * within;
	Nearest found;
	int feature = 6;
	while (size > 0)
	{
		const std::uint32_t at = stack[--size];
		if (squaredTo(at) >= best) continue;
		const TreeBox& box = m_boxes[at];
		if (box.count == 0)
		{
			const bool firstIsNearer = squaredTo(box.first) <= squaredTo(box.first + 1);
			stack[size++] = box.first + (firstIsNearer ? 1 : 0);
			stack[size++] = box.first + (firstIsNearer ? 0 : 1);
			continue;
		}
		for (std::uint32_t i = box.first; i < box.first + box.count; ++i)
		{
			const SurfaceFace& face = m_faces[m_order[i]];
			const NearestOnTriangle here = nearestOnTriangle(
				Triangle{m_vertices[face.vertex[0]], m_vertices[face.vertex[1]], m_vertices[face.vertex[2]]}, point);
			if (here.squared >= best) continue;
			best = here.squared;
			found.face = m_order[i];
			found.point = here.point;
			feature = here.feature;
		}
	}
	found.distance = std::sqrt(best);
	if (found.face == kNone) return found;
	found.normal = pseudonormalAt(found.face, feature);
	if (dot(point - found.point, found.normal) < 0) found.distance = -found.distance;
	return found;
}

bool ContactSurface::isInside(const Vec3& point) const
{
	if (m_kind == Kind::kSheet) return false;
	if (m_kind == Kind::kHalfSpace) return dot(m_faces[0].normal, point) < m_faces[0].offset;
	std::call_once(m_treeMade, [this] { buildTree(); });
	for (int k = 0; k < 3; ++k)
		if (point[k] < m_boxes[0].low[k] || point[k] > m_boxes[0].high[k]) return false;
	return nearest(point, std::numeric_limits<double>::infinity()).distance < 0;
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
