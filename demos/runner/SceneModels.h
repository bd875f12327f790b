// SPDX-License-Identifier: Zlib
// The models of a scene: meshes at a resolution, and their hierarchies.
#pragma once
#include <string>
#include <vector>

#include "demos/models/Models.h"
#include "demos/runner/HierarchyCache.h"
#include "demos/scenes/Scene.h"

namespace clod::demo
{
// Empty where there is a scene of that name, otherwise a sentence with the nearest one.
std::string sceneError(const std::string& name);
// Throws cli::Failure (2) with that sentence.
const SceneInfo& sceneNamed(const std::string& name);

// How a scene's benchmark models are made. Files are taken as they are.
struct ModelDetail
{
	double resolution = 1;  // triangles, as a share of the paper's counts
	bool paper = false;     // hierarchies built with --paper
};

// How many triangles of a benchmark model are asked for at a resolution.
std::size_t trianglesOf(const std::string& model, double resolution);
// The full mesh of a model; of a file, as its hierarchy keeps it.
ModelMesh meshOf(const SceneModel& model, const HierarchyPointer& hierarchy, const ModelDetail& detail);
// One hierarchy for each of the scene's models, built where the cache has none.
std::vector<HierarchyPointer> buildModels(const SceneInfo& scene, const ModelDetail& detail, HierarchyCache& cache);
// The model of each body.
std::vector<const Hierarchy*> bodiesOf(const SceneInfo& scene, const std::vector<HierarchyPointer>& models);
// Of the smallest model: what thresholds in per cent mean where it takes part.
double smallestRadius(const std::vector<HierarchyPointer>& models);
}  // namespace clod::demo
