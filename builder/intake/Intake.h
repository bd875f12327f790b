// SPDX-License-Identifier: GPL-3.0-or-later
// From a mesh file to the builder's input: a closed, oriented, non-self-intersecting 2-manifold in the body frame, its
// coordinates rounded to float. Geometry is never repaired: what is not sound is refused with its first offending
// element. Nothing that is not finite reaches CGAL.
#pragma once
#include <string>

#include "builder/Lod.h"
#include "builder/intake/Triangulate.h"

namespace clod::builder
{
struct Intake
{
	Mesh mesh;                                        // body frame
	Vec3 meshFromBody;                                // the centre of mass, in the frame of the file
	std::size_t componentCount = 0, cavityCount = 0;  // cavities: components that bound the solid from inside
	std::size_t weldedCount = 0, unusedCount = 0;     // vertices of the file that repeat another one, or are in no face
};

// All of it. Throws Refused.
Intake intake(const Soup& soup);
Intake intakeFile(const std::string& path);

// What is wrong with a mesh without any arithmetic, one entry a kind: degenerate and duplicate faces, edges of more
// than two faces or of one, orientation, vertices. Where a face repeats a corner, edges and vertices are not looked at.
std::vector<Defect> topologyDefects(const WeldedMesh& mesh);
// Throws all of them as one Refused.
void checkTopology(const WeldedMesh& mesh);

// Number of edge-connected components; componentOf gets that of each triangle.
std::size_t components(const WeldedMesh& mesh, std::vector<std::uint32_t>& componentOf);

// Self-intersections (CGAL, exact predicates), then the nesting of the components against their orientation, on the
// rounded coordinates. Number of cavities. Throws Refused; messages name elements of the file.
std::size_t checkSolid(const Mesh& rounded, const WeldedMesh& mesh, const std::vector<std::uint32_t>& componentOf);
}  // namespace clod::builder
