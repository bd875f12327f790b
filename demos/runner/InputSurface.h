// SPDX-License-Identifier: Zlib
// The mesh a hierarchy was built from, as the hierarchy keeps it, and its coarser ones.
#pragma once
#include "clod/hierarchy/Hierarchy.h"
#include "demos/models/Models.h"

namespace clod::demo
{
// A level that has faces, vertices at equal places joined; in the mesh's own frame, coordinates rounded to float about
// the body's origin.
ModelMesh levelSurface(const Hierarchy& hierarchy, std::uint32_t level);
ModelMesh inputSurface(const Hierarchy& hierarchy);  // level 0
}  // namespace clod::demo
