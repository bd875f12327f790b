// SPDX-License-Identifier: GPL-3.0-or-later
// CGAL's mesh type as the repairs use it. For the sources of this folder only: it drags in CGAL.
#pragma once
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include "builder/Lod.h"
#include "builder/repair/Changes.h"

namespace clod::builder
{
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;

inline Vec3 toVec3(const Point& p)
{
	return {p.x(), p.y(), p.z()};
}
inline Point toPoint(const Vec3& v)
{
	return {v.x, v.y, v.z};
}

// Vertices and faces in their order.
Mesh toMesh(const SurfaceMesh& surface);
// Of a 2-manifold; empty where the triangles are none.
SurfaceMesh toSurfaceMesh(const Mesh& mesh);

// Components that cross are united; crossings within one are cut out and filled. False where some are left.
bool removeCrossings(SurfaceMesh& surface, Changes& changes);
}  // namespace clod::builder
