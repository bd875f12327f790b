// SPDX-License-Identifier: GPL-3.0-or-later
// The coarse end of a model. Collapses under convexity constraints leave a patch a facet, and a concave wall has as
// many as its curvature asks for. Here neighbouring patches become one wherever their common hull is certified to stay
// within a share of the radius of the solid: it may bridge the wall between them.
#pragma once
#include "builder/assemble/Parallel.h"
#include "builder/assemble/Protrusion.h"

namespace clod::builder
{
constexpr std::uint32_t kMostBridged = 200;  // patches of a level: pairs are tried one by one

// `lods`: the coarsest levels, the input surface not among them. From the coarsest one that leaves room, a bridged
// level for each of 10, 20 and 40 % of the radius, where that halves the patches or, in the place of the level that was
// bridged, those of the level below; coarser levels of collapses are dropped then. What a bridged hull sticks out,
// thickness included, stays within its error. The same for any number of threads. Cost: about a millisecond for a pair
// of neighbours.
void bridgeCoarseLevels(std::vector<Lod>& lods, const Solid& solid, const ProtrusionScale& scale,
						const ThreadLimit& threads);
}  // namespace clod::builder
