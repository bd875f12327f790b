// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/oracle/Solid.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace clod::oracle
{
namespace
{
constexpr std::uint32_t kLeafFaces = 3;
constexpr double kSurfaceSlack = 1e-10;  // share of the radius: so far outside a point is still on the surface

// Where on a triangle: 0 to 2 a corner, 3 to 5 the edge that starts at corner i - 3, 6 the inside.
struct OnTriangle
{
	Vec3 point;
	int feature;
};

// Ericson, Real-Time Collision Detection (2005), 5.1.5.
OnTriangle nearestOnTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c)
{
	const Vec3 ab = b - a, ac = c - a, ap = p - a;
	const double d1 = dot(ab, ap), d2 = dot(ac, ap);
	if (d1 <= 0 && d2 <= 0) return {a, 0};
	const Vec3 bp = p - b;
	const double d3 = dot(ab, bp), d4 = dot(ac, bp);
	if (d3 >= 0 && d4 <= d3) return {b, 1};
	const double vc = d1 * d4 - d3 * d2;
	if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + d1 / (d1 - d3) * ab, 3};
	const Vec3 cp = p - c;
	const double d5 = dot(ab, cp), d6 = dot(ac, cp);
	if (d6 >= 0 && d5 <= d6) return {c, 2};
	const double vb = d5 * d2 - d1 * d6;
	if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + d2 / (d2 - d6) * ac, 5};
	const double va = d3 * d6 - d5 * d4;
	if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return {b + (d4 - d3) / (d4 - d3 + d5 - d6) * (c - b), 4};
	const double scale = 1 / (va + vb + vc);
	return {a + vb * scale * ab + vc * scale * ac, 6};
}
}  // namespace

void Box::add(const Vec3& p)
{
	for (int i = 0; i < 3; ++i)
	{
		low[i] = std::min(low[i], p[i]);
		high[i] = std::max(high[i], p[i]);
	}
}

void Box::add(const Box& box)
{
	add(box.low);
	add(box.high);
}

double Box::distanceSquared(const Vec3& p) const
{
	double sum = 0;
	for (int i = 0; i < 3; ++i)
	{
		const double d = std::max({low[i] - p[i], 0.0, p[i] - high[i]});
		sum += d * d;
	}
	return sum;
}

double gap(const Box& a, const Box& b)
{
	double largest = -1e300;
	for (int i = 0; i < 3; ++i) largest = std::max({largest, a.low[i] - b.high[i], b.low[i] - a.high[i]});
	return largest;
}

Box transformed(const Box& box, const Transform& transform)
{
	const Vec3 center = transform * (0.5 * (box.low + box.high)), half = 0.5 * (box.high - box.low);
	Vec3 extent;
	for (int i = 0; i < 3; ++i)
		for (int k = 0; k < 3; ++k) extent[i] += std::fabs(transform.rotation.row[i][k]) * half[k];
	return {center - extent, center + extent};
}

Solid::Solid(const TriangleMesh& mesh) : m_mesh(mesh)
{
	for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f)
	{
		m_normals.push_back(normalized(cross(corner(f, 1) - corner(f, 0), corner(f, 2) - corner(f, 0))));
		m_faceBoxes.emplace_back();
		for (std::size_t i = 0; i < 3; ++i) m_faceBoxes.back().add(corner(f, i));
	}
	findEdges();
	findPseudonormals();
	findMass();
	findSeeds();
	m_order.resize(mesh.triangles.size());
	std::iota(m_order.begin(), m_order.end(), 0u);
	m_nodes.emplace_back();
	split(0, 0, std::uint32_t(m_order.size()));
}

void Solid::findEdges()
{
	std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> found;
	m_ownEdges.resize(m_mesh.triangles.size());
	m_faceEdges.resize(m_mesh.triangles.size());
	for (std::uint32_t f = 0; f < m_mesh.triangles.size(); ++f)
		for (std::size_t i = 0; i < 3; ++i)
		{
			const std::uint32_t from = m_mesh.triangles[f][i], to = m_mesh.triangles[f][(i + 1) % 3];
			const auto twin = found.find({to, from});
			if (twin != found.end())
			{
				m_edges[twin->second].face[1] = f;
				m_faceEdges[f][i] = twin->second;
				found.erase(twin);
				continue;
			}
			if (!found.insert({{from, to}, std::uint32_t(m_edges.size())}).second)
				throw std::runtime_error("a mesh of the oracle is not oriented at face " + std::to_string(f));
			m_faceEdges[f][i] = std::uint32_t(m_edges.size());
			m_ownEdges[f].push_back(std::uint32_t(m_edges.size()));
			m_edges.push_back({{from, to}, {f, f}});
		}
	if (!found.empty())
		throw std::runtime_error("a mesh of the oracle is open at vertex " +
								 std::to_string(found.begin()->first.first));
}

void Solid::findPseudonormals()
{
	m_vertexNormals.resize(m_mesh.vertices.size());
	for (std::uint32_t f = 0; f < m_mesh.triangles.size(); ++f)
		for (std::size_t i = 0; i < 3; ++i)
		{
			const Vec3 to = normalized(corner(f, (i + 1) % 3) - corner(f, i)),
					   back = normalized(corner(f, (i + 2) % 3) - corner(f, i));
			m_vertexNormals[m_mesh.triangles[f][i]] += std::acos(std::clamp(dot(to, back), -1.0, 1.0)) * m_normals[f];
		}
	for (const Edge& edge : m_edges) m_edgeNormals.push_back(m_normals[edge.face[0]] + m_normals[edge.face[1]]);
}

