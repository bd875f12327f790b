// SPDX-License-Identifier: GPL-3.0-or-later
// The repairs that need no geometry kernel: faces that cannot be part of any surface, and repeated faces.
#pragma once
#include <vector>

#include "builder/intake/Triangulate.h"
#include "builder/repair/Changes.h"

namespace clod::builder
{
// The faces of the file that have finite corners and area, welded and cut into triangles. Throws Refused where nothing
// is left, for indices out of range and for limits.
WeldedMesh usableFaces(const Soup& soup, Changes& changes);

// One face of each set with the same corners. Pairs that face both ways go altogether, unless that opens an edge or
// leaves nothing of their component.
void dropRepeatedFaces(WeldedMesh& mesh, Changes& changes);

// The largest side of the box round the vertices.
double extentOf(const std::vector<Vec3>& vertices);
}  // namespace clod::builder
