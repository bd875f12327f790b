// SPDX-License-Identifier: GPL-3.0-or-later
// Self-intersections: between components by a Boolean union, within one by CGAL's experimental repair.
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/boost/graph/Face_filtered_graph.h>
#include <CGAL/boost/graph/copy_face_graph.h>
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "builder/repair/SurfaceMesh.h"

namespace clod::builder
{
namespace
{
namespace pmp = CGAL::Polygon_mesh_processing;
using Face = SurfaceMesh::Face_index;
using FacePairs = std::vector<std::pair<Face, Face>>;
using FaceComponent = SurfaceMesh::Property_map<Face, std::size_t>;

FacePairs crossings(const SurfaceMesh& surface)
{
	FacePairs pairs;
	pmp::self_intersections(surface, std::back_inserter(pairs));
	return pairs;
}

FaceComponent numberComponents(SurfaceMesh& surface, std::size_t& count)
{
	const FaceComponent componentOf = surface.add_property_map<Face, std::size_t>("f:crossing component", 0).first;
	count = pmp::connected_components(surface, componentOf);
	return componentOf;
}

std::size_t crossingWithin(const FacePairs& pairs, const FaceComponent& componentOf)
{
	return std::size_t(std::count_if(pairs.begin(), pairs.end(),
									 [&](const auto& pair)
									 { return componentOf[pair.first] == componentOf[pair.second]; }));
}

// Components that cross, directly or through others, have the same group: the lowest of their numbers.
std::vector<std::size_t> groups(const FacePairs& pairs, const FaceComponent& componentOf, std::size_t count)
{
	std::vector<std::size_t> group(count);
	std::iota(group.begin(), group.end(), std::size_t(0));
	const auto find = [&](std::size_t i)
	{
		while (group[i] != i) i = group[i];
		return i;
	};
	for (const auto& [f, g] : pairs)
	{
		const std::size_t a = find(componentOf[f]), b = find(componentOf[g]);
		group[std::max(a, b)] = std::min(a, b);
	}
	for (std::size_t i = 0; i < count; ++i) group[i] = find(i);
	return group;
}

// Turned outward: a union of solids is meant.
SurfaceMesh extract(const SurfaceMesh& surface, const FaceComponent& componentOf, std::size_t component)
{
	SurfaceMesh part;
	CGAL::copy_face_graph(CGAL::Face_filtered_graph<SurfaceMesh>(surface, component, componentOf), part);
	if (pmp::volume(part) < 0) pmp::reverse_face_orientations(part);
	return part;
}

// False where CGAL cannot unite them into a manifold; the surface is then as before.
bool uniteComponents(SurfaceMesh& surface, const FacePairs& pairs, Changes& changes)
{
	std::size_t count = 0;
	const FaceComponent componentOf = numberComponents(surface, count);
	const std::vector<std::size_t> group = groups(pairs, componentOf, count);
	SurfaceMesh result;
	std::size_t united = 0;
	for (std::size_t leader = 0; leader < count; ++leader)
	{
		if (group[leader] != leader) continue;
		SurfaceMesh whole;
		CGAL::copy_face_graph(CGAL::Face_filtered_graph<SurfaceMesh>(surface, leader, componentOf), whole);
		for (std::size_t i = leader + 1; i < count; ++i)
		{
			if (group[i] != leader) continue;
			if (pmp::volume(whole) < 0) pmp::reverse_face_orientations(whole);
			SurfaceMesh part = extract(surface, componentOf, i), both;
			if (!pmp::corefine_and_compute_union(whole, part, both)) return false;
			whole = std::move(both);
			++united;
		}
		CGAL::copy_face_graph(whole, result);
	}
	surface = std::move(result);
	changes.push_back(counted(united, "component", "components") + " united with others that cross them");
	return true;
}
}  // namespace

bool removeCrossings(SurfaceMesh& surface, Changes& changes)
{
	FacePairs pairs = crossings(surface);
	if (pairs.empty()) return true;
	std::size_t count = 0;
	const std::size_t within = crossingWithin(pairs, numberComponents(surface, count));
	if (within > 0)
	{
		pmp::experimental::remove_self_intersections(surface, CGAL::parameters::preserve_genus(false));
		surface.collect_garbage();
		changes.push_back(counted(within, "crossing pair", "crossing pairs") + " of faces of one component cut out and filled");
		pairs = crossings(surface);
		if (pairs.empty()) return true;
		if (crossingWithin(pairs, numberComponents(surface, count)) > 0) return false;
	}
	return uniteComponents(surface, pairs, changes) && crossings(surface).empty();
}
}  // namespace clod::builder
