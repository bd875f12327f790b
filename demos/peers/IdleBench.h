// SPDX-License-Identifier: Zlib
// What a pair costs while nothing happens: whole dispatches of Bullet for a pair that is apart though its boxes
// overlap, and for one none of whose transforms changed, ours beside two btConvexHullShapes in the same state.
#pragma once
#include <string>
#include <vector>

#include "demos/peers/BulletPeers.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
inline constexpr int kIdleHullVertices = 32;

enum class IdleState
{
	apartMoving,     // nothing within the tolerance at any threshold; B moves by 0.05 % of the radius before every
					 // dispatch, and has the velocity of that
	apartUnchanged,  // the same without motion
	touchingUnchanged
};
const char* name(IdleState state);

// One method in one state.
struct IdleRow
{
	IdleState state;
	std::string who;
	std::vector<double> microseconds;  // of one dispatch: at each pose the median
	std::vector<double> means;         // and the mean: what is put off comes in it
	double points = 0;                 // mean number of manifold points
};

struct IdleOptions
{
	int poses = int(kEnoughRows);  // at most, of each state
	int dispatches = 40;           // measured at each pose, after some that settle
};

// Ours at each threshold, then the hulls, state by state. Touching poses are taken evenly from the recording; apart
// ones move B away from those as little as clears the tolerance. Empty where nothing touches.
std::vector<IdleRow> measureIdle(const HierarchyPointer& a, const HierarchyPointer& b,
								 const std::vector<PoseRow>& poses, const std::vector<Threshold>& thresholds,
								 const PairFrame& frame, const IdleOptions& options);
}  // namespace clod::demo
