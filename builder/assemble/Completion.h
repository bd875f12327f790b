// SPDX-License-Identifier: GPL-3.0-or-later
// The levels above the coarsest contact level: unconstrained pairwise merging to one root (paper sec. 4.2).
#pragma once
#include "builder/assemble/Draft.h"
#include "builder/assemble/Parallel.h"

namespace clod::builder
{
// Appends levels of ceil(n/2) nodes until one node is left. Each new hull contains the thickened hulls of everything
// below it up to the rounding of its vertices, which is its h; it has at most 64 corners, pushed outward where the
// exact hull has more. corners[i] spans everything below and in node i of the present top level.
void completeToRoot(HierarchyDraft& draft, std::vector<std::vector<Vec3>> corners, const ThreadLimit& threads);
}  // namespace clod::builder
