// SPDX-License-Identifier: Zlib
// Is a body held between its contacts, like a pin in its hole, so that no direction leads out of all of them at once?
// The play is then of the order of the margins, and a level that deviates by more jams although it keeps its error
// bound.
#pragma once
#include <vector>

#include "clod/Export.h"
#include "clod/manifold/Facet.h"

namespace clod
{
// Of the facets that touch, or overlap.
CLOD_API bool isHeldBetween(const FacetQuestion& question, const std::vector<Facet>& facets);
}  // namespace clod
