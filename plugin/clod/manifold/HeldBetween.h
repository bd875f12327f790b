// SPDX-License-Identifier: Zlib
// Is a body held between contacts: is there no way out of all of them at once? A pin in its hole is. There the play is of
// the order of the margins, and a level that deviates by more jams, though it keeps what was asked of its error.
#pragma once
#include <vector>

#include "clod/manifold/Facet.h"

namespace clod
{
// Of the facets that touch, or overlap.
bool isHeldBetween(const FacetQuestion& question, const std::vector<Facet>& facets);
}  // namespace clod
