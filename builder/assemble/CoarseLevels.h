// SPDX-License-Identifier: GPL-3.0-or-later
// The coarse end of a model. Collapses under convexity constraints leave a patch a facet, and a concave wall has as
// many as its curvature asks for. Here neighbouring patches become one wherever their common hull is certified to stay
// within a share of the radius of the solid: it may bridge the wall between them.
#pragma once
#include "builder/assemble/Parallel.h"
#include "builder/assemble/Protrusion.h"

namespace clod::builder
{
constexpr std::uint32_t kMostBridged = 800;  // patches of a level: pairs are tried one by one

// `lods`: the coarsest levels, the input surface not among them. For each of 1, 3, 10, 20 and 40 % of the radius a
// bridged level is made of the one with fewest patches up to the coarsest that leaves room for it, or with fewest
// triangles where that leaves about as few. Of all of them a chain stays, from the finest on, in which every level
// halves the patches of the one below: that with the fewest within 1, 3 and 10 %. What a bridged hull sticks out,
// thickness included, stays within its error. The same for any number of threads. Cost: about a millisecond for a pair
// of neighbours.
void bridgeCoarseLevels(std::vector<Lod>& lods, const Solid& solid, const ProtrusionScale& scale,
						const ThreadLimit& threads);
}  // namespace clod::builder
