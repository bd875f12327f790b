// SPDX-License-Identifier: GPL-3.0-or-later
// Open edges that were meant to be one: cracks, and corners of other faces that lie on them.
#pragma once
#include "builder/intake/Triangulate.h"
#include "builder/repair/Changes.h"

namespace clod::builder
{
// Sews vertices on open edges that lie within `tolerance` of each other.
void sewCracks(WeldedMesh& mesh, double tolerance, Changes& changes);

// Splits faces with an open edge at the vertices of open edges that lie on it, within `tolerance`.
void splitAtTJunctions(WeldedMesh& mesh, double tolerance, Changes& changes);
}  // namespace clod::builder
