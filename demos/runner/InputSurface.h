// SPDX-License-Identifier: Zlib
// The mesh a hierarchy was built from, as the hierarchy keeps it.
#pragma once
#include "clod/hierarchy/Hierarchy.h"
#include "demos/models/Models.h"

namespace clod::demo
{
// Level 0, vertices at equal places joined; in the mesh's own frame, coordinates rounded to float about the body's
// origin.
ModelMesh inputSurface(const Hierarchy& hierarchy);
}  // namespace clod::demo
