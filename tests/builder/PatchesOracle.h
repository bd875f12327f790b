// SPDX-License-Identifier: GPL-3.0-or-later
// A slow, independent second opinion on levels: everything from the vertex lists, hulls by exact arithmetic (CGAL),
// no box trees, no code of the builder.
#pragma once
#include <string>

#include "builder/Lod.h"

namespace clod::builder::test
{
// Empty when the mesh is a closed oriented 2-manifold without unused vertices; otherwise the first fault.
std::string faultOfSurface(const Mesh& mesh);
// Empty when every patch is edge-connected, convex and inside the solid within the level's tolerance.
std::string faultOfPatches(const Lod& lod);
// Empty when counts halve, parents fit and resolutions never grow towards the coarse end.
std::string faultOfSequence(const LodSequence& sequence);
long eulerCharacteristic(const Mesh& mesh);
// Largest distance from a's vertices, edge midpoints and centroids to the surface of b. Quadratic.
double deviation(const Mesh& a, const Mesh& b);
double boundingRadius(const Mesh& mesh);
}  // namespace clod::builder::test
