// SPDX-License-Identifier: GPL-3.0-or-later
// What the tests of the models measure on a triangle mesh, each fact by its definition.
#pragma once
#include <string>

#include "demos/models/Models.h"

namespace clod::demo::test
{
// Empty, or the first fault: an index out of range, an edge not shared by exactly two triangles in opposite senses, a
// vertex unused or whose triangles are not one fan.
std::string manifoldFault(const ModelMesh& mesh);
// V - E + F: 2 - 2 genus for one closed piece.
long eulerCharacteristic(const ModelMesh& mesh);
size_t pieceCount(const ModelMesh& mesh);
double volume(const ModelMesh& mesh);
// Length of the longest edge over the height on it, 1.15 where all edges are equal; infinite for a flat triangle.
double worstAspect(const ModelMesh& mesh);
size_t aspectsOver(const ModelMesh& mesh, double limit);
double smallestHeight(const ModelMesh& mesh);
Vec3 lowCorner(const ModelMesh& mesh);
Vec3 highCorner(const ModelMesh& mesh);
double distanceToMesh(const Vec3& point, const ModelMesh& mesh);  // unsigned, all triangles
bool intersectsItself(const ModelMesh& mesh);                     // CGAL, exact predicates
}  // namespace clod::demo::test
