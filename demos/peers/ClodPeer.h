// SPDX-License-Identifier: Zlib
// Our own query at one threshold, and the exact answers that everybody is compared with.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "clod/query/Query.h"
#include "demos/peers/Accuracy.h"
#include "demos/runner/HierarchyCache.h"

namespace clod::demo
{
// contacts: up to the contact list; where accepted hulls overlap, the gap is left open. gap: the signed gap and its
// certificate besides.
enum class ClodQuestion
{
	contacts,
	gap
};
struct Threshold
{
	std::string label;
	Metric metric;
	double gapError = kOff;  // Settings::gapError
};
PeerPointer clodQuery(PeerInfo info, const HierarchyPointer& a, const HierarchyPointer& b, const Threshold& threshold,
					  ClodQuestion question);

// One ladder for all scenes: exact, s0 from 28 to 0.035 % of the radius, certified errors from 10 to 0.02 %; then three
// of them with an exact gap besides.
std::vector<Threshold> thresholdLadder(double radius);

// The rows of a recording to measure: every `stride`-th of those that touch within the tolerance (gap in exact mode)
// and, unless `resting` rows are wanted too, move (Motion.h). Each is preceded by the recorded rows before it, not
// measured.
struct SampleRules
{
	double tolerance = 0, dt = 1.0 / 240;
	int stride = 1;  // 0: such that about `mostRows` are measured
	int mostRows = 40;
	bool resting = false;
};
struct ExactSample
{
	PoseSample sample;
	std::vector<ExactRow> exact;  // one a measured row; contacts up to kReach times the tolerance
};
// A promised bound is looked for up to twice the tolerance; what promises more is founded by contacts within it.
inline constexpr double kReach = 2;
ExactSample takeSample(const HierarchyPointer& a, const HierarchyPointer& b, const std::vector<PoseRow>& poses,
					   const SampleRules& rules, const std::function<void(double)>& progress);
}  // namespace clod::demo
