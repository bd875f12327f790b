// SPDX-License-Identifier: Zlib
// clod-bench scaling: query time, front and memory as the models of a scene grow.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "cli/Progress.h"
#include "demos/runner/Commands.h"
#include "demos/runner/Replay.h"
#include "demos/runner/ScalingRuns.h"
#include "demos/runner/SceneModels.h"
#include "demos/runner/SceneRun.h"

namespace clod::demo
{
namespace
{
using cli::ExitCode;
using cli::Failure;

struct ScalingCommandOptions
{
	cli::CommonOptions common;
	CacheOptions cache;
	std::string scene = "spoon-cup", directory;
	std::vector<double> resolutions = {0.0625, 0.25, 1};
	int steps = 0, repeat = 2;
};

const SceneInfo& pairScene(const std::string& name)
{
	const SceneInfo& info = sceneNamed(name);
	if (!info.isPair()) throw Failure(ExitCode::usage, "scaling takes a scene of two bodies; " + name + " has more");
	return info;
}

// Thresholds are of the finest models' radius, for all.
std::vector<ScalingSelection> selectionsOf(double radius)
{
	std::vector<ScalingSelection> selections(3);
	selections[0] = {"exact", ContactMetric::exactly()};
	selections[1].name = "max-error 0.1 %";
	selections[1].metric.maxError = 0.001 * radius;
	selections[2].name = "size 3.5 %";
	selections[2].metric.weightedDeviation = 0.035 * radius;
	return selections;
}

void runScaling(const ScalingCommandOptions& options)
{
	const SceneInfo& info = pairScene(options.scene);
	makeDirectory(options.directory);
	HierarchyCache cache(options.cache, options.common.quiet);
	cli::Progress progress(options.common.quiet);
	std::vector<double> resolutions = options.resolutions;
	std::sort(resolutions.begin(), resolutions.end());
	std::vector<ScaledPair> pairs;
	SceneRunOptions finest;
	finest.info = info;
	for (const double resolution : resolutions)
	{
		const int before = cache.built();
		const auto start = std::chrono::steady_clock::now();
		finest.scene.models = buildModels(info, {resolution, false}, cache);
		const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
		pairs.push_back({resolution, finest.scene.models[info.bodies[0].model],
						 finest.scene.models[info.bodies[1].model], cache.built() > before ? seconds : std::nan("")});
	}
	finest.scene.metric = ContactMetric::exactly();
	finest.scene.dt = info.dt;
	finest.steps = options.steps > 0 ? options.steps : info.steps;
	const std::vector<PoseRow> poses =
		simulatePoses(finest, [&](double fraction) { progress.update("exact simulation, finest", fraction); });
	const double radius = smallestRadius(finest.scene.models);
	const nlohmann::ordered_json selections =
		measureScaling(pairs, poses, selectionsOf(radius), {info.tolerance, info.dt, options.repeat},
					   [&](double fraction) { progress.update("replays", fraction); });
	progress.finish();
	if (selections.empty())
		throw Failure(ExitCode::badInput, "no row of " + info.name + " moves and touches at every resolution");
	nlohmann::ordered_json report = startReport("scaling");
	report["scene"] = info.name;
	report["radius"] = radius;
	report["tolerance"] = info.tolerance;
	report["selections"] = selections;
	const std::string base = options.directory + "/scaling", table = formatScalingTable(selections);
	writeText(base + ".csv", formatScalingCsv(selections));
	writeText(base + ".txt", table);
	writeReport(base + ".json", report);
	writeReport(options.common.json, report);
	const bool plotted = plotScaling(selections, info.name + ": the same poses, finer and finer meshes", base + ".png");
	if (!options.common.textOnStdout()) return;
	fmt::print("{}wrote {}.csv, .txt, .json{}\n", table, base,
			   plotted ? ", .png" : " (no plot: gnuplot is not installed)");
}
}  // namespace

void addScalingCommand(CLI::App& program)
{
	auto options = std::make_shared<ScalingCommandOptions>();
	CLI::App* command = program.add_subcommand(
		"scaling", "Query time, front, levels, memory and build time as the models of a scene grow");
	command->footer(
		"Example: clod-bench scaling -o out/scaling\n"
		"         clod-bench scaling bolt-nut --resolutions 0.25,1,4 -o out/scaling-bolt");
	command->add_option("SCENE", options->scene, "A scene of two bodies")->capture_default_str();
	command->add_option("-o", options->directory, "Directory for scaling.csv, .txt, .json and .png")->required();
	command->add_option("--resolutions", options->resolutions, "Triangles, as shares of the scene's own counts")
		->delimiter(',')
		->type_name("SHARE,...")
		->check(between(1e-4, 1e3))
		->capture_default_str();
	command->add_option("--steps", options->steps, "Steps of the recorded run (default: the scene's)")
		->type_name("N")
		->check(CLI::Range(1, 10'000'000));
	command->add_option("--repeat", options->repeat, "Whole passes; a row keeps its least time")
		->type_name("N")
		->check(CLI::Range(1, 1000))
		->capture_default_str();
	addCache(*command, options->cache);
	cli::addQuiet(*command, options->common);
	cli::addJson(*command, options->common);
	command->callback([options] { runScaling(*options); });
}
}  // namespace clod::demo
