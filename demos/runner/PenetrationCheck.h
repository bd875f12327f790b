// SPDX-License-Identifier: Zlib
// A run's interpenetration, measured on the full meshes by independent code, against what its selection allows.
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "demos/runner/Penetration.h"
#include "demos/runner/SceneRun.h"

namespace clod::demo
{
// Interpenetration that an exact run may show, as a share of the thinner wall.
inline constexpr double kPenetrationShare = 0.01;

struct PenetrationCheck
{
	double deepest = 0;  // over all steps and pairs, and where that was
	PoseRow where;
	double bound = 0;  // the largest that an answer certified
	double limit = 0;  // kPenetrationShare of the thinner wall and, unless the run was exact, the bound
	bool holds() const { return deepest <= limit; }
};

// `meshes`: one for each of the scene's models. Each row is told the deepest so far.
PenetrationCheck checkPenetration(const SceneRunOptions& run, const std::vector<Surface>& meshes,
								  std::vector<SceneRow>& rows, const std::function<void(double)>& progress);
nlohmann::ordered_json toJson(const PenetrationCheck& check, const SceneInfo& info);
}  // namespace clod::demo
