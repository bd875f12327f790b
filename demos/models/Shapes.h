// SPDX-License-Identifier: Zlib
// One maker per shape; makeModel (Models.h) picks among them. Each takes the wanted triangle count and returns the
// closest it can, or an empty mesh where the count is too small for the shape.
#pragma once
#include "demos/models/Models.h"

namespace clod::demo
{
ModelMesh makeCup(size_t triangles);
ModelMesh makeBowl(size_t triangles);
ModelMesh makeSpoon(size_t triangles);
ModelMesh makeSpiral(size_t triangles);
// wrinkle: amplitude over tube radius. Wrinkles that the grid cannot carry (under 4 samples a wave) are left out.
ModelMesh makeTorus(size_t triangles, double wrinkle);
ModelMesh makeBolt(size_t triangles);
ModelMesh makeNut(size_t triangles);
ModelMesh makeDigit(int digit, size_t triangles);
// A box of the given size centred at the origin, every face a grid of near-square cells.
ModelMesh makeBox(const Vec3& size, size_t triangles);
ModelMesh makeLandscape(size_t triangles);
ModelMesh makeSphere(size_t triangles, double radius);
}  // namespace clod::demo
