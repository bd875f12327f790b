// SPDX-License-Identifier: Zlib
// clod-bench tradeoff: accuracy against time, ours at one ladder of thresholds and every peer, on the same poses in one
// run.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <memory>

#include "cli/Progress.h"
#include "cli/Suggestion.h"
#include "demos/peers/Roster.h"
#include "demos/runner/Commands.h"
#include "demos/runner/PairSubject.h"
#include "demos/runner/Replay.h"
#include "demos/runner/Selection.h"

namespace clod::demo
{
namespace
{
using cli::ExitCode;
using cli::Failure;

struct TradeoffOptions
{
	cli::CommonOptions common;
	CacheOptions cache;
	Selection selection;
	PairInput input;
	std::string directory, peers, peerDirectory, rows = "moving";
	int stride = 0, mostRows = int(kEnoughRows), repeat = 3, decimations = 12;
	double prepareSeconds = 300;
};

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
						  fmt::format("--methods: unknown method '{}'{}; there are {}", word,
									  cli::didYouMean(word, known), fmt::join(known, ", ")));
		families.push_back(word);
		start = end + 1;
	}
	return families;
}

// Before anything is built: what cannot be one more setting of our families.
void checkUsage(const TradeoffOptions& options)
{
	const Selection& selection = options.selection;
	const std::vector<std::string> families = familiesOf(options.peers);
	const auto isOfOurs = [](const std::string& family)
	{ return std::find(std::begin(kOurFamilies), std::end(kOurFamilies), family) != std::end(kOurFamilies); };
	const bool hasOurs = families.empty() || std::any_of(families.begin(), families.end(), isOfOurs);
	if (!hasOurs && (selection.hasMetric() || selection.budget.isLimited()))
		throw Failure(ExitCode::usage,
					  "a selection is one more setting of clod, clod-gap and clod-dispatch; --methods "
					  "names none of them");
	refuseUnusedCamera(selection);
	refuseClock(selection, options.repeat);
	if (selection.hasQueryOnly())
		throw Failure(ExitCode::usage,
					  "--paper and --fresh are for replay: tradeoff measures one build of the models, as a simulation "
					  "would find their caches");
}

Roster rosterOf(const TradeoffOptions& options, const PairSubject& subject, HierarchyCache& cache,
				cli::Progress& progress)
{
	const PeerTools tools{options.peerDirectory.empty() ? defaultPeerDirectory() : options.peerDirectory};
	const Preparation preparation(tools, cache.directory().empty() ? "" : cache.directory() + "/peers",
								  options.prepareSeconds);
	RosterOptions roster;
	roster.families = familiesOf(options.peers);
	roster.decimations = options.decimations;
	const std::int64_t lastStep = subject.poses.empty() ? 0 : subject.poses.back().step;
	roster.own = Threshold{"", toMetric(options.selection), kOff, options.selection.budget,
						   toCameraPath(options.selection, lastStep)};
	roster.frame = pairFrame(*subject.models.a, *subject.models.b, subject.worldScale, subject.tolerance);
	return makeRoster(subject.models, cache, preparation, roster,
					  [&](const std::string& phase, double fraction) { progress.update(phase, fraction); });
}

void write(const TradeoffOptions& options, const PairSubject& subject, const Tradeoff& tradeoff, const Roster& roster)
{
	const std::vector<ParetoRow> pareto = comparePareto(tradeoff.points, tradeoff.floor);
	const std::string folder = options.directory + "/";
	const std::string text = printable(tradeoff, pareto);
	nlohmann::ordered_json report = startReport("tradeoff");
	report["subject"] = subject.title;
	report["models"] = {describeHierarchy(*subject.models.a, "a"), describeHierarchy(*subject.models.b, "b")};
	report["poses"] = {{"rows", subject.poses.size()}, {"trajectory_hash", trajectoryHash(subject.poses)}};
	report["selection"] = toJson(options.selection, tradeoff.radius);
	report["stride"] = options.stride;
	report["most_rows"] = options.mostRows;
	report["rows"] = options.rows;
	report["preparation"] = roster.preparation;
	report["tradeoff"] = toJson(tradeoff, pareto);
	writeText(folder + "tradeoff.csv", formatPoints(tradeoff));
	writeText(folder + "pareto.csv", formatPareto(tradeoff, pareto));
	writeText(folder + "tradeoff.txt", text);
	writeReport(folder + "tradeoff.json", report);
	writeReport(options.common.json, report);
	const std::string title =
		fmt::format("{}: error against time, moving, {} rows, {} and {} triangles", subject.title, tradeoff.rows,
					subject.models.a->asset().triangleCount, subject.models.b->asset().triangleCount);
	const bool plotted = plot(tradeoff, title, folder + "tradeoff.png");
	if (!options.common.textOnStdout()) return;
	fmt::print("{}", text);
	fmt::print("wrote {}tradeoff.csv, pareto.csv, tradeoff.txt, tradeoff.json{}\n", folder,
			   plotted ? ", tradeoff.png" : " (no plot: gnuplot is not installed)");
}

void runTradeoff(const TradeoffOptions& options)
{
	checkUsage(options);
	makeDirectory(options.directory);
	cli::requireWritable({options.common.json, options.directory + "/tradeoff.json"});
	HierarchyCache cache(options.cache, options.common.quiet);
	cli::Progress progress(options.common.quiet);
	const PairSubject subject = pairSubject(options.input, cache, progress);
	const double radius = smallerRadius(*subject.models.a, *subject.models.b);

	const SampleRules rules{subject.tolerance, subject.clock, options.stride, options.mostRows,
							options.rows == "contact"};
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
		"         clod-bench tradeoff spoon-cup -o out/tradeoff --size 5\n"
		"A selection is measured as one more setting of clod, clod-gap and clod-dispatch.\n"
		"scripts/peers sets up the peers that Bullet does not have (CoACD, V-HACD, Coal, decimation).");
	addPairInput(*command, options->input);
	cli::addFolder(*command, options->directory, "tradeoff.csv, .txt, .json, .png and pareto.csv");
	cli::addChoice(*command, "--rows", options->rows, {"moving", "contact"},
				   "Rows that touch and move, or all that touch");
	command->add_option("--most-rows", options->mostRows, "So many of them, evenly; all where there are fewer")
		->type_name("N")
		->check(CLI::Range(1, 1'000'000))
		->capture_default_str();
	command
		->add_option("--stride", options->stride, "Every how many of those rows are measured, instead of --most-rows")
		->type_name("N")
		->check(CLI::Range(1, 1'000'000));
	command->add_option("--prepare-seconds", options->prepareSeconds, "A decomposition that takes longer is left out")
		->type_name("SECONDS")
		->check(between(1, 1e6))
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
	addSelection(*command, options->selection);
	addCache(*command, options->cache);
	cli::addQuiet(*command, options->common);
	cli::addJson(*command, options->common);
	command->callback([options] { runTradeoff(*options); });
}
}  // namespace clod::demo
