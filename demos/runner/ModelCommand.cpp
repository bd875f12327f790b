// SPDX-License-Identifier: Zlib
// clod-bench model, clod-bench list, and what the commands share.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <filesystem>

#include "cli/Files.h"
#include "cli/Progress.h"
#include "cli/Suggestion.h"
#include "demos/models/Models.h"
#include "demos/runner/Commands.h"
#include "demos/runner/Statistics.h"
#include "demos/scenes/Scene.h"

namespace clod::demo
{
namespace
{
using cli::ExitCode;
using cli::Failure;

constexpr std::size_t kLargestModel = 100'000'000;
constexpr int kSchema = 1;

struct ModelOptions
{
	cli::CommonOptions common;
	std::string name, output;
	std::size_t triangles = 0;
};

std::vector<std::string> allModels()
{
	std::vector<std::string> names = modelNames();
	names.insert(names.end(), testShapeNames().begin(), testShapeNames().end());
	return names;
}

ModelMesh makeOrFail(const std::string& name, std::size_t triangles)
{
	Result<ModelMesh> mesh = makeModel(name, triangles);
	if (!mesh) throw Failure(ExitCode::usage, mesh.error());
	return std::move(mesh.value());
}

void runModel(const ModelOptions& options)
{
	if (std::filesystem::path(options.output).extension() != ".obj")
		throw Failure(ExitCode::usage, options.output + " does not end in .obj");
	const ModelMesh mesh = makeOrFail(options.name, options.triangles);
	const std::string text = toObj(mesh);
	writeText(options.output, text);
	if (options.common.textOnStdout() && !options.common.quiet)
		fmt::print("{}: {} triangles, {} vertices, {} bytes in {}\n", options.name, mesh.triangles.size(),
				   mesh.vertices.size(), text.size(), options.output);
	nlohmann::ordered_json report = startReport("model");
	report["model"] = options.name;
	report["requested_triangles"] = options.triangles;
	report["triangles"] = mesh.triangles.size();
	report["vertices"] = mesh.vertices.size();
	report["output"] = options.output;
	report["bytes"] = text.size();
	writeReport(options.common.json, report);
}

void runList(const cli::CommonOptions& common)
{
	nlohmann::ordered_json report = startReport("list");
	for (const SceneInfo& scene : scenes())
	{
		if (common.textOnStdout()) fmt::print("{:<14} {}\n", scene.name, scene.summary);
		nlohmann::ordered_json models = nlohmann::ordered_json::array(), names = nlohmann::ordered_json::array();
		for (const SceneModel& model : scene.models) models.push_back(model.name);
		for (const SceneBody& body : scene.bodies) names.push_back(body.name);
		report["scenes"].push_back({{"name", scene.name},
									{"summary", scene.summary},
									{"steps", scene.steps},
									{"dt", scene.dt},
									{"models", models},
									{"bodies", scene.bodies.size()},
									{"body_names", names}});
	}
	writeReport(common.json, report);
}
}  // namespace

void addModelCommand(CLI::App& program)
{
	auto options = std::make_shared<ModelOptions>();
	CLI::App* command = program.add_subcommand("model", "Write a benchmark model as a Wavefront OBJ file");
	std::string models;
	for (const std::string& name : allModels()) models += (models.empty() ? "" : ", ") + name;
	command->footer("Models: " + models + ".\nExample: clod-bench model cup --triangles 6400 -o cup.obj");
	const auto check = [](const std::string& word) -> std::string
	{
		if (paperTriangleCount(word) > 0) return {};
		return fmt::format("unknown model '{}'{}", word, cli::didYouMean(word, allModels()));
	};
	command->add_option("name", options->name, "Which model")->type_name("NAME")->required()->check(check);
	command->add_option("--triangles", options->triangles, "About how many triangles (default: the paper's Table 1)")
		->type_name("N")
		->check(CLI::Range(std::size_t(1), kLargestModel));
	cli::addOutput(*command, options->output, "OUT.obj", "The file to write");
	cli::addQuiet(*command, options->common);
	cli::addJson(*command, options->common);
	command->callback([options] { runModel(*options); });
}

void addListCommand(CLI::App& program)
{
	auto common = std::make_shared<cli::CommonOptions>();
	CLI::App* command = program.add_subcommand("list", "List the scenes");
	command->footer("Example: clod-bench list");
	cli::addJson(*command, *common);
	cli::addQuiet(*command, *common);
	command->callback([common] { runList(*common); });
}

void addCache(CLI::App& command, CacheOptions& options)
{
	command
		.add_option("--cache-dir", options.directory,
					"Where built hierarchies are kept (default $XDG_CACHE_HOME/clod, else ~/.cache/clod)")
		->type_name("DIR");
	command.add_flag_callback(
		"--no-cache", [&options] { options.enabled = false; }, "Build anew and keep nothing");
}

void addResolution(CLI::App& command, double& share)
{
	command.add_option("--resolution", share, "Triangles of a scene's models, as a share of the paper's counts")
		->type_name("SHARE")
		->check(between(0.001, 1000.0))
		->capture_default_str();
}

CLI::Validator between(double low, double high)
{
	const auto check = [low, high](std::string& text) -> std::string
	{
		double value = 0;
		const bool isInside = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
		return isInside ? std::string() : fmt::format("'{}' is not between {} and {}", text, low, high);
	};
	return CLI::Validator(check, fmt::format("in [{} - {}]", low, high), "between");
}

MeshSource meshSource(const std::string& name, const ModelMesh& mesh)
{
	const std::string text = toObj(mesh);
	const auto* const first = reinterpret_cast<const std::byte*>(text.data());
	return {fmt::format("{} ({} triangles)", name, mesh.triangles.size()), ".obj", {first, first + text.size()}, ""};
}

MeshSource modelSource(const std::string& name, std::size_t triangles)
{
	return meshSource(name, makeOrFail(name, triangles));
}

nlohmann::ordered_json startReport(const std::string& command)
{
	return {{"schema", kSchema}, {"program", "clod-bench"}, {"command", command}, {"machine", machine()}};
}

nlohmann::ordered_json describeHierarchy(const Hierarchy& hierarchy, const std::string& name)
{
	const Asset& asset = hierarchy.asset();
	return {{"name", name},
			{"triangles", asset.triangleCount},
			{"patches", hierarchy.levels()[0].nodeCount},
			{"levels", hierarchy.coarsestClodLevel() + 1},
			{"radius", asset.radius},
			{"thinnest_wall", asset.thinnestWall},
			{"bytes", hierarchy.bytes().size()},
			{"paper", hierarchy.isPaperBuild()},
			{"hash", fmt::format("{:016x}", hierarchy.contentHash())}};
}

void writeReport(const std::string& path, const nlohmann::ordered_json& report)
{
	if (path.empty()) return;
	if (const std::string problem = cli::writeJson(path, report); !problem.empty())
		throw Failure(ExitCode::failure, problem);
}

void makeDirectory(const std::string& path)
{
	std::error_code failed;
	std::filesystem::create_directories(path, failed);
	if (failed) throw cli::Failure(cli::ExitCode::failure, "cannot create " + path + ": " + failed.message());
}

void writeText(const std::string& path, const std::string& text)
{
	if (path.empty()) return;
	if (path == "-")
	{
		if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
			throw Failure(ExitCode::failure, "cannot write standard output");
		return;
	}
	if (const std::string problem = cli::writeFile(path, text); !problem.empty())
		throw Failure(ExitCode::failure, problem);
}
}  // namespace clod::demo
