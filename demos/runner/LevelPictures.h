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

// The same levels as heat maps: how far each place of a level is from the input surface, as measured, on a logarithmic
// scale of the radius; what is certified is in the captions.
Image paintLevelErrors(const Hierarchy& hierarchy, const std::string& title);

// The steps of that scale, counted from 0: up to 0.01, 0.03, ... 10 %, and more.
inline constexpr int kHeatSteps = 8;
int heatStep(double shareOfRadius);
}  // namespace clod::demo
