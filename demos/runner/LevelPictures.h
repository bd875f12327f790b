// SPDX-License-Identifier: Zlib
// The paper's Figure 5 for any hierarchy: the model, a detail of its convex patches, and every contact level of detail,
// one colour a patch.
#pragma once
#include <string>

#include "demos/render/Image.h"
#include "demos/runner/HierarchyCache.h"

namespace clod::demo
{
// Captions carry triangles, patches and the certified error of the level. Throws cli::Failure (1) where there is no
// off-screen context.
Image paintLevels(const Hierarchy& hierarchy, const std::string& title);
}  // namespace clod::demo
