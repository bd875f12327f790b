// SPDX-License-Identifier: Zlib
// clod-bench replay: one query a recorded pose.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <memory>
#include <optional>

#include "cli/MeshPath.h"
#include "cli/Progress.h"
#include "demos/runner/Commands.h"
#include "demos/runner/DispatchBench.h"
#include "demos/runner/PairSubject.h"
#include "demos/runner/Replay.h"
#include "demos/runner/SceneModels.h"
#include "demos/runner/Selection.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
using cli::ExitCode;
using cli::Failure;

struct ReplayCommandOptions
{
	cli::CommonOptions common;
	CacheOptions cache;
	Selection selection;
	std::string a, b, poses, csv, peer;  // without poses, a is a scene and b its recorded poses
	double resolution = 1;
	std::optional<cli::Length> tolerance, gapError;
	bool distance = false;
	int repeat = 1;
	double dt = 1.0 / 240;
};

// What is replayed: two models, or all bodies of a scene.
struct Subject
{
	const SceneInfo* scene = nullptr;
	std::vector<HierarchyPointer> models;
	std::vector<std::string> names;  // of the models
	Bodies bodies;
	std::string posesFile;
};

Subject openSubject(const ReplayCommandOptions& options, HierarchyCache& cache)
{
	Subject subject;
	subject.scene = options.poses.empty() ? findScene(options.a) : nullptr;
	if (!subject.scene)
	{
		if (options.poses.empty())
			throw Failure(ExitCode::usage, "POSES is missing, and '" + options.a + "' is not a scene");
		if (options.resolution != 1) throw Failure(ExitCode::usage, "--resolution is for scenes, not for given models");
		subject.names = {options.a, options.b};
		for (const std::string& name : subject.names)
			subject.models.push_back(cache.open(name, {options.selection.paper}));
		subject.bodies = {subject.models[0].get(), subject.models[1].get()};
		subject.posesFile = options.poses;
		return subject;
	}
	subject.models = buildModels(*subject.scene, {options.resolution, options.selection.paper}, cache);
	for (const SceneModel& model : subject.scene->models) subject.names.push_back(model.name);
	subject.bodies = bodiesOf(*subject.scene, subject.models);
	subject.posesFile = options.b;
	return subject;
}

cli::Length toleranceOf(const ReplayCommandOptions& options, const Subject& subject)
{
	if (options.tolerance) return *options.tolerance;
	if (!subject.scene) return {kDefaultTolerance, true, "1%"};
	return {subject.scene->tolerance, false, fmt::format("{:.4g}", subject.scene->tolerance)};
}

ReplayOptions replayOptions(const ReplayCommandOptions& options, const Subject& subject, std::int64_t lastStep)
{
	ReplayOptions result;
	result.metric = toMetric(options.selection);
	result.camera = toCameraPath(options.selection, lastStep);
	result.budget = options.selection.budget;
	result.tolerance = toleranceOf(options, subject);
	result.distance = options.distance;
	result.gapError = options.gapError;
	result.paper = options.selection.paper;
	result.repeat = options.repeat;
	result.fresh = options.selection.fresh;
	result.dt = options.dt;
	if (const std::string problem = optionsError(result, subject.bodies); !problem.empty())
		throw Failure(ExitCode::usage, problem);
	return result;
}

void print(const ReplayCommandOptions& options, const Subject& subject, const nlohmann::ordered_json& report)
{
	if (!options.common.textOnStdout()) return;
	const double radius = smallestRadius(subject.models);
	fmt::print("selection  {}\n", describe(options.selection, radius));
	fmt::print("tolerance  {}{}\n", cli::describe(toleranceOf(options, subject), radius),
			   options.distance ? ", signed gap at any separation" : "");
	if (options.gapError) fmt::print("gap error  at most {}\n", cli::describe(*options.gapError, radius));
	fmt::print("{:<22}{:>8}{:>12}{:>12}{:>12}{:>10}\n", "rows", "count", "query us", "p95 us", "tests", "contacts");
	for (const auto& [name, figures] : report["summary"].items())
	{
		if (figures["rows"] == 0) continue;
		fmt::print("{:<22}{:>8}{:>12.1f}{:>12.1f}{:>12.0f}{:>10.0f}\n", name, figures["rows"].get<std::size_t>(),
				   figures["query_us"]["median"].get<double>(), figures["query_us"]["p95"].get<double>(),
				   figures["hull_tests"]["median"].get<double>(), figures["contacts"]["median"].get<double>());
	}
}

// All rows, and of a scene of many bodies the sums of every step.
nlohmann::ordered_json summarizeReplay(const Subject& subject, const std::vector<ReplayRow>& rows, double tolerance)
{
	nlohmann::ordered_json summary = summarize(rows, tolerance);
	if (subject.bodies.size() <= 2) return summary;
	const nlohmann::ordered_json steps = summarize(sumsByStep(rows, tolerance), tolerance);
	for (const auto& [name, figures] : steps.items()) summary["steps_" + name] = figures;
	return summary;
}

