// SPDX-License-Identifier: Zlib
// clod-bench try: a user's own meshes, from files to a report.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>

#include "cli/Files.h"
#include "cli/MeshPath.h"
#include "cli/Progress.h"
#include "demos/peers/BulletPeers.h"
#include "demos/peers/PeerShapes.h"
#include "demos/peers/Roster.h"
#include "demos/runner/Commands.h"
#include "demos/runner/InputSurface.h"
#include "demos/runner/SceneModels.h"
#include "demos/trial/Contenders.h"
#include "demos/trial/TrialFilm.h"
#include "demos/trial/TrialReport.h"
#include "demos/trial/TrialRuns.h"

namespace clod::demo
{
namespace
{
using cli::ExitCode;
using cli::Failure;
using Clock = std::chrono::steady_clock;

struct TryOptions
{
	cli::CommonOptions common;
	CacheOptions cache;
	std::vector<std::string> files;
	std::string directory, peerDirectory;
	bool repair = false, quick = false, noFilm = false;
	std::optional<cli::Length> accuracy, wrap;
	double cost = 100;
};

// How much is done: all of it, or what fits into three minutes.
struct Effort
{
	std::size_t choosing, fresh;  // poses
	int tradeoffRows, passes;
	FilmRules film;
	double mostSeconds;         // of a contender
	std::size_t mostTriangles;  // of a wrap, and of a scene's parts together; 0: any number
};
// Poses are fewer for two bodies of more triangles together, as each takes so much longer; at least a fifth.
constexpr double kManyTriangles = 1e5;
constexpr std::size_t kFewestShare = 5;
constexpr Effort kFull = {2000, 10000, 100, 3, {640, 2, 30}, 600, 0};
constexpr Effort kQuick = {1000, 1000, 24, 1, {480, 1, 30}, 25, 20000};

constexpr double kUnlike = 30;  // radii that differ by more are of different units
constexpr double kBytesOfTriangle = 100;  // of a file, at most
constexpr double kLargest = 1e8;       // radius: the floor is larger, and the builder has limits
constexpr std::size_t kMostParts = 4;  // of a scene that is named as a whole
constexpr double kDefaultAccuracy = 0.005;
constexpr std::uint64_t kChoosingSeed = 0x636c6f64, kFreshSeed = 1;

double secondsSince(Clock::time_point start)
{
	return std::chrono::duration<double>(Clock::now() - start).count();
}

// Everything that can be wrong before minutes are spent.
void checkUsage(const TryOptions& options)
{
	if (options.wrap && !(options.wrap->value > 0)) throw Failure(ExitCode::usage, "--wrap must be positive");
	for (const std::string& file : options.files)
	{
		const std::string path = cli::meshPath(file).file;
		if (!std::filesystem::is_regular_file(path))
			throw Failure(ExitCode::badInput, fmt::format("{}: no such file", file));
		if (const std::string problem = cli::notAMesh(path); !problem.empty() && cli::endingOf(path) != ".clod")
			throw Failure(ExitCode::badInput, problem + " or .clod");
	}
	makeDirectory(options.directory);
	cli::requireWritable({options.directory + "/report.html", options.common.json});
}

// The same command with another word for meshes that are no sound solids.
std::string commandWith(const TryOptions& options, const std::string& word)
{
	std::string command = "clod-bench try ";
	for (const std::string& file : options.files) command += cli::shellWord(file) + " ";
	command += word;
	if (options.quick) command += " --quick";
	if (options.noFilm) command += " --no-film";
	if (options.accuracy) command += " --accuracy " + options.accuracy->text;
	if (options.cost != TryOptions().cost) command += fmt::format(" --cost-us {:g}", options.cost);
	return command + " -o " + cli::shellWord(options.directory);
}

const Effort& effortOf(const TryOptions& options)
{
	return options.quick ? kQuick : kFull;
}

// meshes: how many there are.
TrialMesh openMesh(const TryOptions& options, const std::string& file, std::size_t meshes, double scale,
				   HierarchyCache& cache)
{
	const int before = cache.built();
	const auto start = Clock::now();
	TrialMesh mesh{file, cli::nameOf(cli::meshPath(file)), nullptr, scale, 0, {}};
	try
	{
		BuildOptions build;
		build.repair = options.repair;
		build.scale = scale;
		if (options.wrap) build.wrap = options.wrap->text;
		build.mostTriangles = effortOf(options).mostTriangles / meshes;
		mesh.hierarchy = cache.open(file, build);
		mesh.mended = cache.changes();
	}
	catch (const RefusedMesh& refused)
	{
		if (!refused.isMendable) throw;
		throw Failure(refused.code(),
					  fmt::format("{}: the builder refused this mesh (its reason is above)\n  Try: {}", file,
								  commandWith(options, cli::mendingAfter(options.repair, options.wrap))));
	}
	mesh.buildSeconds = cache.built() > before ? secondsSince(start) : std::nan("");
	return mesh;
}

// A mesh to try; a part of a scene that was named as a whole can be done without.
struct Wanted
{
	std::string path;
	bool isOfScene;
};

// What was left out or made coarser, for the report and, while it happens, for the terminal.
void note(Trial& trial, const TryOptions& options, const std::string& sentence)
{
	trial.notes.push_back(sentence);
	if (!options.common.quiet) fmt::print(stderr, "{}\n", sentence);
}

// Of a glTF scene the parts with the most faces, in the scene's order, but what is tiny beside the largest, and what
// would be too much for --quick.
std::vector<Wanted> wantedOf(Trial& trial, const TryOptions& options, const std::string& path)
{
	std::vector<ScenePart> parts = partsOf(path);
	if (parts.size() < 2) return {{path, false}};
	double largest = 0;
	std::vector<std::size_t> byFaces;
	for (const ScenePart& part : parts) largest = std::max(largest, part.radius);
	for (std::size_t i = 0; i < parts.size(); ++i)
		if (parts[i].radius * kUnlike >= largest) byFaces.push_back(i);
	std::stable_sort(byFaces.begin(), byFaces.end(),
					 [&](std::size_t l, std::size_t r) { return parts[l].faces > parts[r].faces; });
	std::set<std::size_t> chosen;
	const std::size_t most = effortOf(options).mostTriangles;
	std::size_t faces = 0;
	for (const std::size_t i : byFaces)
	{
		if (chosen.size() == kMostParts || (most > 0 && !chosen.empty() && faces + parts[i].faces > most)) continue;
		chosen.insert(i);
		faces += parts[i].faces;
	}
	std::vector<Wanted> wanted;
	for (const std::size_t i : chosen) wanted.push_back({path + "#" + parts[i].name, true});
	note(trial, options,
		 fmt::format("{}: {} of its {} parts are tried{}; name others as {}", path, wanted.size(), parts.size(),
					 most > 0 ? fmt::format(", of {} triangles together at most (--quick)", most) : "",
					 cli::shellWord(path + "#PART")));
	return wanted;
}

// Told before the minutes are spent; the file is not read yet.
void warnOfLarge(Trial& trial, const TryOptions& options, const std::string& file)
{
	const std::string path = cli::meshPath(file).file;
	const std::size_t most = effortOf(options).mostTriangles;
	const double bytes = double(std::filesystem::file_size(path));
	const bool isBuilt = !options.wrap && !cli::isGltf(path) && cli::endingOf(path) != ".clod";
	if (most > 0 && isBuilt && bytes > kBytesOfTriangle * double(most))
		note(trial, options,
			 fmt::format("{} has {:.2g} MB, probably more than the {} triangles that --quick is quick for: to build it "
						 "takes minutes",
						 file, bytes / 1e6, most));
}

std::vector<Wanted> everyWanted(Trial& trial, const TryOptions& options)
{
	std::vector<Wanted> all;
	for (const std::string& file : options.files) warnOfLarge(trial, options, file);
	for (const std::string& file : options.files)
		for (Wanted& wanted : wantedOf(trial, options, file)) all.push_back(std::move(wanted));
	return all;
}

// Meshes of unlike sizes are taken to be in different units: those far from the first are brought to its radius.
void openMeshes(Trial& trial, const TryOptions& options, HierarchyCache& cache)
{
	const std::vector<Wanted> every = everyWanted(trial, options);
	for (const auto& [file, isOfScene] : every)
	{
		try
		{
			trial.meshes.push_back(openMesh(options, file, every.size(), 1, cache));
		}
		catch (const Failure& failure)
		{
			const bool isLast = &file == &every.back().path;
			if (!isOfScene || failure.code() == ExitCode::failure || (isLast && trial.meshes.empty())) throw;
			fmt::print(stderr, "{}\n", failure.what());
			note(trial, options, fmt::format("{} is left out: the builder refused it", file));
			continue;
		}
		const double first = double(trial.meshes.front().hierarchy->asset().radius);
		const double scale = first / double(trial.meshes.back().hierarchy->asset().radius);
		if (scale <= kUnlike && scale >= 1 / kUnlike) continue;
		if (!options.common.quiet)
			fmt::print(stderr,
					   "{}: {:.4g} times the size of {}; it is taken to be in another unit and scaled by {:.6g}\n",
					   file, 1 / scale, options.files.front(), scale);
		trial.meshes.back() = openMesh(options, file, every.size(), scale, cache);
	}
	std::size_t triangles = 0;
	for (const TrialMesh& mesh : trial.meshes)
	{
		triangles += mesh.hierarchy->asset().triangleCount;
		const double radius = double(mesh.hierarchy->asset().radius);
		trial.radius = std::max(trial.radius, radius);
		trial.smallest = trial.smallest > 0 ? std::min(trial.smallest, radius) : radius;
	}
	if (trial.radius > kLargest)
		throw Failure(ExitCode::limitReached,
					  fmt::format("a radius of {0:.3g} is more than can be tried, {1:g}\n  Try: clod-build build MESH "
								  "--scale {2:.1g} -o SMALLER.clod of each mesh, and `clod-bench try` with those files",
								  trial.radius, kLargest, 1 / trial.radius));
	if (const std::size_t most = effortOf(options).mostTriangles; most > 0 && triangles > most)
		note(trial, options,
			 fmt::format("{} triangles are more than the {} that --quick is quick for", triangles, most));
}

void setUpScene(Trial& trial, const TryOptions& options, HierarchyCache& cache)
{
	std::vector<SceneModel> models;
	for (const TrialMesh& mesh : trial.meshes) models.push_back({mesh.name, mesh.file, mesh.scale, options.repair});
	trial.scene = demo::trial(models, trial.radius, trial.smallest);
	trial.tolerance = trial.scene.info.tolerance;
	const SceneModel& floor = trial.scene.info.models.front();
	trial.models.push_back(
		cache.build(modelSource(floor.name, trianglesOf(floor.name, 1)), {false, false, floor.scale}));
	for (const TrialMesh& mesh : trial.meshes) trial.models.push_back(mesh.hierarchy);
	for (const HierarchyPointer& model : trial.models) trial.surfaces.push_back(inputSurface(*model));
	if (options.common.quiet) return;
	fmt::print(stderr, "radius {:.4g} in the files' unit, played as 0.1 m\n", trial.radius);
}

void runContenders(Trial& trial, const Effort& effort, cli::Progress& progress)
{
	Solids solids;
	for (const ModelMesh& surface : trial.surfaces) solids.push_back(std::make_shared<SignedDistance>(surface));
	TrialRules rules;
	rules.steps = trial.scene.info.steps;
	rules.dt = trial.scene.info.dt;
	rules.every = std::max(1, int(std::lround(1 / (rules.dt * effort.film.framesPerSecond))));
	rules.mostSeconds = effort.mostSeconds;
	for (const Contender& contender : trial.contenders)
		trial.runs.push_back(runContender(trial, contender, solids, rules,
										  [&](double fraction)
										  { progress.update("falling: " + contender.name, fraction); }));
}

// The models that trade-off and recommendations are of: the first two meshes, or two copies of the only one.
struct TouchingPair
{
	HierarchyPointer a, b;
};
TouchingPair pairOf(Trial& trial)
{
	trial.pair = trial.meshes.size() > 1 ? trial.meshes[0].name + " and " + trial.meshes[1].name
										 : "two copies of " + trial.meshes[0].name;
	return {trial.meshes.front().hierarchy, trial.meshes[trial.meshes.size() > 1 ? 1 : 0].hierarchy};
}

std::size_t posesOf(const TouchingPair& pair, std::size_t usual)
{
	const double triangles = double(pair.a->asset().triangleCount) + double(pair.b->asset().triangleCount);
	return std::max(usual / kFewestShare, std::size_t(double(usual) * std::min(1.0, kManyTriangles / triangles)));
}

PairFrame frameOf(const Trial& trial, const TouchingPair& pair)
{
	return pairFrame(*pair.a, *pair.b, trial.scene.info.worldScale, trial.tolerance);
}

RowClock clockOf(const Trial& trial)
{
	return {trial.scene.info.dt, true};
}

void compare(Trial& trial, const TouchingPair& pair, const TouchingPoses& made, const Preparation& preparation,
			 HierarchyCache& cache, const Effort& effort, cli::Progress& progress)
{
	// Of a fall most rows are at rest, where every setting of ours costs the same next to nothing.
	const SampleRules rules{trial.tolerance, clockOf(trial), 0, effort.tradeoffRows};
	ExactSample sample =
		takeSample(pair.a, pair.b, made.rows, rules, [&](double f) { progress.update("exact answers", f); });
	if (sample.exact.empty()) return;
	RosterOptions roster;
	roster.families = {"clod-dispatch", "gimpact", "vhacd"};
	roster.hullCounts = {kPeerHulls};
	roster.decimations = 1;
	roster.frame = frameOf(trial, pair);
	Roster all = makeRoster({pair.a, pair.b, std::nan("")}, cache, preparation, roster,
							[&](const std::string& phase, double fraction) { progress.update(phase, fraction); });
	PeerInfo hull;
	hull.family = "hull";
	hull.setting = "one hull";
	all.peers.push_back(
		convexHulls(hull, convexHullOf(inputSurface(*pair.a)), convexHullOf(inputSurface(*pair.b)), roster.frame));
	trial.tradeoff.radius = smallerRadius(*pair.a, *pair.b);
	trial.tradeoff.tolerance = trial.tolerance;
	trial.tradeoff.floor = kRoundingShare * trial.tradeoff.radius;
	measure(trial.tradeoff, all.peers, sample, effort.passes,
			[&](double f) { progress.update("accuracy against time", f); });
}

void recommend(Trial& trial, const TouchingPair& pair, const TouchingPoses& choosing, const TryOptions& options,
			   const Effort& effort, cli::Progress& progress)
{
	const double radius = smallerRadius(*pair.a, *pair.b);
	const cli::Length accuracy = options.accuracy.value_or(cli::Length{kDefaultAccuracy, true, "0.5%"});
	trial.accuracy.wanted = trial.accuracy.accuracy = accuracy.inMeshUnit(radius) / radius;
	trial.cost.wanted = options.cost;
	trial.poses = choosing.rows.size();
	const auto measured = [&](double share, const TouchingPoses& poses)
	{
		LimitRow limit = measureLimit(*pair.a, *pair.b, share, trial.tolerance, poses);
		Threshold threshold;
		threshold.metric = limitMetric(share);
		timeLimit(limit, *clodDispatch({}, pair.a, pair.b, threshold, frameOf(trial, pair)), trial.tolerance, poses,
				  clockOf(trial));
		return limit;
	};
	const std::vector<double> shares = limitShares(trial.accuracy.wanted);
	for (std::size_t i = 0; i < shares.size(); ++i)
	{
		progress.update("settings", double(i) / double(shares.size()));
		trial.limits.push_back(measured(shares[i], choosing));
	}
	const TouchingPoses fresh = touchingPoses(*pair.a, *pair.b, trial.tolerance, posesOf(pair, effort.fresh),
											  options.common.seed,
											  [&](double f) { progress.update("fresh poses", f); });
	const auto check = [&](Recommendation& recommendation, const LimitRow* limit)
	{
		recommendation.isFound = limit && !fresh.rows.empty();
		if (!recommendation.isFound) return;
		recommendation.chosen = *limit;
		recommendation.rows = fresh.rows.size();
		recommendation.fresh = measured(limit->share, fresh);
	};
	check(trial.accuracy, cheapestWithin(trial.limits, trial.accuracy.wanted));
	progress.update("checking on fresh poses", 0.5);
	check(trial.cost, mostAccurateWithin(trial.limits, trial.cost.wanted));
	progress.update("checking on fresh poses", 1);
}

std::string commandOf(const TryOptions& options)
{
	std::string command = "clod-bench try";
	for (const std::string& file : options.files)
		command += " " + cli::shellWord(std::filesystem::path(file).filename().string());
	if (options.repair) command += " --repair";
	if (options.wrap) command += " --wrap " + options.wrap->text;
	if (options.quick) command += " --quick";
	if (options.accuracy) command += " --accuracy " + options.accuracy->text;
	return command + fmt::format(" --cost-us {:g} --seed {}", options.cost, options.common.seed);
}

void runTry(const TryOptions& options)
{
	const auto start = Clock::now();
	checkUsage(options);
	const Effort& effort = effortOf(options);
	HierarchyCache cache(options.cache, options.common.quiet);
	cli::Progress progress(options.common.quiet);
	const PeerTools tools{options.peerDirectory.empty() ? defaultPeerDirectory() : options.peerDirectory};
	const Preparation preparation(tools, cache.directory().empty() ? "" : cache.directory() + "/peers",
								  effort.mostSeconds);
	Trial trial;
	trial.command = commandOf(options);
	openMeshes(trial, options, cache);
	setUpScene(trial, options, cache);
	addContenders(trial, preparation, [&](const std::string& phase, double f) { progress.update(phase, f); });
	runContenders(trial, effort, progress);
	const TouchingPair pair = pairOf(trial);
	const TouchingPoses choosing = touchingPoses(*pair.a, *pair.b, trial.tolerance, posesOf(pair, effort.choosing),
												 kChoosingSeed,
												 [&](double f) { progress.update("poses in touch", f); });
	recommend(trial, pair, choosing, options, effort, progress);
	compare(trial, pair, choosing, preparation, cache, effort, progress);
	TrialPictures pictures;
	if (!options.noFilm)
		pictures =
			paintTrial(trial, options.directory + "/film", effort.film, [&](double f) { progress.update("film", f); });
	progress.finish();
	trial.seconds = secondsSince(start);
	const std::string path = options.directory + "/report.html";
	writeText(path, reportPage(trial, pictures));
	nlohmann::ordered_json report = startReport("try");
	for (const TrialMesh& mesh : trial.meshes)
		report["models"].push_back(describeHierarchy(*mesh.hierarchy, mesh.name));
	addToReport(report, trial);
	report["seconds"] = trial.seconds;
	writeReport(options.directory + "/report.json", report);
	writeReport(options.common.json, report);
	if (options.common.textOnStdout()) fmt::print("{}wrote {}\n", printable(trial), path);
	if (!trial.accuracy.keepsAccuracy())
		throw Failure(ExitCode::verificationFailed,
					  "a certified limit was exceeded on fresh poses; please report this mesh");
}
}  // namespace

void addTryCommand(CLI::App& program)
{
	auto options = std::make_shared<TryOptions>();
	options->common.seed = kFreshSeed;
	CLI::App* command = program.add_subcommand("try", "Your own meshes: from files to a report");
	command->footer(
		"Example: clod-bench try part.stl hook.obj --repair --quick -o trial\n"
		"The meshes fall, settle and slide, beside what Bullet users have; report.html says what each method cost and "
		"how\n"
		"wrong it was, and which setting to take. scripts/peers sets up V-HACD.");
	command->add_option("MESH", options->files, "One or more mesh or .clod files, of any unit")->required();
	cli::addFolder(*command, options->directory, "report.html, report.json and film/");
	CLI::Option* const repair = command->add_flag("--repair", options->repair, "Mend the meshes before they are built");
	cli::addLength(*command, "--wrap", options->wrap,
				   "Take watertight wraps round the meshes instead, which close gaps narrower than this")
		->excludes(repair);
	command->add_flag("--quick", options->quick, "Three minutes instead of all poses and passes");
	command->add_flag("--no-film", options->noFilm, "No pictures, which take most of the time");
	cli::addLength(*command, "--accuracy", options->accuracy, "What the recommended setting has to keep [0.5%]");
	command
		->add_option("--cost-us", options->cost,
					 "Microseconds that a touching pair may cost a step: its contacts and their points, not the solver")
		->type_name("US")
		->check(between(0.1, 1e7))
		->capture_default_str();
	command
		->add_option("--peers-dir", options->peerDirectory, "Where scripts/peers put its tools (default build/peers)")
		->type_name("DIR");
	cli::addSeed(*command, options->common);
	addCache(*command, options->cache);
	cli::addQuiet(*command, options->common);
	cli::addJson(*command, options->common);
	command->callback([options] { runTry(*options); });
}
}  // namespace clod::demo
