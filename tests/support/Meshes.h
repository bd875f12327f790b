// SPDX-License-Identifier: GPL-3.0-or-later
// Closed meshes with known shapes, coordinates rounded to float, in the body frame (all are symmetric about the
// origin).
#pragma once
#include "builder/Lod.h"

namespace clod::test
{
builder::Mesh boxMesh(const Vec3& halfExtents, int divisions);               // divisions x divisions quads a side
builder::Mesh sphereMesh(double radius, int segments, int rings);            // poles on y
builder::Mesh torusMesh(double ring, double tube, int segments, int sides);  // axis y
// A torus whose tube is wrinkled along the ring: not convex anywhere for long.
builder::Mesh wrinkledTorusMesh(double ring, double tube, double wrinkle, int waves, int segments, int sides);
// Each triangle a patch of its own / each consecutive pair of triangles (the quads of the meshes above, which are
// convex or flat on convex parts).
builder::Lod trianglePatches(const builder::Mesh& mesh);
builder::Lod quadPatches(const builder::Mesh& mesh);
// Torus levels segments x sides, halved in each direction `levels` times, with quads as patches: for tests of the
// assembly only, patches on the inner side are slightly concave.
builder::LodSequence torusLods(double ring, double tube, int segments, int sides, int levels);
}  // namespace clod::test
