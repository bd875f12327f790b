// SPDX-License-Identifier: Zlib
// How a query's cost grows with the models: the same poses, the same selections, the same tolerance, meshes of more and
// more triangles.
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "clod/query/ContactMetric.h"
#include "demos/runner/HierarchyCache.h"
#include "demos/scenes/Poses.h"

namespace clod::demo
{
// A pair of models at one resolution.
struct ScaledPair
{
	double resolution = 1;  // share of the paper's triangle counts
	HierarchyPointer a, b;
	double buildSeconds = 0;  // NaN: they came from the cache
};

struct ScalingSelection
{
	std::string name;
	ContactMetric metric;  // lengths absolute: the same for every resolution
};

struct ScalingOptions
{
	double tolerance = 0, dt = 0;
	int repeat = 1;  // whole passes over everything; a row keeps its least time
};

// Replays the poses at every resolution under every selection, passes outermost. Measured are the moving rows that
// touch within the tolerance at every resolution. One element a selection: name, and sizes[] with triangles, bytes,
// build_seconds, loaded_bytes (of the levels that any of the rows asked), alike_bytes (of levels that err by no more
// than the first size's so asked: the same detail), query_us, front, contacts, finest_level and coarsest_level
// (medians) and growth (time over that of the first size).
nlohmann::ordered_json measureScaling(const std::vector<ScaledPair>& pairs, const std::vector<PoseRow>& poses,
									  const std::vector<ScalingSelection>& selections, const ScalingOptions& options,
									  const std::function<void(double)>& progress);
std::string formatScalingCsv(const nlohmann::ordered_json& selections);
std::string formatScalingTable(const nlohmann::ordered_json& selections);
// Time and front over the triangles of both bodies. False: gnuplot is not installed or failed.
bool plotScaling(const nlohmann::ordered_json& selections, const std::string& title, const std::string& path);
}  // namespace clod::demo
