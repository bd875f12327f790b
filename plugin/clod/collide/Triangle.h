// SPDX-License-Identifier: Zlib
// A triangle in space, and that of a real face.
#pragma once
#include <array>

#include "clod/hierarchy/Hierarchy.h"

namespace clod
{
using Triangle = std::array<Vec3, 3>;

// Corners of a real face, body frame.
inline Triangle triangleOf(const Hierarchy& hierarchy, const Node& owner, const Face& face)
{
	const HullView hull = hierarchy.hull(owner);
	return {hull.vertex(face.vertex[0]), hull.vertex(face.vertex[1]), hull.vertex(face.vertex[2])};
}
}  // namespace clod
