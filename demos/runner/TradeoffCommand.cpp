// SPDX-License-Identifier: Zlib
// clod-bench tradeoff: accuracy against time, ours at one ladder of thresholds and every peer, on the same poses in one
// run.
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "demos/cli/Length.h"
#include "demos/cli/Progress.h"
#include "demos/cli/Suggestion.h"
#include "demos/peers/Roster.h"
#include "demos/runner/Commands.h"
#include "demos/runner/Replay.h"
#include "demos/runner/SceneModels.h"
#include "demos/runner/SceneRun.h"
#include "demos/scenes/Scene.h"

namespace clod::demo
{
namespace
{
using cli::ExitCode;
using cli::Failure;

constexpr double kDefaultTolerance = 0.01;  // share of the smaller radius
constexpr double kBulletRadius = 5;         // bodies are scaled by a power of ten to about this radius for Bullet

struct TradeoffOptions
{
	cli::CommonOptions common;
	CacheOptions cache;
	std::vector<std::string> input;
	std::string directory, peers, peerDirectory, rows = "moving";
	std::optional<cli::Length> tolerance;
	double resolution = 1, dt = 0;
	int steps = 0, stride = 8, repeat = 3, decimations = 12;
};

// What is measured: two hierarchies at recorded poses.
struct Subject
{
	std::string title;
	RosterModels models;
	std::vector<PoseRow> poses;
	double tolerance = 0, dt = 0, worldScale = 0;
};

BuiltHierarchy buildModel(HierarchyCache& cache, const SceneModel& model, double resolution)
{
	if (!model.file.empty()) return {cache.open(model.file, false), std::nan("")};
	return buildTimed(cache, modelSource(model.name, trianglesOf(model.name, resolution)));
}

// Simulates the scene in exact mode: these are the poses that everybody is asked at.
Subject fromScene(const TradeoffOptions& options, const SceneInfo& info, HierarchyCache& cache, cli::Progress& progress)
{
	if (!info.isPair())
		throw Failure(ExitCode::usage,
					  "tradeoff compares two bodies; " + info.name + " has " + std::to_string(info.bodies.size()));
	SceneSettings settings;
	double seconds = 0;
	for (const SceneModel& model : info.models)
	{
		const BuiltHierarchy built = buildModel(cache, model, options.resolution);
		settings.models.push_back(built.hierarchy);
		seconds += built.seconds;
	}
	settings.metric = ContactMetric::exactly();
	settings.dt = options.dt > 0 ? options.dt : info.dt;
	const std::unique_ptr<Scene> scene = makeScene(info.name, settings);
	const HierarchyPointer &a = settings.models[info.bodies[0].model], &b = settings.models[info.bodies[1].model];
	Subject subject{info.name, {a, b, seconds}, {}, info.tolerance, settings.dt, info.worldScale};
	const int steps = options.steps > 0 ? options.steps : info.steps;
	for (int step = 0; step < steps; ++step)
	{
		scene->step();
		subject.poses.push_back(posesOf(scene->state()).front());
		progress.update("exact simulation", double(step + 1) / steps);
	}
	return subject;
}

Subject fromFiles(const TradeoffOptions& options, HierarchyCache& cache)
{
	Result<std::vector<PoseRow>> poses = readPoses(options.input[2]);
	if (!poses) throw Failure(ExitCode::badInput, poses.error());
	const HierarchyPointer a = cache.open(options.input[0], false), b = cache.open(options.input[1], false);
	const double radius = smallerRadius(*a, *b);
	Subject subject{options.input[0] + " and " + options.input[1],
					{a, b, std::nan("")},
					std::move(poses.value()),
					kDefaultTolerance * radius,
					options.dt > 0 ? options.dt : 1.0 / 240,
					std::pow(10.0, std::round(std::log10(kBulletRadius / radius)))};
	return subject;
}

Subject subjectOf(const TradeoffOptions& options, HierarchyCache& cache, cli::Progress& progress)
{
	if (options.input.size() == 1)
	{
		const SceneInfo* info = findScene(options.input[0]);
		std::vector<std::string> names;
		for (const SceneInfo& scene : scenes()) names.push_back(scene.name);
		if (!info)
			throw Failure(ExitCode::usage, fmt::format("unknown scene '{}'{}; `clod-bench list` shows them",
													   options.input[0], cli::didYouMean(options.input[0], names)));
		return fromScene(options, *info, cache, progress);
	}
	if (options.input.size() != 3)
		throw Failure(ExitCode::usage,
					  "tradeoff takes a scene, or A B POSES.csv; poses that nobody recorded are not "
					  "available in this version");
	return fromFiles(options, cache);
}

std::vector<std::string> familiesOf(const std::string& list)
{
	const std::vector<std::string> known(std::begin(kFamilies), std::end(kFamilies));
	std::vector<std::string> families;
	std::size_t start = 0;
	while (start < list.size())
	{
		const std::size_t end = std::min(list.find(',', start), list.size());
		const std::string word = list.substr(start, end - start);
		if (std::find(known.begin(), known.end(), word) == known.end())
			throw Failure(ExitCode::usage,
						  fmt::format("--methods: unknown method '{}'{}", word, cli::didYouMean(word, known)));
		families.push_back(word);
		start = end + 1;
	}
	return families;
}

void makeDirectory(const std::string& path)
{
	std::error_code failed;
	std::filesystem::create_directories(path, failed);
	if (failed) throw Failure(ExitCode::failure, "cannot create " + path + ": " + failed.message());
}

Roster rosterOf(const TradeoffOptions& options, const Subject& subject, HierarchyCache& cache, cli::Progress& progress)
{
	const PeerTools tools{options.peerDirectory.empty() ? defaultPeerDirectory() : options.peerDirectory};
	const Preparation preparation(tools, cache.directory().empty() ? "" : cache.directory() + "/peers");
	RosterOptions roster;
	roster.families = familiesOf(options.peers);
	roster.decimations = options.decimations;
	roster.frame = pairFrame(*subject.models.a, *subject.models.b, subject.worldScale, subject.tolerance);
	return makeRoster(subject.models, cache, preparation, roster,
					  [&](const std::string& phase, double fraction) { progress.update(phase, fraction); });
}

void write(const TradeoffOptions& options, const Subject& subject, const Tradeoff& tradeoff, const Roster& roster)
{
	const std::vector<ParetoRow> pareto = comparePareto(tradeoff.points, tradeoff.floor);
	const std::string folder = options.directory + "/";
	const std::string text = printable(tradeoff, pareto);
	nlohmann::ordered_json report = startReport("tradeoff");
	report["subject"] = subject.title;
	report["models"] = {describeHierarchy(*subject.models.a, "a"), describeHierarchy(*subject.models.b, "b")};
	report["poses"] = {{"rows", subject.poses.size()}, {"trajectory_hash", trajectoryHash(subject.poses)}};
	report["stride"] = options.stride;
	report["rows"] = options.rows;
	report["preparation"] = roster.preparation;
	report["tradeoff"] = toJson(tradeoff, pareto);
	writeText(folder + "tradeoff.csv", formatPoints(tradeoff));
	writeText(folder + "pareto.csv", formatPareto(tradeoff, pareto));
	writeText(folder + "tradeoff.txt", text);
	writeReport(folder + "tradeoff.json", report);
	writeReport(options.common.json, report);
	const std::string title =
		fmt::format("{}: error against time, {} rows, {} and {} triangles", subject.title, tradeoff.rows,
					subject.models.a->asset().triangleCount, subject.models.b->asset().triangleCount);
	const bool plotted = plot(tradeoff, title, folder + "tradeoff.png");
	if (!options.common.textOnStdout()) return;
	fmt::print("{}", text);
	fmt::print("wrote {}tradeoff.csv, pareto.csv, tradeoff.txt, tradeoff.json{}\n", folder,
			   plotted ? ", tradeoff.png" : " (no plot: gnuplot is not installed)");
}

void runTradeoff(const TradeoffOptions& options)
{
	familiesOf(options.peers);  // a typing error is told before anything is built
	CacheOptions cacheOptions = options.cache;
	cacheOptions.quiet = options.common.quiet;
	HierarchyCache cache(cacheOptions);
	cli::Progress progress(options.common.quiet);
	Subject subject = subjectOf(options, cache, progress);
	const double radius = smallerRadius(*subject.models.a, *subject.models.b);
	if (options.tolerance) subject.tolerance = options.tolerance->inMeshUnit(radius);
	if (!(subject.tolerance > 0)) throw Failure(ExitCode::usage, "--tolerance must be positive");
	makeDirectory(options.directory);

	const SampleRules rules{subject.tolerance, subject.dt, options.stride, options.rows == "contact"};
	const ExactSample sample = takeSample(subject.models.a, subject.models.b, subject.poses, rules,
										  [&](double fraction) { progress.update("exact answers", fraction); });
	if (sample.exact.empty())
		throw Failure(ExitCode::badInput, fmt::format("no row of {} is a {} contact row", subject.title, options.rows));
	Roster roster = rosterOf(options, subject, cache, progress);
	Tradeoff tradeoff;
	tradeoff.radius = radius;
	tradeoff.tolerance = subject.tolerance;

	tradeoff.floor = kRoundingShare * radius;
	tradeoff.leftOut = roster.leftOut;
	measure(tradeoff, roster.peers, sample, options.repeat,
			[&](double fraction) { progress.update("measuring", fraction); });
	progress.finish();
	write(options, subject, tradeoff, roster);
}
}  // namespace

void addTradeoffCommand(CLI::App& program)
{
	auto options = std::make_shared<TradeoffOptions>();
	CLI::App* command =
		program.add_subcommand("tradeoff", "Accuracy against time: ours and every peer at the same poses");
	command->footer(
		"Example: clod-bench tradeoff spoon-cup -o out/tradeoff\n"
		"         clod-bench tradeoff cup.clod spoon.clod poses.csv -o out/tradeoff --methods clod,coal-contacts\n"
		"scripts/peers sets up the peers that Bullet does not have (CoACD, V-HACD, Coal, decimation).");
	command->add_option("INPUT", options->input, "A scene, or A B POSES.csv")->required()->expected(1, 3);
	command->add_option("-o", options->directory, "Directory for tradeoff.csv, .txt, .json, .png and pareto.csv")
		->required();
	cli::addLength(*command, "--tolerance", options->tolerance,
				   "Contacts up to this gap (default: the scene's, else 1% of the smaller radius)");
	cli::addChoice(*command, "--rows", options->rows, {"moving", "contact"},
				   "Rows that touch and move, or all that touch");
	command->add_option("--stride", options->stride, "Every how many of those rows are measured")
		->type_name("N")
		->check(CLI::Range(1, 1'000'000))
		->capture_default_str();
	command->add_option("--repeat", options->repeat, "Whole passes; a row keeps its least time")
		->type_name("N")
		->check(CLI::Range(1, 1000))
		->capture_default_str();
	command->add_option("--methods", options->peers, "Only these, separated by commas")->type_name("LIST");
	command->add_option("--decimations", options->decimations, "Versions of each mesh for mesh peers, the full one too")
		->type_name("N")
		->check(CLI::Range(1, 100))
		->capture_default_str();
	command
		->add_option("--peers-dir", options->peerDirectory, "Where scripts/peers put its tools (default build/peers)")
		->type_name("DIR");
	addResolution(*command, options->resolution);
	command->add_option("--steps", options->steps, "Steps of a scene (default: the scene's)")
		->type_name("N")
		->check(CLI::Range(1, 10'000'000));
	command->add_option("--dt", options->dt, "Seconds between rows (default: the scene's, else 1/240)")
		->type_name("SECONDS")
		->check(between(1e-9, 1e9));
	addCache(*command, options->cache);
	cli::addQuiet(*command, options->common);
	cli::addJson(*command, options->common);
	command->callback([options] { runTradeoff(*options); });
}
}  // namespace clod::demo
