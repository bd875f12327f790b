// SPDX-License-Identifier: Zlib
// How far apart two bodies are: the nearest pair of accepted nodes, whatever their level, or of the input surfaces; and
// the pairs of leaves near each other. Each search starts from the roots, so what it finds is a function of the pose.
#pragma once
#include "clod/collide/SeparatingAxis.h"
#include "clod/query/NearestPair.h"

namespace clod
{
struct SurfaceSearchScratch : NearestPairScratch
{
	NearestPair nearest;
	SeparatingAxes axes;  // of pairs of leaves, and of leaves: most pairs that are near by their boxes are met again
};

// The smallest tolerance at which a traversal reports a contact: over all accepted pairs and the ways to them, the
// smallest max(hull distance, culling separations on the way). That is the smallest hull distance, but for pairs met
// through shared children only, whose parents' boxes need not enclose their hulls. Hull distances are upper ends of the
// certified bracket from the canonical start. Each pair is opened once at most.
double closestDistance(const QueryContext& context, const StopRule& rule, NearestPairScratch& scratch,
					   QueryStats& stats);

// The distance of the two input surfaces, from the pairs of leaves (exact mode's tree).
struct SurfaceDistance
{
	double low, high;  // certified; both 0 where two leaves overlap or touch
	double value;      // the upper end of the nearest pair's bracket; infinite where no pair is nearer than known
};
// known: pairs beyond it are not looked for.
SurfaceDistance surfaceDistance(const QueryContext& context, double known, SurfaceSearchScratch& scratch,
								QueryStats& stats);

// Every pair of leaves within the tolerance, as contacts, in no particular order.
void gatherLeafPairs(const QueryContext& context, double tolerance, SurfaceSearchScratch& scratch,
					 std::vector<Contact>& pairs, QueryStats& stats);
}  // namespace clod
