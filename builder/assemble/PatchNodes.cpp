// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/assemble/PatchNodes.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>

#include "builder/assemble/TriangleTree.h"

namespace clod::builder
{
namespace
{
void addFaces(const Lod& lod, std::vector<NodeDraft>& nodes)
{
	std::vector<std::map<std::uint32_t, std::uint32_t>> local(lod.patchCount);
	for (std::uint32_t i = 0; i < lod.mesh.triangles.size(); ++i)
	{
		const std::uint32_t patch = lod.patchOfTriangle[i];
		NodeDraft& node = nodes[patch];
		std::array<std::uint32_t, 3> face{};
		for (std::size_t k = 0; k < 3; ++k)
		{
			const std::uint32_t v = lod.mesh.triangles[i][k];
			const auto inserted = local[patch].insert({v, std::uint32_t(node.vertices.size())});
			if (inserted.second) node.vertices.push_back(lod.mesh.vertices[v]);
			face[k] = inserted.first->second;
		}
		node.faces.push_back(face);
		node.triangles.push_back(i);
	}
}

void addNormals(NodeDraft& node)
{
	Vec3 sum;
	for (std::size_t i = 0; i < node.faces.size(); ++i) sum += areaVector(node.face(i));
	node.meanNormal = normalized(sum);
	if (node.meanNormal == Vec3{}) node.meanNormal = {0, 0, 1};
	node.inward = toVec3(toFloat3(-node.meanNormal));  // as stored
	node.coneCosine = 1;
	for (std::size_t i = 0; i < node.faces.size(); ++i)
		node.coneCosine = std::min(node.coneCosine, dot(normalized(areaVector(node.face(i))), node.meanNormal));
}

// Whether the other triangle of the mesh lies above this one's plane, exactly.
bool risesAbove(const Mesh& mesh, std::uint32_t triangle, std::uint32_t other)
{
	using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
	const auto point = [&](std::uint32_t v)
	{
		const Vec3& p = mesh.vertices[v];
		return Point(p.x, p.y, p.z);
	};
	const auto& t = mesh.triangles[triangle];
	const auto isAbove = [&](std::uint32_t v)
	{ return CGAL::orientation(point(t[0]), point(t[1]), point(t[2]), point(v)) == CGAL::POSITIVE; };
	return std::any_of(mesh.triangles[other].begin(), mesh.triangles[other].end(), isAbove);
}

// kappa: half the edge length times the signed dihedral angle, summed over the patch's inner edges, per area.
void addCurvature(const Lod& lod, std::vector<NodeDraft>& nodes)
{
	const auto neighbours = triangleNeighbours(lod.mesh);
	const auto triangle = [&lod](std::uint32_t i) -> Triangle
	{
		const auto& t = lod.mesh.triangles[i];
		return {lod.mesh.vertices[t[0]], lod.mesh.vertices[t[1]], lod.mesh.vertices[t[2]]};
	};
	std::vector<double> area(nodes.size(), 0);
	for (std::uint32_t i = 0; i < lod.mesh.triangles.size(); ++i)
	{
		const std::uint32_t patch = lod.patchOfTriangle[i];
		const Triangle t = triangle(i);
		const Vec3 n = normalized(areaVector(t));
		area[patch] += length(areaVector(t));
		for (std::size_t e = 0; e < 3; ++e)
		{
			const std::uint32_t other = neighbours[i][e];
			if (other == kNone || other < i || lod.patchOfTriangle[other] != patch) continue;
			const Vec3 edge = t[int(e + 1) % 3] - t[int(e)], m = normalized(areaVector(triangle(other)));
			double angle = std::atan2(dot(cross(n, m), normalized(edge)), dot(n, m));
			// Of one folded over to the same plane the sign is noise: it is a sheet's rim.
			if (dot(n, m) < 0) angle = risesAbove(lod.mesh, i, other) ? -std::abs(angle) : std::abs(angle);
			nodes[patch].curvature += 0.5 * length(edge) * angle;
		}
	}
	for (std::size_t p = 0; p < nodes.size(); ++p) nodes[p].curvature = area[p] > 0 ? nodes[p].curvature / area[p] : 0;
}
}  // namespace

std::vector<NodeDraft> patchNodes(const Lod& lod, std::size_t level)
{
	constexpr std::size_t kMostVertices = 65535;  // Face::vertex has 16 bits
	std::vector<NodeDraft> nodes(lod.patchCount);
	addFaces(lod, nodes);
	for (std::size_t p = 0; p < nodes.size(); ++p)
	{
		if (nodes[p].vertices.size() > kMostVertices || nodes[p].vertices.empty())
			throw std::runtime_error("patch " + std::to_string(p) + " of level " + std::to_string(level) + " has " +
									 std::to_string(nodes[p].vertices.size()) + " vertices; a node holds 1 to 65535");
		addNormals(nodes[p]);
		nodes[p].resolution = p < lod.patchResolution.size() ? lod.patchResolution[p] : 0;
	}
	addCurvature(lod, nodes);
	return nodes;
}
}  // namespace clod::builder
