// SPDX-License-Identifier: Zlib
// When two bodies first meet on their way from their transforms to their interpolation transforms, by conservative
// advancement: parts of the way on which a sweep meets nothing are free at once; where it meets something, the gap to
// that, divided by a bound of the relative motion, is a share of the way in which they cannot meet. The source has
// btClodDynamicsWorld's stepping to impacts, too.
//
// Based on: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996 (conservative advancement); Otaduy &
// Lin 2003, sec. 5.3 (impacts that a change of level brings).
#pragma once
#include "clod/bullet/PairPose.h"
#include "clod/distance/SignedGap.h"
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

// The share of the step that bodies about to touch take to close what is left between them.
btScalar shareOfImpact(const btCollisionObject& a, const btCollisionObject& b);

// An impact that the levels in use pass over, and finer ones, asked for at the end of the way, do not. Nobody who looks
// for it finds it: the coarse ones never meet, the fine ones may have overlapped all along. Its time is estimated where
// the separation of the ones and the depth of the others, taken linearly, cancel. Lengths: the hierarchies' unit.
struct SwitchImpact
{
	double share = 1;   // of the way; 1: there is none
	double parted = 0;  // the separation of the levels in use from which on the finer ones are apart, too
};
// pose: of the end; from: aFromB at the start; used, asked: the metrics there and at the end. Costs a query where
// the metrics differ, and five more and a search of the depth where there is an impact.
SwitchImpact impactOfSwitch(const PairPose& pose, const Transform& from, const Metric& used, const Metric& asked,
							GapCache& cache);
// How far apart the surfaces are that a metric allows, and where. Frame A, the hierarchies' unit.
struct Separation
{
	double distance;     // 0: they overlap
	Vec3 point, normal;  // from B to A; none where they overlap, or are `most` apart or more
};
Separation separationOf(const PairPose& pose, const Transform& aFromB, const Metric& metric, double most,
						PairCache& cache);
}  // namespace clod
