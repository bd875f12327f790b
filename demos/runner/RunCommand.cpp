// SPDX-License-Identifier: Zlib
// clod-bench run: simulates a scene.
#include <fmt/format.h>
#include <xxhash.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <random>

#include "cli/MeshPath.h"
#include "cli/Progress.h"
#include "demos/peers/PeerShapes.h"
#include "demos/runner/Commands.h"
#include "demos/runner/InputSurface.h"
#include "demos/runner/PenetrationCheck.h"
#include "demos/runner/SceneFrames.h"
#include "demos/runner/SceneModels.h"
#include "demos/runner/SceneRun.h"
#include "demos/runner/Selection.h"
#include "demos/runner/Statistics.h"
#include "demos/scenes/SceneDefinition.h"
#include "demos/scenes/SceneFile.h"

namespace clod::demo
{
namespace
{
using cli::ExitCode;
using cli::Failure;

struct RunOptions
{
	cli::CommonOptions common;
	CacheOptions cache;
	Selection selection;
	std::string scene, csv, poses, shapes = "clod", peerDirectory;
	std::vector<std::string> models;  // of `drop`
	int steps = 0, passes = 1, parts = 1;
	bool atImpacts = false;
	unsigned threads = 1;
	double dt = 0;
	double resolution = 1;
	bool verifyPenetration = false, undamped = false;
	SceneFrameOptions frames;
	ModelDetail detail() const { return {resolution, selection.paper}; }
};

constexpr double kSmallestModel = 0.01, kLargestModel = 0.04;  // radii in metres that `drop` has room for

bool isFile(const std::string& scene)
{
	return std::filesystem::path(scene).extension() == ".json";
}

SceneDefinition definitionOf(const RunOptions& options)
{
	if (isFile(options.scene))
	{
		Result<SceneDefinition> scene = readScene(options.scene);
		if (!scene) throw Failure(ExitCode::badInput, scene.error());
		if (options.models.empty()) return std::move(scene.value());
	}
	const SceneDefinition* const known = findDefinition(options.scene);
	if (options.models.empty() && known) return *known;
	if (options.scene != "drop")
		throw Failure(ExitCode::usage, fmt::format("--model is for the scene drop, not for {}", options.scene));
	std::vector<SceneModel> models;
	for (const std::string& file : options.models)
	{
		if (!std::filesystem::is_regular_file(cli::meshPath(file).file))
			throw Failure(ExitCode::badInput, file + ": no such file");
		models.push_back({std::filesystem::path(file).stem().string(), file});
	}
	return drop(models);
}

void checkSizes(const RunOptions& options, const std::vector<HierarchyPointer>& models)
{
	for (std::size_t i = 0; i < options.models.size(); ++i)
	{
		const double radius = double(models[i + 1]->asset().radius);
		if (radius < kSmallestModel || radius > kLargestModel)
			throw Failure(
				ExitCode::usage,
				fmt::format("--model {}: its radius is {:.4g} m, drop needs {} to {}; build it with --scale {:.6g}",
							options.models[i], radius, kSmallestModel, kLargestModel, 0.025 / radius));
	}
}

constexpr double kScatter = 1e-3;  // of a body's radius

// Another start of the same scene: what moves freely begins a little aside.
void scatter(SceneDefinition& definition, std::uint64_t seed)
{
	definition.prepare = [seed, before = definition.prepare](
							 SceneDefinition& scene, const std::vector<std::shared_ptr<const Hierarchy>>& models)
	{
		if (before) before(scene, models);
		std::mt19937_64 random(seed);
		const auto between = [&random](double size) { return size * (2 * double(random() >> 11) * 0x1p-53 - 1); };
		for (std::size_t i = 0; i < scene.bodies.size(); ++i)
		{
			BodyDefinition& body = scene.bodies[i];
			const double size = kScatter * double(models[scene.info.bodies[i].model]->asset().radius);
			for (int k = 0; k < 3; ++k)
			{
				const double aside = between(size);
				if (body.mass > 0 && !body.course && body.joints.empty() && body.moves[k] > 0)
					body.start.position[k] += aside;
			}
		}
	};
}

SceneRunOptions setUp(const RunOptions& options, SceneDefinition& definition, HierarchyCache& cache)
{
	SceneRunOptions run;
	run.scene.models = buildModels(definition.info, options.detail(), cache);
	checkSizes(options, run.scene.models);
	if (const std::string problem = tooFar(definition, run.scene.models); !problem.empty())
		throw Failure(ExitCode::badInput, options.scene + ": " + problem);
	fitToModels(definition, run.scene.models);
	const SceneInfo& info = run.info = definition.info;
	run.scene.metric = toMetric(options.selection);
	run.scene.budget = options.selection.budget;
	run.scene.dt = options.dt > 0 ? options.dt : info.dt;
	run.scene.passes = options.passes;
	run.scene.parts = options.parts;
	run.scene.atImpacts = options.atImpacts;
	run.scene.threads = options.threads;
	if (options.threads == 1 && !run.scene.budget.isLimited()) run.scene.timedBy = TimedBy::thread;
	run.paper = options.selection.paper;
	run.steps = options.steps > 0 ? options.steps : info.steps;
	run.scene.camera = toCameraPath(options.selection, run.steps);
	run.fresh = options.selection.fresh;
	if (const std::string problem = optionsError(run.queries(), run.bodies()); !problem.empty())
		throw Failure(ExitCode::usage, problem);
	return run;
}

std::vector<std::string> shapeNames()
{
	std::vector<std::string> names = kPeerShapes;
	names.insert(names.begin(), "clod");
	return names;
}

constexpr double kMostPrepareSeconds = 600;  // of a model's convex pieces

// The scene with what users of Bullet have in place of ours. The queries beside it stay ours: they tell how near bodies
// are.
void takePeerShapes(const RunOptions& options, const SceneDefinition& definition, const HierarchyCache& cache,
					SceneRunOptions& run, cli::Progress& progress)
{
	std::vector<ModelMesh> surfaces;
	for (const HierarchyPointer& model : run.scene.models) surfaces.push_back(inputSurface(*model));
	const PeerTools tools{options.peerDirectory.empty() ? defaultPeerDirectory() : options.peerDirectory};
	const std::string kept = cache.directory().empty() ? "" : cache.directory() + "/peers";
	const Preparation preparation(tools, kept, kMostPrepareSeconds);
	Result<std::vector<SceneShape>> shapes =
		peerShapes(options.shapes, surfaces, movingModels(definition), kPeerMarginShare * smallestRadius(run.scene.models),
				   preparation, [&](const std::string& phase, double fraction) { progress.update(phase, fraction); });
	if (!shapes) throw Failure(ExitCode::failure, options.shapes + ": " + shapes.error());
	run.scene.shapes = std::move(shapes.value());
}

std::vector<ModelMesh> meshesOf(const RunOptions& options, const SceneRunOptions& run)
{
	std::vector<ModelMesh> meshes;
	for (std::size_t i = 0; i < run.info.models.size(); ++i)
		meshes.push_back(meshOf(run.info.models[i], run.scene.models[i], options.detail()));
	return meshes;
}

nlohmann::ordered_json paintFrames(const RunOptions& options, const SceneRunOptions& run,
								   const std::vector<SceneRow>& rows, cli::Progress& progress)
{
	const SceneInfo& info = run.info;
	FrameSubject subject;
	subject.title = info.name;
	subject.summary = info.summary;
	subject.meshes = meshesOf(options, run);
	for (const SceneBody& body : info.bodies)
		subject.bodies.push_back({body.model, run.scene.models[body.model], body.isSeenThrough});
	subject.closeUp = info.closeUp;
	subject.hasGround = info.hasGround;
	subject.overview = options.selection.camera ? *options.selection.camera : overviewCamera(info.overview);
	subject.overviewAtEnd = options.selection.cameraTo.value_or(subject.overview);
	subject.steps = run.steps;
	subject.dt = run.scene.dt;
	const double smallest = smallestRadius(run.scene.models);
	std::string selection = describeMetric(options.selection, smallest);
	// Shares are of a pair's own smaller radius.
	const auto larger = std::count_if(info.bodies.begin(), info.bodies.end(), [&](const SceneBody& body)
									  { return double(run.scene.models[body.model]->asset().radius) > 1.01 * smallest; });
	if (larger > 1 && !options.selection.exact) selection += ", more between larger bodies";
	return paintScene(options.frames, subject, {rows, run, selection},
					  [&](double fraction) { progress.update("frames", fraction); });
}

nlohmann::ordered_json describeConstants(const Scene& scene)
{
	nlohmann::ordered_json constants;
	for (const SceneConstant& constant : scene.constants())
		constants[constant.name] = {{"value", constant.value}, {"unit", constant.unit}};
	return constants;
}

// The poses, and beside them their checksum as xxhsum prints and checks it.
nlohmann::ordered_json recordPoses(const std::string& path, const std::vector<PoseRow>& poses, std::size_t bodies)
{
	const std::string text = formatPoses(poses, bodies);
	const std::string checksum = fmt::format("{:016x}", XXH64(text.data(), text.size(), 0));
	writeText(path, text);
	if (path != "-") writeText(path + ".xxh64", checksum + "  " + path.substr(path.find_last_of('/') + 1) + "\n");
	return {
		{"file", path}, {"rows", poses.size()}, {"xxh64", checksum}, {"trajectory_hash", trajectoryHash(poses)}};
}

void print(const RunOptions& options, const nlohmann::ordered_json& report)
{
	if (!options.common.textOnStdout() || options.csv == "-" || options.poses == "-") return;
	const auto& summary = report["summary"];
	const auto share = [&](const char* key) { return 100 * summary[key].get<double>(); };
	fmt::print("{}: {} steps, selection {}\n", options.scene, summary["rows"].get<std::size_t>(),
			   report["selection"]["description"].get<std::string>());
	if (options.selection.hasQueryOnly())
		fmt::print("queries are so at the simulated poses; the simulation itself has our own rules, and caches\n");
	fmt::print("rows within the tolerance {:.1f} %, moving {:.1f} %, at rest {:.1f} %\n",
			   share("share_within_tolerance"), share("share_moving"), share("share_at_rest"));
	fmt::print("at the end {}, {}; fastest point {:.4f} radii/s\n", summary["stays_in_place"] ? "in place" : "GONE",
			   summary["end"]["at_rest"] ? "at rest" : "not at rest",
			   summary["end"]["largest_speed_radii_per_s"].get<double>());
	fmt::print("median over {} steps: query {:.1f} us, dispatch {:.1f} us, whole step {:.1f} us\n",
			   summary["rows"].get<std::size_t>(), summary["queries"]["all_rows"]["query_us"]["median"].get<double>(),
			   summary["dispatch_us"]["median"].get<double>(), summary["step_us"]["median"].get<double>());
	if (report.contains("interpenetration"))
		fmt::print("deepest interpenetration of the full meshes {:.6f} mm at step {} (limit {:.6f} mm)\n",
				   1000 * report["interpenetration"]["deepest"].get<double>(),
				   report["interpenetration"]["step"].get<std::int64_t>(),
				   1000 * report["interpenetration"]["limit"].get<double>());
	fmt::print("energy {:.6g} J at the start, {:.6g} at the end, {:.6g} to {:.6g} between\n",
			   report["energy"]["initial"].get<double>(), report["energy"]["final"].get<double>(),
			   report["energy"]["least"].get<double>(), report["energy"]["largest"].get<double>());
	if (report.contains("outcome"))
		for (const auto& [name, told] : report["outcome"].items())
			fmt::print("{} {:.6g} at the start, {:.6g} at the end, {:.6g} to {:.6g} between\n", name,
					   told["initial"].get<double>(), told["final"].get<double>(), told["least"].get<double>(),
					   told["largest"].get<double>());
	if (report.contains("frames"))
		for (const auto& file : report["frames"]["files"]) fmt::print("wrote {}\n", file.get<std::string>());
	fmt::print("trajectory_hash {}\n", report["trajectory_hash"].get<std::string>());
}

// Before anything is built.
void checkUsage(const RunOptions& options)
{
	if (options.frames.directory.empty())
		refuseUnusedCamera(options.selection);
	else
		makeDirectory(options.frames.directory);
	std::vector<std::string> inputs = {options.scene};
	for (const std::string& model : options.models) inputs.push_back(cli::meshPath(model).file);
	cli::requireWritable({options.csv, options.poses, options.common.json}, inputs);
	if (options.selection.hasQueryOnly() && options.selection.budget.isLimited())
		throw Failure(ExitCode::usage,
					  "--paper and --fresh are of the queries beside a simulation; under a budget the simulation's own "
					  "are reported, which have neither");
	if (options.shapes != "clod" && options.selection.budget.isLimited())
		throw Failure(ExitCode::usage, "--shapes " + options.shapes + ": only ours keeps to a budget");
}

void runRun(const RunOptions& options)
{
	checkUsage(options);
	SceneDefinition definition = definitionOf(options);
	if (options.undamped) definition.world = undamped(definition.world);
	if (options.common.seed > 0) scatter(definition, options.common.seed);
	const SceneInfo& info = definition.info;
	HierarchyCache cache(options.cache, options.common.quiet);
	SceneRunOptions run = setUp(options, definition, cache);
	run.scene.printsWarnings = !options.common.quiet;  // the report has them, too
	cli::Progress progress(options.common.quiet);
	const bool isOurs = options.shapes == "clod";
	if (!isOurs) takePeerShapes(options, definition, cache, run, progress);
	const std::unique_ptr<Scene> scene = makeScene(definition, run.scene);
	const SceneState start = scene->state();
	auto rows = runScene(*scene, run, [&](double fraction) { progress.update("simulation", fraction); });

	nlohmann::ordered_json report = startReport("run");
	report["scene"] = info.name;
	for (std::size_t i = 0; i < info.models.size(); ++i)
		report["models"].push_back(describeHierarchy(*run.scene.models[i], info.models[i].name));
	report["bodies"] = info.bodies.size();
	report["shapes"] = isOurs ? "btClodShape" : describePeerShape(options.shapes);
	report["selection"] = toJson(options.selection, smallestRadius(run.scene.models));
	report["constants"] = describeConstants(*scene);
	report["seed"] = options.common.seed;
	report["steps"] = run.steps;
	report["dt"] = run.scene.dt;
	report["trajectory_hash"] = trajectoryHash(rows);
	report["summary"] = summarizeScene(rows, info.tolerance);
	report["energy"] = summarizeEnergy(start, rows);
	if (!info.outcome.empty()) report["outcome"] = summarizeOutcome(info, start, rows);
	if (!options.poses.empty()) report["poses"] = recordPoses(options.poses, posesOf(rows), info.bodies.size());
	if (options.verifyPenetration)
	{
		const PenetrationCheck check =
			checkPenetration(run, meshesOf(options, run), rows,
							 [&](double fraction) { progress.update("interpenetration", fraction); });
		const auto radiusOf = [&](std::uint32_t body)
		{ return double(run.scene.models[info.bodies[body].model]->asset().radius); };
		report["interpenetration"] = toJson(check, info);
		report["interpenetration"]["share_of_smaller_radius"] =
			check.deepest / std::min(radiusOf(check.where.bodyA), radiusOf(check.where.bodyB));
	}
	writeText(options.csv, formatSceneRows(info, rows));
	if (!options.frames.directory.empty()) report["frames"] = paintFrames(options, run, rows, progress);
	progress.finish();
	print(options, report);
	writeReport(options.common.json, report);
	if (isOurs && options.verifyPenetration && !report["interpenetration"]["within_limit"])
		throw Failure(ExitCode::verificationFailed, "the full meshes interpenetrate deeper than the selection allows");
}
}  // namespace

void addRunCommand(CLI::App& program)
{
	auto options = std::make_shared<RunOptions>();
	options->common.seed = 0;
	CLI::App* command = program.add_subcommand("run", "Simulate a scene");
	command->footer("Example: clod-bench run spoon-cup --size 3.5 --frames frames --csv steps.csv --json -");
	command
		->add_option("SCENE", options->scene,
					 "Which scene, see `clod-bench list`, or a scene's FILE.json (demos/scenes)")
		->required()
		->check([](const std::string& scene) { return isFile(scene) ? std::string() : sceneError(scene); });
	command
		->add_option("--model", options->models,
					 "What falls in the scene drop, instead of its own models: mesh or .clod files, repeatable")
		->type_name("FILE")
		->allow_extra_args(false);
	command->add_option("--steps", options->steps, "How many steps (default: the scene's)")
		->type_name("N")
		->check(CLI::Range(1, 10'000'000));
	command->add_option("--dt", options->dt, "Seconds a step (default: the scene's)")
		->type_name("SECONDS")
		->check(between(1e-6, 1.0));
	command
		->add_option("--passes", options->passes,
					 "How often a step's contacts are found and solved at most; 1: Bullet's own world")
		->type_name("N")
		->check(CLI::Range(1, 10))
		->capture_default_str();
	CLI::Option* const parts =
		command
			->add_option("--parts", options->parts, "Into how many parts a step may be divided where passes do not settle it")
			->type_name("N")
			->check(CLI::Range(1, 64))
			->capture_default_str();
	command->add_flag("--impacts", options->atImpacts, "Divide steps at times of impact (the paper's section 5.3)")
		->needs(parts);
	command->add_option("--threads", options->threads, "That make a step's contacts: the same bits for any number")
		->type_name("N")
		->check(CLI::Range(1, 256))
		->capture_default_str();
	addResolution(*command, options->resolution);
	command->add_option("--csv", options->csv, "A row a step, under a budget of its own dispatch; - is stdout")
		->type_name("FILE");
	command->add_option("--poses", options->poses, "Record the poses as POSES.csv, with a checksum beside it")
		->type_name("FILE");
	command->add_flag("--verify-penetration", options->verifyPenetration,
					  "Measure the full meshes' interpenetration by independent code; exit 4 where ours is beyond the limit");
	cli::addChoice(*command, "--shapes", options->shapes, shapeNames(),
				   "What the models collide as: ours, or what Bullet users have instead")
		->capture_default_str();
	command->add_option("--peers-dir", options->peerDirectory, "Where scripts/peers put its tools (default build/peers)")
		->type_name("DIR");
	command->add_flag("--undamped", options->undamped, "No damping, no rolling or spinning friction");
	addFrames(*command, options->frames);
	addSelection(*command, options->selection);
	addCache(*command, options->cache);
	cli::addSeed(*command, options->common,
				 "Another start: free bodies up to a thousandth of their radius aside; 0: the scene's");
	cli::addQuiet(*command, options->common);
	cli::addJson(*command, options->common);
	command->callback([options] { runRun(*options); });
}
}  // namespace clod::demo
