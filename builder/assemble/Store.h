// SPDX-License-Identifier: GPL-3.0-or-later
// From the finished draft to the records of a file: order, rounding, culling boxes, asset.
#pragma once
#include "builder/assemble/BoundingSphere.h"
#include "builder/assemble/Draft.h"
#include "builder/assemble/TriangleTree.h"

namespace clod::builder
{
HierarchyContent store(const HierarchyDraft& draft, const std::vector<Lod>& lods, const BuildConfig& config,
					   const Solid& solid, const Sphere& sphere);
}  // namespace clod::builder
