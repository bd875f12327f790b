// SPDX-License-Identifier: GPL-3.0-or-later
// Self-intersection and nesting, by CGAL's exact predicates.
#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <fmt/format.h>

#include <algorithm>

#include "builder/intake/Intake.h"

namespace clod::builder
{
namespace
{
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;

Point toPoint(const Vec3& v)
{
	return {v.x, v.y, v.z};
}

// The triangles of one component, or of all for kNone. Faces keep their order.
SurfaceMesh toSurfaceMesh(const Mesh& mesh, const std::vector<std::uint32_t>& componentOf, std::uint32_t component)
{
	SurfaceMesh surface;
	std::vector<SurfaceMesh::Vertex_index> vertex(mesh.vertices.size(), SurfaceMesh::null_vertex());
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		if (component != kNone && componentOf[i] != component) continue;
		for (const std::uint32_t v : mesh.triangles[i])
			if (vertex[v] == SurfaceMesh::null_vertex()) vertex[v] = surface.add_vertex(toPoint(mesh.vertices[v]));
		const auto& t = mesh.triangles[i];
		surface.add_face(vertex[t[0]], vertex[t[1]], vertex[t[2]]);
	}
	return surface;
}

void checkAreas(const Mesh& rounded, const WeldedMesh& mesh)
{
	std::vector<Defect> defects;
	for (const bool before : {true, false})
	{
		Defect defect{before ? Reason::degenerate : Reason::rounding, "", 0};
		for (std::size_t i = 0; i < rounded.triangles.size(); ++i)
		{
			const auto& t = rounded.triangles[i];
			const auto collinear = [&t](const std::vector<Vec3>& v)
			{ return CGAL::collinear(toPoint(v[t[0]]), toPoint(v[t[1]]), toPoint(v[t[2]])); };
			if (!collinear(rounded.vertices) || collinear(mesh.vertices) != before || defect.count++ > 0) continue;
			defect.first = fmt::format("face {} (vertices {}, {}, {}) has no area{}, at {}", mesh.polygonInFile[i],
									   mesh.vertexInFile[t[0]], mesh.vertexInFile[t[1]], mesh.vertexInFile[t[2]],
									   before ? "" : " once rounded to float", placeOf(mesh.vertices[t[0]]));
		}
		if (defect.count > 0) defects.push_back(defect);
	}
	if (!defects.empty()) throw Refused(defects);
}

void checkSelfIntersections(const SurfaceMesh& surface, const WeldedMesh& mesh)
{
	std::vector<std::pair<SurfaceMesh::Face_index, SurfaceMesh::Face_index>> pairs;
	CGAL::Polygon_mesh_processing::self_intersections(surface, std::back_inserter(pairs));
	if (pairs.empty()) return;
	for (auto& [a, b] : pairs)
		if (b < a) std::swap(a, b);
	const auto first = *std::min_element(pairs.begin(), pairs.end());
	throw Refused(
		{{Reason::selfIntersection,
		  fmt::format("faces {} and {} cross or overlap, near {}", mesh.polygonInFile[std::size_t(first.first)],
					  mesh.polygonInFile[std::size_t(first.second)],
					  placeOf(mesh.vertices[mesh.triangles[std::size_t(first.first)][0]])),
		  pairs.size()}});
}

// Six times the signed volume of a component.
double signedVolume(const Mesh& mesh, const std::vector<std::uint32_t>& componentOf, std::uint32_t component)
{
	double volume = 0;
	Vec3 origin;
	bool first = true;
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		if (componentOf[i] != component) continue;
		const auto& t = mesh.triangles[i];
		if (first) origin = mesh.vertices[t[0]];
		first = false;
		volume += dot(mesh.vertices[t[0]] - origin, cross(mesh.vertices[t[1]] - origin, mesh.vertices[t[2]] - origin));
	}
	return volume;
}

// A component inside an even number of others is solid, inside an odd number it bounds a cavity. Number of cavities.
std::size_t checkNesting(const Mesh& mesh, const WeldedMesh& welded, const std::vector<std::uint32_t>& componentOf)
{
	const std::uint32_t count = *std::max_element(componentOf.begin(), componentOf.end()) + 1;
	std::vector<std::size_t> firstTriangle(count, mesh.triangles.size()), depth(count, 0);
	for (std::size_t i = mesh.triangles.size(); i-- > 0;) firstTriangle[componentOf[i]] = i;
	for (std::uint32_t outer = 0; outer < count && count > 1; ++outer)
	{
		const SurfaceMesh surface = toSurfaceMesh(mesh, componentOf, outer);
		const CGAL::Side_of_triangle_mesh<SurfaceMesh, Kernel> side(surface);
		for (std::uint32_t inner = 0; inner < count; ++inner)
			if (inner != outer)
				depth[inner] +=
					side(toPoint(mesh.vertices[mesh.triangles[firstTriangle[inner]][0]])) == CGAL::ON_BOUNDED_SIDE ? 1
																												   : 0;
	}
	std::size_t cavities = 0, wrong = 0;
	std::string first;
	for (std::uint32_t component = 0; component < count; ++component)
	{
		const bool cavity = depth[component] % 2 == 1;
		cavities += cavity ? 1 : 0;
		if ((signedVolume(mesh, componentOf, component) < 0) == cavity) continue;
		if (wrong++ == 0)
			first = fmt::format("the component of face {}, at {}, is inside out{}",
								welded.polygonInFile[firstTriangle[component]],
								placeOf(welded.vertices[welded.triangles[firstTriangle[component]][0]]),
								cavity ? ": it bounds a cavity and must face into it" : "");
	}
	if (wrong > 0) throw Refused({{Reason::inverted, first, wrong}});
	return cavities;
}
}  // namespace

std::size_t checkSolid(const Mesh& rounded, const WeldedMesh& mesh, const std::vector<std::uint32_t>& componentOf)
{
	checkAreas(rounded, mesh);
	checkSelfIntersections(toSurfaceMesh(rounded, componentOf, kNone), mesh);
	return checkNesting(rounded, mesh, componentOf);
}
}  // namespace clod::builder
