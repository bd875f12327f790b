// SPDX-License-Identifier: Zlib
// When two bodies first meet on their way from their transforms to their interpolation transforms, by conservative
// advancement: parts of the way on which a sweep meets nothing are free at once; where it meets something, the gap to
// that, divided by a bound of the relative motion, is a share of the way in which they cannot meet.
//
// Based on: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996 (conservative advancement).
#pragma once
#include "clod/bullet/PairPose.h"
#include "clod/query/Query.h"

namespace clod
{
// Returns a share of the way, 0 to 1; 1 if the bodies do not meet, or touch at the start, when contacts hold them; if
// the way is not finite, too. One has a shape of ours, the other a shape of ours, a convex shape or a plane. Bodies
// meet where the surfaces do that the metric allows at the start (frame A), from which contacts are made, too: exact to
// a thousandth of the smaller radius for these, or earlier where they graze each other. A plane is met at full
// resolution. No budget counts these queries: two for each part of the way, as few parts as its bending allows, and at
// most 256 where bodies are near. cache: the pair's; result: scratch.
double timeOfImpact(const PairPose& pose, const Metric& metric, PairCache& cache, ContactResult& result);
}  // namespace clod
