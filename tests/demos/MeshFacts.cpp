// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/demos/MeshFacts.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace clod::demo::test
{
namespace
{
using Edge = std::pair<uint32_t, uint32_t>;

// The third corners of the triangles at each vertex, as steps of the ring round it.
std::string fanFault(const ModelMesh& mesh)
{
	std::vector<std::map<uint32_t, uint32_t>> rings(mesh.vertices.size());
	for (const auto& t : mesh.triangles)
		for (size_t k = 0; k < 3; ++k) rings[t[k]][t[(k + 1) % 3]] = t[(k + 2) % 3];
	for (size_t v = 0; v < rings.size(); ++v)
	{
		if (rings[v].empty()) return "vertex " + std::to_string(v) + " is unused";
		size_t steps = 0;
		const uint32_t first = rings[v].begin()->first;
		uint32_t at = first;
		do
		{
			const auto step = rings[v].find(at);
			if (step == rings[v].end()) return "vertex " + std::to_string(v) + " has an open fan";
			at = step->second;
			++steps;
		} while (at != first && steps <= rings[v].size());
		if (steps != rings[v].size()) return "vertex " + std::to_string(v) + " has several fans";
	}
	return "";
}

double aspect(const ModelMesh& mesh, size_t triangle, double& height)
{
	const auto& t = mesh.triangles[triangle];
	double longest = 0;
	for (size_t k = 0; k < 3; ++k)
		longest = std::max(longest, length(mesh.vertices[t[(k + 1) % 3]] - mesh.vertices[t[k]]));
	const Vec3 a = mesh.vertices[t[0]];
	const double doubleArea = length(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a));
	height = longest > 0 ? doubleArea / longest : 0;
	return height > 0 ? longest / height : std::numeric_limits<double>::infinity();
}

// Nearest point of a triangle by its regions (Ericson 2004, 5.1.5), written out as projections on plane and edges.
double distanceToTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c)
{
	const Vec3 n = cross(b - a, c - a);
	const Vec3 corners[3] = {a, b, c};
	bool isInside = true;
	double best = std::numeric_limits<double>::infinity();
	for (int k = 0; k < 3; ++k)
	{
		const Vec3 from = corners[k], way = corners[(k + 1) % 3] - from;
		if (dot(cross(way, p - from), n) < 0) isInside = false;
		const double t = std::clamp(dot(p - from, way) / dot(way, way), 0.0, 1.0);
		best = std::min(best, length(p - from - t * way));
	}
	return isInside ? std::min(best, std::fabs(dot(p - a, normalized(n)))) : best;
}
}  // namespace

std::string manifoldFault(const ModelMesh& mesh)
{
	std::map<Edge, int> uses;
	for (size_t i = 0; i < mesh.triangles.size(); ++i)
		for (size_t k = 0; k < 3; ++k)
		{
			const uint32_t a = mesh.triangles[i][k], b = mesh.triangles[i][(k + 1) % 3];
			if (a >= mesh.vertices.size()) return "triangle " + std::to_string(i) + " has an index out of range";
			++uses[{a, b}];
		}
	for (const auto& [edge, count] : uses)
		if (count != 1 || uses.count({edge.second, edge.first}) == 0)
			return "edge " + std::to_string(edge.first) + "-" + std::to_string(edge.second) +
				   " is not shared by two triangles in opposite senses";
	return fanFault(mesh);
}

long eulerCharacteristic(const ModelMesh& mesh)
{
	std::map<Edge, int> edges;
	for (const auto& t : mesh.triangles)
		for (size_t k = 0; k < 3; ++k) edges[std::minmax(t[k], t[(k + 1) % 3])] = 1;
	return long(mesh.vertices.size()) - long(edges.size()) + long(mesh.triangles.size());
}

size_t pieceCount(const ModelMesh& mesh)
{
	std::vector<uint32_t> parent(mesh.vertices.size());
	std::iota(parent.begin(), parent.end(), 0u);
	const auto root = [&](uint32_t v)
	{
		while (parent[v] != v) v = parent[v] = parent[parent[v]];
		return v;
	};
	for (const auto& t : mesh.triangles)
		for (size_t k = 1; k < 3; ++k) parent[root(t[k])] = root(t[0]);
	size_t pieces = 0;
	for (uint32_t v = 0; v < parent.size(); ++v) pieces += root(v) == v;
	return pieces;
}

double volume(const ModelMesh& mesh)
{
	double sum = 0;
	for (const auto& t : mesh.triangles)
		sum += dot(mesh.vertices[t[0]], cross(mesh.vertices[t[1]], mesh.vertices[t[2]])) / 6;
	return sum;
}

double worstAspect(const ModelMesh& mesh)
{
	double worst = 0, height = 0;
	for (size_t i = 0; i < mesh.triangles.size(); ++i) worst = std::max(worst, aspect(mesh, i, height));
	return worst;
}

size_t aspectsOver(const ModelMesh& mesh, double limit)
{
	size_t count = 0;
	double height = 0;
	for (size_t i = 0; i < mesh.triangles.size(); ++i) count += aspect(mesh, i, height) > limit;
	return count;
}

double smallestHeight(const ModelMesh& mesh)
{
	double smallest = std::numeric_limits<double>::infinity(), height = 0;
	for (size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		aspect(mesh, i, height);
		smallest = std::min(smallest, height);
	}
	return smallest;
}

Vec3 lowCorner(const ModelMesh& mesh)
{
	Vec3 low = mesh.vertices[0];
	for (const Vec3& v : mesh.vertices)
		for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], v[k]);
	return low;
}

Vec3 highCorner(const ModelMesh& mesh)
{
	Vec3 high = mesh.vertices[0];
	for (const Vec3& v : mesh.vertices)
		for (int k = 0; k < 3; ++k) high[k] = std::max(high[k], v[k]);
	return high;
}

double distanceToMesh(const Vec3& point, const ModelMesh& mesh)
{
	double best = std::numeric_limits<double>::infinity();
	for (const auto& t : mesh.triangles)
		best = std::min(best, distanceToTriangle(point, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]));
	return best;
}

bool intersectsItself(const ModelMesh& mesh)
{
	using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
	CGAL::Surface_mesh<Kernel::Point_3> surface;
	using Surface = decltype(surface);
	for (const Vec3& v : mesh.vertices) surface.add_vertex({v.x, v.y, v.z});
	for (const auto& t : mesh.triangles)
		surface.add_face(Surface::Vertex_index(t[0]), Surface::Vertex_index(t[1]), Surface::Vertex_index(t[2]));
	return CGAL::Polygon_mesh_processing::does_self_intersect(surface);
}
}  // namespace clod::demo::test
