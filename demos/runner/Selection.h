// SPDX-License-Identifier: Zlib
// The selection flags that run, replay, tradeoff and budget share: how coarse a contact may be answered.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "clod/query/ContactMetric.h"
#include "clod/query/Query.h"
#include "cli/Length.h"
#include "demos/render/Renderer.h"
#include "demos/scenes/CameraPath.h"

namespace CLI
{
class App;
}

namespace clod::demo
{
struct Selection
{
	bool exact = false, paper = false, fresh = false;
	std::optional<cli::Length> s0, size, maxError, velocityFloor;
	std::optional<double> velocity, view;  // k; pixels
	std::optional<Camera> camera;          // the frames' too
	std::optional<Camera> cameraTo;        // where it has gone by the last step
	std::string combine = "strict";
	Budget budget;  // of a query in replay and tradeoff, of a step in run
	bool hasMetric() const { return exact || s0 || size || maxError || velocity || view; }
	bool hasQueryOnly() const { return paper || fresh; }  // a simulation and a dispatch have neither
};

// Where nothing is selected: certified error, as a share of the radius.
inline constexpr double kDefaultMaxError = 0.005;

// View metrics count pixels of a picture this high, as frames are.
inline constexpr int kViewImageHeight = 720;

// Adds --exact --s0 --size --velocity --velocity-floor --view --camera --camera-to --max-error --combine --budget-tests
// --budget-us
// --paper --fresh.
void addSelection(CLI::App& command, Selection& selection);

// Usage errors (2) of a command that would otherwise ignore a flag.
void refuseUnusedCamera(const Selection& selection);       // one that nothing is seen from
void refuseClock(const Selection& selection, int repeat);  // --budget-us in passes that have to answer the same

// The metric, and for a pair whose smaller bounding radius is `radius` the same in words.
ContactMetric toMetric(const Selection& selection);
// What the view metric measures by in a run of so many steps; empty without a camera. The near plane is at a hundredth
// of the way to the target.
std::optional<CameraPath> toCameraPath(const Selection& selection, std::int64_t steps);
std::string describe(const Selection& selection, double radius);
// The same of meshes in metres, for pictures (MetricLength.h).
std::string describeMetric(const Selection& selection, double radius);
nlohmann::ordered_json toJson(const Selection& selection, double radius);
}  // namespace clod::demo
