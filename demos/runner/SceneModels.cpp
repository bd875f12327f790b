// SPDX-License-Identifier: Zlib
#include "demos/runner/SceneModels.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "cli/Failure.h"
#include "cli/MeshPath.h"
#include "cli/Suggestion.h"
#include "demos/runner/Commands.h"
#include "demos/runner/InputSurface.h"

namespace clod::demo
{
std::string sceneError(const std::string& name)
{
	if (findScene(name)) return {};
	if (std::filesystem::is_regular_file(cli::meshPath(name).file))
		return fmt::format("'{0}' is no scene but a file; of meshes: `clod-bench try {0} -o trial`", cli::shellWord(name));
	std::vector<std::string> names;
	for (const SceneInfo& scene : scenes()) names.push_back(scene.name);
	return fmt::format("unknown scene '{}'{}; `clod-bench list` shows them", name, cli::didYouMean(name, names));
}

const SceneInfo& sceneNamed(const std::string& name)
{
	const std::string error = sceneError(name);
	if (!error.empty()) throw cli::Failure(cli::ExitCode::usage, error);
	return *findScene(name);
}

std::size_t trianglesOf(const std::string& model, double resolution)
{
	return std::max(smallestTriangleCount(model), std::size_t(double(paperTriangleCount(model)) * resolution));
}

ModelMesh meshOf(const SceneModel& model, const HierarchyPointer& hierarchy, const ModelDetail& detail)
{
	if (!model.file.empty()) return inputSurface(*hierarchy);
	Result<ModelMesh> mesh = makeModel(model.name, trianglesOf(model.name, detail.resolution));
	if (!mesh) throw cli::Failure(cli::ExitCode::failure, mesh.error());
	for (Vec3& vertex : mesh.value().vertices) vertex = model.scale * vertex;
	return std::move(mesh.value());
}

std::vector<HierarchyPointer> buildModels(const SceneInfo& scene, const ModelDetail& detail, HierarchyCache& cache)
{
	std::vector<HierarchyPointer> models;
	for (const SceneModel& model : scene.models)
	{
		const BuildOptions options{detail.paper, model.repair, model.scale};
		models.push_back(model.file.empty()
							 ? cache.build(modelSource(model.name, trianglesOf(model.name, detail.resolution)), options)
							 : cache.open(model.file, options));
	}
	return models;
}

std::vector<const Hierarchy*> bodiesOf(const SceneInfo& scene, const std::vector<HierarchyPointer>& models)
{
	std::vector<const Hierarchy*> bodies;
	for (const SceneBody& body : scene.bodies) bodies.push_back(models[body.model].get());
	return bodies;
}

double smallestRadius(const std::vector<HierarchyPointer>& models)
{
	double radius = models[0]->asset().radius;
	for (const HierarchyPointer& model : models) radius = std::min(radius, double(model->asset().radius));
	return radius;
}
}  // namespace clod::demo
