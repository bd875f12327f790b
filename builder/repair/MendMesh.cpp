// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/repair/MendMesh.h"

#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/compute_normal.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "builder/repair/SurfaceMesh.h"

namespace clod::builder
{
namespace
{
namespace pmp = CGAL::Polygon_mesh_processing;
using Face = SurfaceMesh::Face_index;
using Vertex = SurfaceMesh::Vertex_index;
using Halfedge = SurfaceMesh::Halfedge_index;

struct TurnedFaces : pmp::Default_orientation_visitor
{
	explicit TurnedFaces(std::vector<std::size_t>& list) : turned(&list) {}
	void polygon_orientation_reversed(std::size_t polygon) { turned->push_back(polygon); }
	std::vector<std::size_t>* turned;
};

SurfaceMesh orient(const WeldedMesh& mesh, Changes& changes)
{
	std::vector<Point> points;
	for (const Vec3& v : mesh.vertices) points.push_back(toPoint(v));
	std::vector<std::array<std::size_t, 3>> polygons;
	for (const auto& t : mesh.triangles) polygons.push_back({t[0], t[1], t[2]});
	std::vector<std::size_t> turned;
	pmp::orient_polygon_soup(points, polygons, CGAL::parameters::visitor(TurnedFaces(turned)));
	if (!turned.empty())
		changes.push_back(fmt::format("{} turned to agree with their neighbours (the first: face {})",
									  counted(turned.size(), "face", "faces"),
									  mesh.polygonInFile[*std::min_element(turned.begin(), turned.end())]));
	SurfaceMesh surface;
	pmp::polygon_soup_to_polygon_mesh(points, polygons, surface);
	pmp::stitch_borders(surface, CGAL::parameters::apply_per_connected_component(true));
	pmp::remove_isolated_vertices(surface);
	surface.collect_garbage();
	return surface;
}

void fillHoles(SurfaceMesh& surface, Changes& changes)
{
	std::vector<Halfedge> holes;
	pmp::extract_boundary_cycles(surface, std::back_inserter(holes));
	std::size_t filled = 0, faces = 0, longestEdges = 0;
	double longest = 0;
	for (const Halfedge hole : holes)
	{
		std::vector<Face> lid;
		const double around = CGAL::to_double(pmp::face_border_length(hole, surface));
		std::size_t edges = 0;
		for (const Halfedge h : CGAL::halfedges_around_face(hole, surface)) edges += h.is_valid() ? 1 : 0;
		pmp::triangulate_hole(surface, hole, std::back_inserter(lid));
		if (lid.empty()) continue;
		++filled;
		faces += lid.size();
		if (around > longest) std::tie(longest, longestEdges) = std::make_pair(around, edges);
	}
	if (filled > 0)
		changes.push_back(fmt::format("{} closed with {} (the longest: {}, {:.4g} around)",
									  counted(filled, "hole", "holes"), counted(faces, "face", "faces"),
									  counted(longestEdges, "edge", "edges"), longest));
}

// CGAL's own repair of faces that exact arithmetic finds without area.
void dropDegenerate(SurfaceMesh& surface, Changes& changes)
{
	std::size_t count = 0;
	for (const Face f : surface.faces()) count += pmp::is_degenerate_triangle_face(f, surface) ? 1 : 0;
	if (count == 0) return;
	pmp::remove_degenerate_faces(surface);
	surface.collect_garbage();
	changes.push_back(counted(count, "sliver", "slivers") + " without area taken out by flips and collapses");
}

using FaceComponent = SurfaceMesh::Property_map<Face, std::size_t>;

std::size_t numberComponents(SurfaceMesh& surface, FaceComponent& componentOf)
{
	componentOf = surface.add_property_map<Face, std::size_t>("f:component", 0).first;
	return pmp::connected_components(surface, componentOf);
}

struct Component
{
	std::vector<Face> faces;
	Vec3 origin;  // a corner
	double volume = 0, area = 0;
	CGAL::Bbox_3 box;
};

std::vector<Component> measureComponents(const SurfaceMesh& surface, const FaceComponent& componentOf,
										 std::size_t count)
{
	std::vector<Component> components(count);
	for (const Face f : surface.faces())
	{
		Component& c = components[componentOf[f]];
		Vec3 corner[3];
		int k = 0;
		for (const Vertex v : CGAL::vertices_around_face(surface.halfedge(f), surface))
		{
			corner[k++] = toVec3(surface.point(v));
			c.box += surface.point(v).bbox();
		}
		if (c.faces.empty()) c.origin = corner[0];
		c.faces.push_back(f);
		c.volume += dot(corner[0] - c.origin, cross(corner[1] - c.origin, corner[2] - c.origin)) / 6;
		c.area += 0.5 * length(cross(corner[1] - corner[0], corner[2] - corner[0]));
	}
	return components;
}

// Components that enclose nothing go.
void dropFlat(SurfaceMesh& surface, Changes& changes)
{
	FaceComponent componentOf;
	const std::size_t count = numberComponents(surface, componentOf);
	std::vector<std::size_t> flat;
	std::size_t faces = 0;
	const std::vector<Component> components = measureComponents(surface, componentOf, count);
	for (std::size_t i = 0; i < count; ++i)
	{
		const Component& c = components[i];
		const double extent = std::max({c.box.x_span(), c.box.y_span(), c.box.z_span()});
		if (std::abs(c.volume) > 1e-9 * extent * c.area) continue;
		flat.push_back(i);
		faces += c.faces.size();
	}
	if (!flat.empty())
	{
		pmp::remove_connected_components(surface, flat, componentOf);
		surface.collect_garbage();
		changes.push_back(fmt::format("{} ({}) of no volume dropped",
									  counted(flat.size(), "component", "components"), counted(faces, "face", "faces")));
	}
	surface.remove_property_map(componentOf);
}

// Vertices that share a place, as cutting at non-manifold edges and vertices leaves them, are drawn into the solid.
void moveApart(SurfaceMesh& surface, Changes& changes)
{
	std::map<std::tuple<double, double, double>, std::vector<Vertex>> places;
	CGAL::Bbox_3 box;
	for (const Vertex v : surface.vertices())
	{
		const Point& p = surface.point(v);
		places[{p.x(), p.y(), p.z()}].push_back(v);
		box += p.bbox();
	}
	const double most = 1e-4 * std::max({box.x_span(), box.y_span(), box.z_span()});
	std::vector<std::pair<Vertex, Point>> moves;
	for (const auto& [place, vertices] : places)
	{
		if (vertices.size() < 2) continue;
		for (const Vertex v : vertices)
		{
			double shortest = 20 * most;
			for (const Halfedge h : CGAL::halfedges_around_target(v, surface))
				shortest =
					std::min(shortest, length(toVec3(surface.point(surface.source(h))) - toVec3(surface.point(v))));
			const auto normal = pmp::compute_vertex_normal(v, surface);
			moves.emplace_back(v, surface.point(v) - (0.05 * shortest) * normal);
		}
	}
	for (const auto& [v, p] : moves) surface.point(v) = p;
	if (!moves.empty())
		changes.push_back(
			fmt::format("{} where surfaces only touch moved apart, at most {:.3g}",
						counted(moves.size(), "vertex", "vertices"), most));
}

// Outward, or round a cavity inward: by nesting, whatever the file said.
void turnByNesting(SurfaceMesh& surface, Changes& changes)
{
	if (!CGAL::is_closed(surface)) return;
	if (pmp::does_self_intersect(surface))
	{
		// No nesting to speak of; the intake will name the crossings.
		if (CGAL::to_double(pmp::volume(surface)) < 0) pmp::reverse_face_orientations(surface);
		return;
	}
	FaceComponent componentOf;
	const std::size_t count = numberComponents(surface, componentOf);
	const std::vector<Component> before = measureComponents(surface, componentOf, count);
	pmp::orient_to_bound_a_volume(surface);
	const std::vector<Component> after = measureComponents(surface, componentOf, count);
	std::size_t outward = 0, inward = 0;
	for (std::size_t i = 0; i < count; ++i)
	{
		outward += before[i].volume < 0 && after[i].volume > 0 ? 1 : 0;
		inward += before[i].volume > 0 && after[i].volume < 0 ? 1 : 0;
	}
	if (outward > 0) changes.push_back(counted(outward, "component", "components") + " turned outward, inside out before");
	if (inward > 0) changes.push_back(counted(inward, "component", "components") + " inside others turned to bound cavities");
	surface.remove_property_map(componentOf);
}

Mesh finish(SurfaceMesh& surface, Changes& changes)
{
	dropDegenerate(surface, changes);
	dropFlat(surface, changes);
	if (surface.number_of_faces() == 0) return {};
	moveApart(surface, changes);
	removeCrossings(surface, changes);
	turnByNesting(surface, changes);
	return toMesh(surface);
}
}  // namespace

Mesh toMesh(const SurfaceMesh& surface)
{
	Mesh mesh;
	std::vector<std::uint32_t> number(surface.number_of_vertices() + surface.number_of_removed_vertices(), kNone);
	for (const Face f : surface.faces())
	{
		std::array<std::uint32_t, 3> t = {};
		std::size_t k = 0;
		for (const Vertex v : CGAL::vertices_around_face(surface.halfedge(f), surface))
		{
			std::uint32_t& n = number[std::size_t(v)];
			if (n == kNone)
			{
				n = std::uint32_t(mesh.vertices.size());
				mesh.vertices.push_back(toVec3(surface.point(v)));
			}
			t[k++] = n;
		}
		mesh.triangles.push_back(t);
	}
	return mesh;
}

SurfaceMesh toSurfaceMesh(const Mesh& mesh)
{
	std::vector<Point> points;
	for (const Vec3& v : mesh.vertices) points.push_back(toPoint(v));
	std::vector<std::array<std::size_t, 3>> polygons;
	for (const auto& t : mesh.triangles) polygons.push_back({t[0], t[1], t[2]});
	SurfaceMesh surface;
	if (pmp::is_polygon_soup_a_polygon_mesh(polygons)) pmp::polygon_soup_to_polygon_mesh(points, polygons, surface);
	return surface;
}

Mesh mend(const WeldedMesh& mesh, Changes& changes)
{
	SurfaceMesh surface = orient(mesh, changes);
	fillHoles(surface, changes);
	return finish(surface, changes);
}

Mesh mendRounded(const Mesh& mesh, Changes& changes)
{
	SurfaceMesh surface = toSurfaceMesh(mesh);
	return surface.number_of_faces() == 0 ? mesh : finish(surface, changes);
}
}  // namespace clod::builder
