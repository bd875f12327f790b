// SPDX-License-Identifier: GPL-3.0-or-later
// CGAL decides the combinatorics exactly (convex_hull_3, EPICK); offsets are then measured over all points, so the
// half-spaces contain the hull whatever the normals' rounding.
#include "builder/assemble/HullPlanes.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "builder/assemble/Geometry.h"
#include "builder/assemble/MassProperties.h"

namespace clod::builder
{
namespace
{
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using HullMesh = CGAL::Surface_mesh<Kernel::Point_3>;

Vec3 toVec3(const Kernel::Point_3& p)
{
	return {p.x(), p.y(), p.z()};
}

bool precedes(const Vec3& a, const Vec3& b)
{
	return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

bool facetPrecedes(const Triangle& f, const Triangle& g)
{
	for (int k = 0; k < 3; ++k)
		if (f[k] != g[k]) return precedes(f[k], g[k]);
	return false;
}

void measureOffsets(std::vector<HalfSpace>& planes, const std::vector<Vec3>& points)
{
	for (HalfSpace& plane : planes)
	{
		plane.offset = dot(plane.normal, points[0]);
		for (const Vec3& p : points) plane.offset = std::max(plane.offset, dot(plane.normal, p));
	}
}

// Every point moved by +-minimum along each principal direction in which the set is thinner than that.
std::vector<Vec3> thickened(const std::vector<Vec3>& points, double minimum)
{
	const Mat3 axes = principalAxes(points);
	std::vector<Vec3> result = points;
	for (const Vec3& axis : axes.row)
	{
		double low = dot(axis, points[0]), high = low;
		for (const Vec3& p : points)
		{
			low = std::min(low, dot(axis, p));
			high = std::max(high, dot(axis, p));
		}
		if (high - low >= minimum) continue;
		const std::size_t count = result.size();
		for (std::size_t i = 0; i < count; ++i)
		{
			result.push_back(result[i] + minimum * axis);
			result[i] = result[i] - minimum * axis;
		}
	}
	return result;
}
// How CGAL cuts a facet of more than three corners into triangles follows addresses in memory, and bounds follow the
// triangles. Each such facet is cut anew, as a fan from its first corner.
std::vector<Triangle> canonicalFacets(const HullMesh& mesh)
{
	const auto isFlat = [&mesh](HullMesh::Halfedge_index h)
	{
		const auto across = mesh.opposite(h);
		return CGAL::coplanar(mesh.point(mesh.source(h)), mesh.point(mesh.target(h)),
							  mesh.point(mesh.target(mesh.next(h))), mesh.point(mesh.target(mesh.next(across))));
	};
	std::vector<Triangle> facets;
	std::vector<bool> done(mesh.number_of_faces(), false);
	for (const auto seed : mesh.faces())
	{
		if (done[std::size_t(seed)]) continue;
		std::vector<HullMesh::Face_index> open{seed};
		std::map<std::size_t, HullMesh::Vertex_index> next;  // along the border, counter-clockwise
		done[std::size_t(seed)] = true;
		while (!open.empty())
		{
			const auto face = open.back();
			open.pop_back();
			for (const auto h : mesh.halfedges_around_face(mesh.halfedge(face)))
			{
				const auto other = mesh.face(mesh.opposite(h));
				if (!isFlat(h))
					next[std::size_t(mesh.source(h))] = mesh.target(h);
				else if (!done[std::size_t(other)])
				{
					done[std::size_t(other)] = true;
					open.push_back(other);
				}
			}
		}
		if (next.empty()) continue;
		std::vector<Vec3> border;
		auto at = next.begin()->second;
		for (std::size_t i = 0; i < next.size(); ++i, at = next.at(std::size_t(at)))
			border.push_back(toVec3(mesh.point(at)));
		std::rotate(border.begin(), std::min_element(border.begin(), border.end(), precedes), border.end());
		for (std::size_t i = 2; i < border.size(); ++i) facets.push_back({border[0], border[i - 1], border[i]});
	}
	return facets;
}
}  // namespace

HullShape hullShape(const std::vector<Vec3>& input, double minimum)
{
	const std::vector<Vec3> points = thickened(input, minimum);
	std::vector<Kernel::Point_3> cgalPoints;
	for (const Vec3& p : points) cgalPoints.emplace_back(p.x, p.y, p.z);
	HullMesh mesh;
	CGAL::convex_hull_3(cgalPoints.begin(), cgalPoints.end(), mesh);
	HullShape shape;
	for (const auto v : mesh.vertices()) shape.corners.push_back(toVec3(mesh.point(v)));
	std::vector<Triangle> facets = canonicalFacets(mesh);
	// CGAL's order follows addresses in memory; bytes must not.
	std::sort(shape.corners.begin(), shape.corners.end(), precedes);
	std::sort(facets.begin(), facets.end(), facetPrecedes);
	const auto cornerAt = [&corners = shape.corners](const Vec3& p)
	{ return std::uint32_t(std::lower_bound(corners.begin(), corners.end(), p, precedes) - corners.begin()); };
	for (const Triangle& f : facets)
	{
		shape.facets.push_back({cornerAt(f.a), cornerAt(f.b), cornerAt(f.c)});
		const Vec3 n = normalized(areaVector(f));
		const auto same = [&n](const HalfSpace& p) { return lengthSquared(p.normal - n) < 1e-20; };
		if (n != Vec3{} && std::none_of(shape.planes.begin(), shape.planes.end(), same)) shape.planes.push_back({n, 0});
	}
	measureOffsets(shape.planes, points);
	return shape;
}
}  // namespace clod::builder
