// SPDX-License-Identifier: Zlib
// The convex hull of a body that is known by its support function: exact for points and polyhedra, and for round bodies
// an inner polyhedron with a certified error. Vertices are float values, as hulls store them.
//
// Based on: the incremental hull of Barber, Dobkin & Huhdanpaa, "The quickhull algorithm for convex hulls", 1996, with
// the support function in place of the points outside.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "clod/Export.h"
#include "clod/collide/Vector.h"

namespace clod
{
struct ConvexPolyhedron
{
	std::vector<Vec3> vertices;
	// Counter-clockwise from outside, closed. None where the body is a point (one vertex) or a segment (two). A flat
	// body's polygon is there twice, back to back.
	std::vector<std::array<std::uint32_t, 3>> triangles;
	double error = 0;  // no point of the body is farther outside, but for the rounding of vertices to float
	struct Plane
	{
		Vec3 normal;  // unit, outward; zero where there are no triangles
		double height;  // of the plane over the point; infinite where there are none
	};
	// Of the faces' planes the one that is least high above a point. Looks at all triangles.
	CLOD_API Plane nearestPlane(const Vec3& point) const;
};

// The farthest point of the body along a direction, which need not be a unit vector.
using Support = std::function<Vec3(const Vec3& direction)>;

// Refined where it is worst until the error is at most `accuracy`, or there are mostVertices (at least 4). What is
// thinner than a millionth of its size counts as flat. Deterministic. As many calls as there are faces on the way,
// some six a vertex.
CLOD_API ConvexPolyhedron convexPolyhedron(const Support& support, double accuracy, std::size_t mostVertices);
// Of finite points, exact; of more than mostVertices the farthest out.
CLOD_API ConvexPolyhedron convexPolyhedron(const std::vector<Vec3>& points, std::size_t mostVertices);
}  // namespace clod
