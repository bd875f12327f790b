// SPDX-License-Identifier: GPL-3.0-or-later
// Median split on the longest axis of the centroids; ties by index, so the tree depends on the mesh alone.
#include "builder/assemble/TriangleTree.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace clod::builder
{
TriangleTree::TriangleTree(const Mesh& mesh)
{
	for (const auto& t : mesh.triangles)
		m_triangles.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
	m_order.resize(m_triangles.size());
	std::iota(m_order.begin(), m_order.end(), 0u);
	m_nodes.reserve(m_triangles.size());
	m_nodes.emplace_back();
	build(0, 0, std::uint32_t(m_triangles.size()));
}

void TriangleTree::build(std::uint32_t node, std::uint32_t first, std::uint32_t count)
{
	constexpr std::uint32_t kLeafSize = 4;
	AxisBox box, centers;
	for (std::uint32_t k = first; k < first + count; ++k)
	{
		box.add(boxOf(m_triangles[m_order[k]]));
		centers.add(centroid(m_triangles[m_order[k]]));
	}
	m_nodes[node].box = box;
	if (count <= kLeafSize)
	{
		m_nodes[node].first = first;
		m_nodes[node].count = count;
		return;
	}
	const Vec3 extent = centers.extent();
	const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
	const auto begin = m_order.begin() + first;
	std::nth_element(begin, begin + count / 2, begin + count,
					 [&](std::uint32_t i, std::uint32_t j)
					 {
						 const double x = centroid(m_triangles[i])[axis], y = centroid(m_triangles[j])[axis];
						 return x < y || (x == y && i < j);
					 });
	const std::uint32_t left = std::uint32_t(m_nodes.size());
	m_nodes.resize(left + 2);
	m_nodes[node].first = left;
	m_nodes[node].count = 0;
	build(left, first, count / 2);
	build(left + 1, first + count / 2, count - count / 2);
}

namespace
{
// Ray parameter where the line through origin crosses the plane of t inside t; negative without a crossing.
double crossing(const Vec3& origin, const Vec3& direction, const Triangle& t)
{
	const Vec3 n = areaVector(t);
	const double along = dot(n, direction);
	if (along == 0) return -1;
	const double s = dot(n, t.a - origin) / along;
	const Vec3 p = origin + s * direction;
	for (int i = 0; i < 3; ++i)
		if (dot(n, cross(t[(i + 1) % 3] - t[i], p - t[i])) < 0) return -1;
	return s;
}

bool rayMeets(const Vec3& origin, const Vec3& direction, const AxisBox& b, double limit)
{
	double low = 0, high = limit;
	for (int i = 0; i < 3; ++i)
	{
		if (direction[i] == 0)
		{
			if (origin[i] < b.low[i] || origin[i] > b.high[i]) return false;
			continue;
		}
		const double s = (b.low[i] - origin[i]) / direction[i], t = (b.high[i] - origin[i]) / direction[i];
		low = std::max(low, std::min(s, t));
		high = std::min(high, std::max(s, t));
	}
	return low <= high;
}
}  // namespace

double TriangleTree::exitDistance(const Vec3& origin, const Vec3& direction, double from) const
{
	double best = std::numeric_limits<double>::infinity();
	std::uint32_t stack[64];
	int top = 0;
	stack[top++] = 0;
	while (top > 0)
	{
		const TreeNode& node = m_nodes[stack[--top]];
		if (!rayMeets(origin, direction, node.box, best)) continue;
		if (node.count == 0)
		{
			stack[top++] = node.first + 1;
			stack[top++] = node.first;
			continue;
		}
		for (std::uint32_t k = node.first; k < node.first + node.count; ++k)
		{
			const Triangle& t = m_triangles[m_order[k]];
			if (dot(areaVector(t), direction) <= 0) continue;
			const double s = crossing(origin, direction, t);
			if (s >= from && s < best) best = s;
		}
	}
	return best;
}

std::vector<std::array<std::uint32_t, 3>> triangleNeighbours(const Mesh& mesh)
{
	struct HalfEdge
	{
		std::uint32_t low, high, triangle, edge;
	};
	std::vector<HalfEdge> edges;
	for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
		for (std::uint32_t e = 0; e < 3; ++e)
		{
			const std::uint32_t from = mesh.triangles[i][e], to = mesh.triangles[i][(e + 1) % 3];
			edges.push_back({std::min(from, to), std::max(from, to), i, e});
		}
	std::sort(edges.begin(), edges.end(),
			  [](const HalfEdge& x, const HalfEdge& y)
			  { return std::tie(x.low, x.high, x.triangle) < std::tie(y.low, y.high, y.triangle); });
	std::vector<std::array<std::uint32_t, 3>> neighbours(mesh.triangles.size(), {kNone, kNone, kNone});
	for (std::size_t i = 0; i + 1 < edges.size(); ++i)
	{
		if (edges[i].low != edges[i + 1].low || edges[i].high != edges[i + 1].high) continue;
		neighbours[edges[i].triangle][edges[i].edge] = edges[i + 1].triangle;
		neighbours[edges[i + 1].triangle][edges[i + 1].edge] = edges[i].triangle;
		++i;
	}
	return neighbours;
}

Solid::Solid(const Mesh& mesh) : m_tree(mesh), m_normals(mesh.triangles.size())
{
	std::vector<Vec3> face, vertex(mesh.vertices.size());
	for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
	{
		const Triangle& t = m_tree.triangle(i);
		face.push_back(normalized(areaVector(t)));
		for (int k = 0; k < 3; ++k)
		{
			const Vec3 u = t[(k + 1) % 3] - t[k], v = t[(k + 2) % 3] - t[k];
			const double angle = std::atan2(length(cross(u, v)), dot(u, v));
			vertex[mesh.triangles[i][std::size_t(k)]] += angle * face.back();
		}
	}
	const auto neighbours = triangleNeighbours(mesh);
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		for (std::size_t k = 0; k < 3; ++k)
		{
			m_normals[i][k] = vertex[mesh.triangles[i][k]];
			const std::uint32_t other = neighbours[i][k];
			m_normals[i][3 + k] = face[i] + (other == kNone ? Vec3{} : face[other]);
		}
		m_normals[i][6] = face[i];
	}
}

double Solid::signedDistance(const Vec3& p, std::uint32_t& triangle) const
{
	const TriangleTree::Nearest n = m_tree.nearest(p);
	triangle = n.triangle;
	const double d = std::sqrt(n.distanceSquared);
	const Vec3& normal = m_normals[n.triangle][std::size_t(n.closest.feature)];
	return dot(normal, p - n.closest.point) < 0 ? -d : d;
}
}  // namespace clod::builder
