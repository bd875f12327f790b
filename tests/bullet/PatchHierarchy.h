// SPDX-License-Identifier: GPL-3.0-or-later
// Small solids with hand-made convex patches, as hierarchies with one contact level: fast, and independent of the
// builder.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "clod/hierarchy/Hierarchy.h"

namespace clod::test
{
struct PatchedMesh
{
	std::vector<Vec3> vertices;
	std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise from outside
	std::vector<std::uint32_t> patch;                     // of each triangle, 0 .. count-1
	double wall = 0;                                      // local wall thickness everywhere,
	double thinnest = 0;                                  // but at a spot, if set
};

// A box of n[0] x n[1] x n[2] cells, two triangles a cell side; patches of `cells` x `cells` cells of one side.
PatchedMesh boxMesh(const Vec3& size, const std::array<int, 3>& n, int cells);
// An icosahedron divided `steps` times; one patch, as it is convex. Lies on a face.
PatchedMesh ballMesh(double radius, int steps);
// The same with every triangle its own patch.
PatchedMesh singleTriangles(PatchedMesh mesh);
PatchedMesh merged(const PatchedMesh& a, const PatchedMesh& b, const Vec3& offsetOfB);

// Aborts with the reason when the mesh is not a closed manifold or the result does not validate.
std::shared_ptr<const Hierarchy> patchHierarchy(const PatchedMesh& mesh);
// Boxes of 1 x 1 x 1 and 10 x 1 x 10.
std::shared_ptr<const Hierarchy> cube();
std::shared_ptr<const Hierarchy> slab();
}  // namespace clod::test
