// SPDX-License-Identifier: Zlib
// The frames of a run, painted after it from its recorded poses: the query is a pure function of them.
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "demos/runner/Frames.h"
#include "demos/runner/SceneRun.h"

namespace CLI
{
class App;
}

namespace clod::demo
{
struct SceneFrameOptions
{
	std::string directory;  // empty: no frames
	int every = 0;          // steps between frames; 0: see frameEvery
	bool compare = false;   // exact beside the selection, at the same poses
};

// --frames, --frame-every, --compare.
void addFrames(CLI::App& command, SceneFrameOptions& options);

struct FinishedRun
{
	const std::vector<SceneRow>& rows;
	const SceneRunOptions& options;
	std::string selection;  // in words
};

// Writes the frames, the contact sheet and the film; value: what was written, for the report.
nlohmann::ordered_json paintScene(const SceneFrameOptions& options, FrameSubject subject, const FinishedRun& run,
								  const std::function<void(double)>& progress);
}  // namespace clod::demo
