// SPDX-License-Identifier: Zlib
// Asset::thinnestWall of a hierarchy in the making, and what walls are usual.
#pragma once
#include "clod/Export.h"
#include "clod/hierarchy/Hierarchy.h"

namespace clod
{
// From the middle of each face of the input surface straight inward to the first face that is left outward: the
// shortest of these ways, leaving out those that rounding may have made; twice the radius where none is met. Needs
// faces, hulls and radius. A quarter of a microsecond a face.
double thinnestWall(const HierarchyContent& content);

// What messages go by, since a slit or a blade's edge is no reason to warn: all but a twentieth of the surface has a
// wall of at least this behind it, as far as its faces know (Face::thickness; of a stretched body, thinnestWall). Kept
// with a hierarchy (Hierarchy::derived). O(faces).
struct CLOD_API UsualWall
{
	explicit UsualWall(const Hierarchy& hierarchy);
	double thickness;
};
}  // namespace clod
