// SPDX-License-Identifier: Zlib
// Asset::thinnestWall of a hierarchy in the making.
#pragma once
#include "clod/hierarchy/Hierarchy.h"

namespace clod
{
// From the middle of each face of the input surface straight inward to the first face that is left outward: the
// shortest of these ways, leaving out those that rounding may have made; twice the radius where none is met. Needs
// faces, hulls and radius. A quarter of a microsecond a face.
double thinnestWall(const HierarchyContent& content);
}  // namespace clod
