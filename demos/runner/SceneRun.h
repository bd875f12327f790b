// SPDX-License-Identifier: Zlib
// Runs a scene step by step and keeps a row a step: the scene's own state, and a query of every pair at the recorded
// poses. A budget is shared by the pairs of a step's dispatch: there the row has what that did, and only the gap is of
// the queries.
#pragma once
#include <cmath>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "demos/runner/Replay.h"
#include "demos/scenes/Scene.h"

namespace clod::demo
{
struct SceneRow
{
	SceneState state;
	std::vector<ReplayRow> pairs;  // one for each of state.pairs, with the scene's tolerance and the run's metric
	double deepest = std::nan("");  // interpenetration of the full meshes up to here, in metres; where measured
	ReplayRow query;               // their sum, see sumOfPairs; under a budget with what the step's dispatch did
};

struct SceneRunOptions
{
	SceneInfo info;
	SceneSettings scene;
	bool paper = false, fresh = false;
	int steps = 0;
	Bodies bodies() const;
	ReplayOptions queries() const;  // without a budget: that is the step's
};

// Throws cli::Failure (1) when a pose or a velocity stops being finite.
std::vector<SceneRow> runScene(Scene& scene, const SceneRunOptions& options,
							   const std::function<void(double)>& progress);

// Only the poses, nothing asked besides.
std::vector<PoseRow> simulatePoses(const SceneRunOptions& options, const std::function<void(double)>& progress);

// Of every followed pair, in the order of the steps.
std::vector<PoseRow> posesOf(const SceneState& state);
std::vector<PoseRow> posesOf(const std::vector<SceneRow>& rows);
// Of the poses of all bodies after every step, whether they meet or not.
std::string trajectoryHash(const std::vector<SceneRow>& rows);
std::string formatSceneRows(const SceneInfo& info, const std::vector<SceneRow>& rows);
// Of the energy and of what the scene is told by: at the start, the end, and the extremes of all rows.
nlohmann::ordered_json summarizeEnergy(const SceneState& start, const std::vector<SceneRow>& rows);
nlohmann::ordered_json summarizeOutcome(const SceneInfo& info, const SceneState& start,
										const std::vector<SceneRow>& rows);
// Shares of rows in contact, moving and at rest, speeds at the end, times, trajectory_hash, warnings.
nlohmann::ordered_json summarizeScene(const std::vector<SceneRow>& rows, double tolerance);
}  // namespace clod::demo
