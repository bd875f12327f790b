// SPDX-License-Identifier: Zlib
// clod-bench replay: one query a recorded pose.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>

#include "demos/cli/Progress.h"
#include "demos/runner/Commands.h"
#include "demos/runner/DispatchBench.h"
#include "demos/runner/Replay.h"
#include "demos/runner/Selection.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
using cli::ExitCode;
using cli::Failure;

constexpr double kDefaultTolerance = 0.01;  // share of the smaller radius

struct ReplayCommandOptions
{
	cli::CommonOptions common;
	CacheOptions cache;
	Selection selection;
	std::string a, b, poses, csv, peer;
	std::optional<cli::Length> tolerance;
	bool distance = false;
	int repeat = 1;
	double dt = 1.0 / 240;
};

cli::Length toleranceOf(const ReplayCommandOptions& options)
{
	return options.tolerance ? *options.tolerance : cli::Length{kDefaultTolerance, true, "1%"};
}

Settings settingsOf(const ReplayCommandOptions& options, const Hierarchy& a, const Hierarchy& b)
{
	const double radius = smallerRadius(a, b);
	Settings settings;
	settings.metric = toMetric(options.selection, radius);
	settings.tolerance = toleranceOf(options).inMeshUnit(radius);
	settings.distance = options.distance;
	settings.paper = options.selection.paper;
	if (const std::string problem = settingsError(a, b, settings); !problem.empty())
		throw Failure(ExitCode::usage, problem);
	return settings;
}

void print(const ReplayCommandOptions& options, const Settings& settings, double radius,
		   const nlohmann::ordered_json& report)
{
	if (!options.common.textOnStdout()) return;
	fmt::print("selection  {}\n", describe(options.selection, radius));
	fmt::print("tolerance  {}{}\n", cli::describe(toleranceOf(options), radius),
			   settings.distance ? ", signed gap at any separation" : "");
	fmt::print("{:<22}{:>8}{:>12}{:>12}{:>12}{:>10}\n", "rows", "count", "query us", "p95 us", "tests", "contacts");
	for (const auto& [name, figures] : report["summary"].items())
	{
		if (figures["rows"] == 0) continue;
		fmt::print("{:<22}{:>8}{:>12.1f}{:>12.1f}{:>12.0f}{:>10.0f}\n", name, figures["rows"].get<std::size_t>(),
				   figures["query_us"]["median"].get<double>(), figures["query_us"]["p95"].get<double>(),
				   figures["hull_tests"]["median"].get<double>(), figures["contacts"]["median"].get<double>());
	}
}

void runReplay(const ReplayCommandOptions& options)
{
	Result<std::vector<PoseRow>> poses = readPoses(options.poses);
	if (!poses) throw Failure(ExitCode::badInput, poses.error());
	CacheOptions cacheOptions = options.cache;
	cacheOptions.quiet = options.common.quiet;
	HierarchyCache cache(cacheOptions);
	const HierarchyPointer a = cache.open(options.a, options.selection.paper);
	const HierarchyPointer b = cache.open(options.b, options.selection.paper);
	const double radius = smallerRadius(*a, *b);
	const Settings settings = settingsOf(options, *a, *b);
	cli::Progress progress(options.common.quiet);
	const auto rows = replay(*a, *b, poses.value(), {settings, options.repeat, options.selection.fresh, options.dt},
							 [&](double fraction) { progress.update("replay", fraction); });
	nlohmann::ordered_json report = startReport("replay");
	report["models"] = {describeHierarchy(*a, options.a), describeHierarchy(*b, options.b)};
	report["poses"] = {
		{"file", options.poses}, {"rows", rows.size()}, {"trajectory_hash", trajectoryHash(poses.value())}};
	report["selection"] = toJson(options.selection, radius);
	report["tolerance"] = settings.tolerance;
	report["distance"] = settings.distance;
	report["repeat"] = options.repeat;
	report["moving_speed_radii_per_s"] = kMovingSpeed;
	report["summary"] = summarize(rows, settings.tolerance);
	if (!options.peer.empty())
		report["peer"] =
			comparePeer(a, b, poses.value(), rows, {settings, options.repeat, options.selection.fresh, options.dt});
	progress.finish();
	if (options.csv != "-") print(options, settings, radius, report);
	writeText(options.csv, formatReplay(rows));
	if (!options.peer.empty() && options.common.textOnStdout() && options.csv != "-") printPeer(report["peer"]);
	writeReport(options.common.json, report);
}
}  // namespace

void addReplayCommand(CLI::App& program)
{
	auto options = std::make_shared<ReplayCommandOptions>();
	CLI::App* command = program.add_subcommand("replay", "Query two models at recorded poses, without dynamics");
	command->footer("Example: clod-bench replay cup.clod spoon.clod poses.csv --size 3.5 --repeat 3 --csv rows.csv");
	command->add_option("A", options->a, "Body A: a .clod file or a mesh (built, and cached)")->required();
	command->add_option("B", options->b, "Body B")->required();
	command->add_option("POSES", options->poses, "Recorded poses, POSES.csv")->required();
	cli::addLength(*command, "--tolerance", options->tolerance,
				   "Report contacts up to this gap (default 1% of the smaller radius)");
	command->add_flag("--distance", options->distance, "The signed gap at any separation");
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
