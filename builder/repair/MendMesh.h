// SPDX-License-Identifier: GPL-3.0-or-later
// The repairs that need CGAL: orientation, holes, slivers, crossings.
#pragma once
#include "builder/Lod.h"
#include "builder/intake/Triangulate.h"
#include "builder/repair/Changes.h"

namespace clod::builder
{
// Turns the faces to agree and makes them a closed 2-manifold without crossings, its components facing outward, or
// inward round cavities. Every change is a sentence. What it cannot mend it leaves for the intake to name.
Mesh mend(const WeldedMesh& mesh, Changes& changes);

// Once more, after rounding: slivers that lost their area, and crossings that appeared.
Mesh mendRounded(const Mesh& mesh, Changes& changes);
}  // namespace clod::builder
