// SPDX-License-Identifier: GPL-3.0-or-later
// Oriented boxes and spheres round point sets, rounded outward.
#pragma once
#include <vector>

#include "clod/hierarchy/Layout.h"

namespace clod::builder
{
// The box with the least surface among the mesh axes, the principal axes and the frame of `normal` (may be zero) turned
// to the least rectangle, turned further as long as that makes it smaller. Contains every point with a margin of 1e-6
// of the set's size. assetRadius: sets the grid of the centre (BoundGrid.h).
OrientedBox fitCullBox(const std::vector<Vec3>& points, const Vec3& normal, float assetRadius);
}  // namespace clod::builder
