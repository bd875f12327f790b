// SPDX-License-Identifier: Zlib
// Our own query at one threshold, and the exact answers that everybody is compared with.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "clod/query/Query.h"
#include "demos/peers/Accuracy.h"
#include "demos/peers/Threshold.h"
#include "demos/runner/HierarchyCache.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
// contacts: up to the contact list; where accepted hulls overlap, the gap is left open. gap: the signed gap and its
// certificate besides.
enum class ClodQuestion
{
	contacts,
	gap
};
PeerPointer clodQuery(PeerInfo info, const HierarchyPointer& a, const HierarchyPointer& b, const Threshold& threshold,
					  ClodQuestion question);

// The rows of a recording to measure, of those that move (Motion.h; of all, where `resting` rows are wanted too) and
// touch within the tolerance (gap in exact mode). Each is preceded by the recorded rows before it, not measured.
struct SampleRules
{
	double tolerance = 0;
	RowClock clock;
	int stride = 1;  // of so many one; 0: `mostRows` of them evenly, all where there are fewer
	int mostRows = int(kEnoughRows);
	bool resting = false;
};
struct ExactSample
{
	PoseSample sample;
	std::vector<ExactRow> exact;  // one a measured row; contacts up to kExactRange times the tolerance
};
// A promised bound is looked for up to twice the tolerance; what promises more is founded by contacts within it.
inline constexpr double kExactRange = 2;
ExactSample takeSample(const HierarchyPointer& a, const HierarchyPointer& b, const std::vector<PoseRow>& poses,
					   const SampleRules& rules, const std::function<void(double)>& progress);
}  // namespace clod::demo
