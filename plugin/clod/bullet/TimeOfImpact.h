// SPDX-License-Identifier: Zlib
// When two bodies first meet on their way from their transforms to their interpolation transforms, by conservative
// advancement: no point of them comes nearer in a share of the way than its motion allows, so the gap over a bound of the
// motion is a share that is free.
//
// Based on: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996 (conservative advancement).
#pragma once
#include "clod/bullet/PairPose.h"
#include "clod/distance/SignedGap.h"

namespace clod
{
// Share of the way, 1 where they do not meet; of bodies that touch at the start 1, too: their contacts hold them. A
// shape of ours, and another or a convex one or a plane. To within a thousandth of the smaller radius, at full resolution.
double timeOfImpact(const PairPose& pose, GapCache& cache, GapResult& result);
}  // namespace clod
