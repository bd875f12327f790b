// SPDX-License-Identifier: GPL-3.0-or-later
// How tests of mechanisms run a scene: its models in a quarter of their triangles, exact, quiet.
#pragma once
#include "demos/runner/SceneModels.h"
#include "demos/scenes/SceneDefinition.h"
#include "tests/demos/KeptHierarchies.h"

namespace clod::demo
{
inline constexpr double kResolution = 0.25;

inline SceneSettings settingsOf(const SceneInfo& scene, double resolution = kResolution)
{
	SceneSettings settings;
	settings.models = buildModels(scene, {resolution, false}, test::keptHierarchies());
	settings.metric = ContactMetric::exactly();
	settings.dt = scene.dt;
	settings.printsWarnings = false;
	return settings;
}
}  // namespace clod::demo
