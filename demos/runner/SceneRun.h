// SPDX-License-Identifier: Zlib
// Runs a scene step by step and keeps a row a step: the scene's own state, and a query at the recorded pose.
#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "demos/runner/Replay.h"
#include "demos/scenes/Scene.h"

namespace clod::demo
{
struct SceneRow
{
	SceneState state;
	ReplayRow query;  // at state.poses, with the scene's tolerance and the run's metric
};

struct SceneRunOptions
{
	SceneSettings scene;
	double tolerance = 0;
	int steps = 0;
	bool fresh = false;
};

// Throws cli::Failure (1) when a pose or a velocity stops being finite.
std::vector<SceneRow> runScene(Scene& scene, const SceneRunOptions& options,
							   const std::function<void(double)>& progress);

std::vector<PoseRow> posesOf(const std::vector<SceneRow>& rows);
std::string formatSceneRows(const std::vector<SceneRow>& rows);
// Shares of rows in contact, moving and at rest, speeds at the end, times, trajectory_hash, warnings.
nlohmann::ordered_json summarizeScene(const std::vector<SceneRow>& rows, double tolerance);
}  // namespace clod::demo
