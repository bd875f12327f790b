// SPDX-License-Identifier: Zlib
// The paper's own traversal, as a reference: an oracle of the product's, and the other half of Figure 4. It starts from
// the roots at every pose and keeps no front; pairs are culled by the distance of their hulls less their drifts,
// d(a, b) - h(a) - h(b) > tolerance (eq. 1), and children are those of the tree alone. Contacts, gap and certificate
// are defined as in the plugin (distance/SignedGap.h).
//
// Based on: Otaduy & Lin 2003, sec. 3.3. Departs from it: the contact area of a pair is the plugin's (StopRule.h).
#pragma once
#include "clod/distance/SignedGap.h"

namespace clod::demo
{
// Precondition: both hierarchies are paper builds (Hierarchy::isPaperBuild), no sweep and no budget are set.
void paperQuery(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const GapSettings& settings,
				GapResult& result);
// Empty, or one sentence that names what cannot be asked.
std::string paperQueryError(const Hierarchy& a, const Hierarchy& b, const GapSettings& settings);
}  // namespace clod::demo
