// SPDX-License-Identifier: Zlib
// When two bodies first meet on their way from their transforms to their interpolation transforms, by conservative
// advancement: the gap divided by a bound of the relative motion is a share of the way in which they cannot meet.
//
// Based on: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996 (conservative advancement).
#pragma once
#include "clod/bullet/PairPose.h"
#include "clod/query/Query.h"

namespace clod
{
// Returns a share of the way, 0 to 1; 1 if the bodies do not meet, or touch at the start, when contacts hold them. One
// has a shape of ours, the other a shape of ours, a convex shape or a plane. Bodies meet where the surfaces do that the
// metric allows, from which contacts are made, too: exact to a thousandth of the smaller radius for these, or
// earlier where they graze each other. A plane is met at full resolution.
double timeOfImpact(const PairPose& pose, const Metric& metric, PairCache& cache, ContactResult& result);
}  // namespace clod
