// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/repair/Wrap.h"

#include <CGAL/alpha_wrap_3.h>

#include "builder/repair/SurfaceMesh.h"

namespace clod::builder
{
Mesh alphaWrap(const Mesh& mesh, double alpha, double offset)
{
	std::vector<Point> points;
	for (const Vec3& v : mesh.vertices) points.push_back(toPoint(v));
	SurfaceMesh wrap;
	CGAL::alpha_wrap_3(points, mesh.triangles, alpha, offset, wrap);
	return toMesh(wrap);
}
}  // namespace clod::builder