// Before anything is built.
void checkUsage(const ReplayCommandOptions& options)
{
	cli::requireWritable({options.csv, options.common.json},
						 {cli::meshPath(options.a).file, cli::meshPath(options.b).file, options.poses});
	refuseUnusedCamera(options.selection);
	refuseClock(options.selection, options.repeat);
	if (options.peer.empty()) return;
	if (options.selection.hasQueryOnly())
		throw Failure(ExitCode::usage, "--paper and --fresh are of queries: the dispatches of --peer have neither");
}

void runReplay(const ReplayCommandOptions& options)
{
	checkUsage(options);
	HierarchyCache cache(options.cache, options.common.quiet);
	const Subject subject = openSubject(options, cache);
	if (!options.peer.empty() && subject.bodies.size() > 2)
		throw Failure(ExitCode::usage, "--peer compares two bodies; " + options.a + " has more");
	Result<std::vector<PoseRow>> poses = readPoses(subject.posesFile, subject.bodies.size());
	if (!poses) throw Failure(ExitCode::badInput, poses.error());
	const ReplayOptions asked = replayOptions(options, subject, poses.value().empty() ? 0 : poses.value().back().step);
	const double radius = smallestRadius(subject.models), tolerance = toleranceOf(options, subject).inMeshUnit(radius);
	cli::Progress progress(options.common.quiet);
	const auto rows =
		replay(subject.bodies, poses.value(), asked, [&](double fraction) { progress.update("replay", fraction); });
	nlohmann::ordered_json report = startReport("replay");
	for (std::size_t i = 0; i < subject.models.size(); ++i)
		report["models"].push_back(describeHierarchy(*subject.models[i], subject.names[i]));
	report["poses"] = {
		{"file", subject.posesFile}, {"rows", rows.size()}, {"trajectory_hash", trajectoryHash(poses.value())}};
	report["selection"] = toJson(options.selection, radius);
	report["tolerance"] = tolerance;
	report["distance"] = options.distance;
	report["gap_error"] = options.gapError ? nlohmann::ordered_json(options.gapError->inMeshUnit(radius))
										   : nlohmann::ordered_json(nullptr);
	report["repeat"] = options.repeat;
	report["moving_speed_radii_per_s"] = kMovingSpeed;
	report["summary"] = summarizeReplay(subject, rows, tolerance);
	if (!options.peer.empty())
		report["peer"] =
			comparePeer(subject.models[subject.scene ? subject.scene->bodies[0].model : 0],
						subject.models[subject.scene ? subject.scene->bodies[1].model : 1], poses.value(), rows, asked);
	progress.finish();
	if (options.csv != "-") print(options, subject, report);
	writeText(options.csv, formatReplay(rows));
	if (!options.peer.empty() && options.common.textOnStdout() && options.csv != "-") printPeer(report["peer"]);
	writeReport(options.common.json, report);
}
}  // namespace

void addReplayCommand(CLI::App& program)
{
	auto options = std::make_shared<ReplayCommandOptions>();
	CLI::App* command = program.add_subcommand("replay", "Query two models at recorded poses, without dynamics");
	command->footer(
		"Example: clod-bench replay cup.clod spoon.clod poses.csv --size 3.5 --repeat 3 --csv rows.csv\n"
		"A scene instead of A and B replays all its bodies: clod-bench replay numbers-bowl poses.csv --size 3.5");
	command->add_option("A", options->a, "Body A: a .clod file or a mesh (built, and cached); or a scene")->required();
	command->add_option("B", options->b, "Body B; after a scene, its recorded poses")->required();
	command->add_option("POSES", options->poses, "Recorded poses, POSES.csv");
	addResolution(*command, options->resolution);
	cli::addLength(*command, "--tolerance", options->tolerance,
				   "Report contacts up to this gap (default 1% of the smaller radius; of a scene, its own)");
	command->add_flag("--distance", options->distance, "The signed gap at any separation");
	cli::addLength(*command, "--gap-error", options->gapError,
				   "Know the gap within this, whatever level the contacts are of; 0 is exact");
	command->add_option("--repeat", options->repeat, "Whole passes; a row keeps its least time")
		->type_name("N")
		->check(CLI::Range(1, 1000))
		->capture_default_str();
	command->add_option("--dt", options->dt, "Seconds between rows, for their speeds")
		->type_name("SECONDS")
		->check(between(1e-9, 1e9));
	cli::addChoice(*command, "--peer", options->peer, {"gimpact"},
				   "Time Bullet's own shape on the same meshes and poses in the same run");
	command->add_option("--csv", options->csv, "A row a pose; - is stdout")->type_name("FILE");
	addSelection(*command, options->selection);
	addCache(*command, options->cache);
	cli::addQuiet(*command, options->common);
	cli::addJson(*command, options->common);
	command->callback([options] { runReplay(*options); });
}
}  // namespace clod::demo
