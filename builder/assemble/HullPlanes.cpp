// SPDX-License-Identifier: GPL-3.0-or-later
// CGAL decides the combinatorics exactly (convex_hull_3, EPICK); offsets are then measured over all points, so the
// half-spaces contain the hull whatever the normals' rounding.
#include "builder/assemble/HullPlanes.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
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
	for (const auto f : mesh.faces())
	{
		std::array<Vec3, 3> corner;
		std::size_t k = 0;
		for (const auto v : mesh.vertices_around_face(mesh.halfedge(f)))
			if (k < 3) corner[k++] = toVec3(mesh.point(v));
		std::rotate(corner.begin(), std::min_element(corner.begin(), corner.end(), precedes), corner.end());
		shape.facets.push_back({corner[0], corner[1], corner[2]});
	}
	// CGAL's order follows addresses in memory; bytes must not.
	std::sort(shape.corners.begin(), shape.corners.end(), precedes);
	std::sort(shape.facets.begin(), shape.facets.end(), facetPrecedes);
	for (const Triangle& f : shape.facets)
	{
		const Vec3 n = normalized(areaVector(f));
		const auto same = [&n](const HalfSpace& p) { return lengthSquared(p.normal - n) < 1e-20; };
		if (n != Vec3{} && std::none_of(shape.planes.begin(), shape.planes.end(), same)) shape.planes.push_back({n, 0});
	}
	measureOffsets(shape.planes, points);
	return shape;
}
}  // namespace clod::builder
