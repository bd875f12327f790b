// SPDX-License-Identifier: Zlib
// One setting of ours in a comparison, and the ladder of them that is measured in every scene.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "clod/query/ContactMetric.h"
#include "clod/query/Query.h"
#include "demos/scenes/CameraPath.h"

namespace clod::demo
{
struct Threshold
{
	std::string label;  // see labelOf
	ContactMetric metric;
	double gapError = kOff;            // GapSettings::gapError
	Budget budget = {};                // of every query
	std::optional<CameraPath> camera;  // of view metrics; the meshes' unit
};

// In words, shares of the radius in per cent: "size 3.5 %", "max-error 0.5 % + exact gap". Without commas, for csv.
std::string labelOf(const Threshold& threshold, double radius);

// One ladder for all scenes: exact, s0 from 28 to 0.035 % of the radius, certified errors from 10 to 0.02 %; then three
// of them with an exact gap besides.
std::vector<Threshold> thresholdLadder();
// The ladder, and after it the caller's own setting unless it is there already.
std::vector<Threshold> thresholdLadder(const std::optional<Threshold>& own, double radius);
}  // namespace clod::demo