void Solid::findMass()
{
	double second[3][3] = {};
	for (const auto& t : m_mesh.triangles)
	{
		const Vec3 &p = m_mesh.vertices[t[0]], &q = m_mesh.vertices[t[1]], &r = m_mesh.vertices[t[2]];
		const double v = dot(p, cross(q, r)) / 6;
		const Vec3 sum = p + q + r;
		m_volume += v;
		m_center += 0.25 * v * sum;
		for (int i = 0; i < 3; ++i)
			for (int k = 0; k < 3; ++k)
				second[i][k] += v / 20 * (sum[i] * sum[k] + p[i] * p[k] + q[i] * q[k] + r[i] * r[k]);
	}
	m_center = (1 / m_volume) * m_center;
	for (int i = 0; i < 3; ++i)
		for (int k = 0; k < 3; ++k) second[i][k] -= m_volume * m_center[i] * m_center[k];
	const double trace = second[0][0] + second[1][1] + second[2][2];
	for (int i = 0; i < 3; ++i)
		for (int k = 0; k < 3; ++k) m_inertia.row[i][k] = (i == k ? trace : 0) - second[i][k];
	for (const Vec3& v : m_mesh.vertices) m_radius = std::max(m_radius, length(v - m_center));
}

void Solid::findSeeds()
{
	std::vector<std::uint32_t> parent(m_mesh.vertices.size());
	std::iota(parent.begin(), parent.end(), 0u);
	const auto root = [&parent](std::uint32_t v)
	{
		while (parent[v] != v) v = parent[v] = parent[parent[v]];
		return v;
	};
	for (const Edge& edge : m_edges) parent[root(edge.vertex[0])] = root(edge.vertex[1]);
	for (std::uint32_t v = 0; v < parent.size(); ++v)
		if (parent[v] == v) m_seeds.push_back(v);
}

void Solid::split(std::uint32_t node, std::uint32_t first, std::uint32_t count)
{
	Box box, centers;
	const auto middle = [this](std::uint32_t f) { return corner(f, 0) + corner(f, 1) + corner(f, 2); };
	for (std::uint32_t i = first; i < first + count; ++i)
	{
		box.add(faceBox(m_order[i]));
		centers.add(middle(m_order[i]));
	}
	m_nodes[node] = {box, first, count};
	if (count <= kLeafFaces) return;
	const Vec3 extent = centers.high - centers.low;
	const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
	const std::uint32_t half = count / 2;
	std::nth_element(m_order.begin() + first, m_order.begin() + first + half, m_order.begin() + first + count,
					 [&](std::uint32_t l, std::uint32_t r) { return middle(l)[axis] < middle(r)[axis]; });
	const std::uint32_t children = std::uint32_t(m_nodes.size());
	m_nodes.resize(m_nodes.size() + 2);
	m_nodes[node].first = children;
	m_nodes[node].count = 0;
	split(children, first, half);
	split(children + 1, first + half, count - half);
}

Solid::Nearest Solid::nearest(const Vec3& point) const
{
	double best = 1e300;
	std::uint32_t bestFace = 0;
	OnTriangle bestPlace{};
	std::vector<std::uint32_t> stack = {0};
	while (!stack.empty())
	{
		const BoxNode& node = m_nodes[stack.back()];
		stack.pop_back();
		if (node.box.distanceSquared(point) >= best) continue;
		if (node.count == 0)
		{
			const bool firstIsNearer = m_nodes[node.first].box.distanceSquared(point) <
									   m_nodes[node.first + 1].box.distanceSquared(point);
			stack.push_back(node.first + firstIsNearer);
			stack.push_back(node.first + !firstIsNearer);
			continue;
		}
		for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
		{
			const std::uint32_t f = m_order[i];
			const OnTriangle place = nearestOnTriangle(point, corner(f, 0), corner(f, 1), corner(f, 2));
			const double d = lengthSquared(place.point - point);
			if (d >= best) continue;
			best = d;
			bestFace = f;
			bestPlace = place;
		}
	}
	const std::size_t feature = std::size_t(bestPlace.feature);
	const Vec3& normal = feature == 6   ? m_normals[bestFace]
						 : feature >= 3 ? m_edgeNormals[m_faceEdges[bestFace][feature - 3]]
										: m_vertexNormals[m_mesh.triangles[bestFace][feature]];
	return {dot(point - bestPlace.point, normal) < 0 ? -std::sqrt(best) : std::sqrt(best), bestPlace.point};
}

double Solid::exitDistance(const Vec3& from, const Vec3& direction, double most) const
{
	const double slack = kSurfaceSlack * m_radius;
	double best = most;
	std::vector<std::uint32_t> stack = {0};
	while (!stack.empty())
	{
		const BoxNode& node = m_nodes[stack.back()];
		stack.pop_back();
		Box path;
		path.add(from);
		path.add(from + best * direction);
		if (gap(path, node.box) > slack) continue;
		if (node.count == 0)
		{
			stack.push_back(node.first);
			stack.push_back(node.first + 1);
			continue;
		}
		for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
		{
			const std::uint32_t f = m_order[i];
			const double rate = dot(m_normals[f], direction);
			if (rate <= 0) continue;
			const double t = dot(m_normals[f], corner(f, 0) - from) / rate;
			if (t < -slack || t >= best) continue;
			const Vec3 x = from + t * direction;
			bool isInside = true;
			for (std::size_t k = 0; k < 3; ++k)
				isInside &= dot(m_normals[f], cross(corner(f, (k + 1) % 3) - corner(f, k), x - corner(f, k))) >=
							-slack * m_radius;
			if (isInside) best = std::max(0.0, t);
		}
	}
	return best;
}
}  // namespace clod::oracle
