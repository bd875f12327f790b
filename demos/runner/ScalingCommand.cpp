// SPDX-License-Identifier: Zlib
// clod-bench scaling: queries as the models of a scene grow, and whole worlds as bodies, threads and triangles do.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <set>
#include <thread>

#include "cli/Progress.h"
#include "demos/peers/PeerShapes.h"
#include "demos/runner/Commands.h"
#include "demos/runner/Replay.h"
#include "demos/runner/ScalingRuns.h"
#include "demos/runner/SceneModels.h"
#include "demos/runner/SceneRun.h"
#include "demos/runner/WorldRuns.h"

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
	std::string scene = "spoon-cup", directory, peerDirectory;
	std::vector<double> resolutions = {0.0625, 0.25, 1};
	std::vector<int> bodies = {10, 30, 100, 300, 1000, 2000};
	std::vector<std::string> only;
	int steps = 0, repeat = 2;
	double mostSeconds = 60;
	bool has(const std::string& part) const
	{
		return only.empty() || std::find(only.begin(), only.end(), part) != only.end();
	}
};

constexpr double kMostPeerTriangles = 64'000;  // of a mesh that is decomposed

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

nlohmann::ordered_json measureQueries(const ScalingCommandOptions& options, HierarchyCache& cache, cli::Progress& progress,
									  nlohmann::ordered_json& report)
{
	const SceneInfo& info = pairScene(options.scene);
	std::vector<ScaledPair> pairs;
	SceneRunOptions finest;
	finest.info = info;
	for (const double resolution : options.resolutions)
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
	nlohmann::ordered_json selections =
		measureScaling(pairs, poses, selectionsOf(radius), {info.tolerance, info.dt, options.repeat},
					   [&](double fraction) { progress.update("replays", fraction); });
	if (selections.empty())
		throw Failure(ExitCode::badInput, "no row of " + info.name + " moves and touches at every resolution");
	report["radius"] = radius;
	report["tolerance"] = info.tolerance;
	return selections;
}

// Ours, and of the peers those that are to be had.
class Contenders
{
public:
	Contenders(const Preparation& preparation, nlohmann::ordered_json& leftOut)
		: m_preparation(preparation), m_leftOut(leftOut)
	{
	}
	std::vector<WorldContender> of(const SceneDefinition& scene, const std::vector<HierarchyPointer>& models,
								   const ModelDetail& detail)
	{
		std::vector<WorldContender> contenders = {{"exact", ContactMetric::exactly(), {}},
												  {"0.5 % (default)", ContactMetric::errorShare(0.005), {}},
												  {"size 3.5 %", ContactMetric::deviationShare(0.035), {}}};
		std::vector<ModelMesh> meshes;
		bool isSmall = true;
		for (std::size_t i = 0; i < models.size(); ++i)
		{
			meshes.push_back(meshOf(scene.info.models[i], models[i], detail));
			isSmall = isSmall && double(meshes.back().triangles.size()) <= kMostPeerTriangles;
		}
		const auto add = [&](const char* name, const char* kind)
		{
			Result<std::vector<SceneShape>> shapes =
				peerShapes(kind, meshes, movingModels(scene), kPeerMarginShare * smallestRadius(models), m_preparation,
						   [](const std::string&, double) {});
			if (!shapes) return leaveOut(name, scene.info.name, shapes.error());
			contenders.push_back({name, {}, std::move(shapes.value())});
		};
		for (const auto& [name, kind] : {std::pair{"V-HACD, 16 hulls", "vhacd:16"}, {"CoACD, 0.05", "coacd"}})
			if (isSmall)
				add(name, kind);
			else
				leaveOut(name, scene.info.name, "meshes of more than 64,000 triangles");
		add("GImpact", "gimpact");
		return contenders;
	}

private:
	void leaveOut(const char* contender, const std::string& scene, const std::string& reason)
	{
		m_leftOut.push_back({{"contender", contender}, {"scene", scene}, {"reason", reason}});
	}
	const Preparation& m_preparation;
	nlohmann::ordered_json& m_leftOut;
};

WorldRunOptions runOf(const ScalingCommandOptions& options, int from, int to)
{
	WorldRunOptions run;
	run.to = options.steps > 0 ? options.steps : to;
	run.from = options.steps > 0 ? options.steps / 2 : from;
	run.mostSeconds = options.mostSeconds;
	return run;
}

// Whoever took all the time there was for a run is not asked for more bodies.
void measureBodies(const ScalingCommandOptions& options, HierarchyCache& cache, Contenders& contenders,
				   cli::Progress& progress, WorldRecord& record)
{
	struct Kind
	{
		Arrangement arrangement;
		const char* title;
		int from, to;
	};
	const Kind kinds[] = {{Arrangement::stacks, "flat stacks", 24, 72},
						  {Arrangement::heap, "heap", 120, 216},
						  {Arrangement::field, "sparse field", 24, 72}};
	const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
	for (const Kind& kind : kinds)
	{
		record.begin(kind.title, "bodies");
		std::set<std::string> ended;
		for (const int count : options.bodies)
		{
			const SceneDefinition scene = digits(kind.arrangement, count);
			const std::vector<HierarchyPointer> models = buildModels(scene.info, {}, cache);
			const auto measure = [&](const WorldContender& contender, unsigned threads)
			{
				const std::string name = contender.name + std::to_string(threads);
				if (ended.count(name) > 0) return;
				progress.update(fmt::format("{}: {} bodies, {}", kind.title, count, contender.name), 0);
				WorldRunOptions run = runOf(options, kind.from, kind.to);
				run.threads = threads;
				const nlohmann::ordered_json& row = record.add(measureWorld(scene, models, contender, run));
				if (row["steps"].get<int>() < run.to - run.from) ended.insert(name);
			};
			for (const WorldContender& contender : contenders.of(scene, models, {})) measure(contender, 1);
			for (unsigned threads = 2; threads <= cores; ++threads)
				measure({"0.5 % (default)", ContactMetric::errorShare(0.005), {}}, threads);
		}
	}
}

void measureTriangles(const ScalingCommandOptions& options, HierarchyCache& cache, Contenders& contenders,
					  cli::Progress& progress, WorldRecord& record)
{
	record.begin(options.scene, "triangles");
	const SceneDefinition* const scene = findDefinition(options.scene);
	for (const double resolution : options.resolutions)
	{
		const std::vector<HierarchyPointer> models = buildModels(scene->info, {resolution, false}, cache);
		for (const WorldContender& contender : contenders.of(*scene, models, {resolution, false}))
		{
			progress.update(fmt::format("{}: resolution {}, {}", options.scene, resolution, contender.name), 0);
			record.add(measureWorld(*scene, models, contender, runOf(options, 100, 400)));
		}
	}
}

// Bullet's convex shapes over a mesh that stands still: Bullet's own tree of triangles, and ours. A median of each in turn.
void measureConvex(const ScalingCommandOptions& options, HierarchyCache& cache, cli::Progress& progress, WorldRecord& record)
{
	constexpr double kHalves[] = {0.01, 0.02, 0.05, 0.08, 0.15}, kSpeeds[] = {0.3, 1};
	constexpr double kModelHalf = 0.01;        // of the models box and sphere
	constexpr std::size_t kHullTriangles = 108;
	constexpr double kBulletMargin = 0.0004;   // CONVEX_DISTANCE_MARGIN, in metres: scenes are a hundred times as large
	const ModelDetail detail{options.resolutions.back(), false};
	const ModelMesh landscape = makeModel("landscape", trianglesOf("landscape", detail.resolution)).value(),
					ball = makeModel("sphere", kHullTriangles).value();
	SceneShape tree;
	tree.kind = SceneShape::Kind::bvh;
	tree.meshes = {landscape};
	tree.margin = kBulletMargin;
	for (const auto& [kind, title] : {std::pair{SceneShape::Kind::box, "box"}, {SceneShape::Kind::sphere, "ball"},
									  {SceneShape::Kind::capsule, "capsule"}, {SceneShape::Kind::hulls, "hull"}})
	{
		record.begin(fmt::format("{} on a landscape", title), "covered");
		for (const double half : kHalves)
		{
			const double scale = half / kModelHalf, across = 2 * half / LANDSCAPE_WIDTH;
			SceneShape solid;
			solid.kind = kind;
			solid.halfExtents = kind == SceneShape::Kind::capsule ? Vec3{half / 2, half / 2, 0} : Vec3{half, half, half};
			solid.margin = kBulletMargin;
			if (kind == SceneShape::Kind::hulls) solid.meshes = {ball};
			for (ModelMesh& mesh : solid.meshes)
				for (Vec3& v : mesh.vertices) v = scale * v;
			const SceneModel model{kind == SceneShape::Kind::box ? "box" : "sphere", "", scale};
			for (const double speed : kSpeeds)
			{
				const SceneDefinition scene = slideOnLandscape(model, half, speed);
				const std::vector<HierarchyPointer> models = buildModels(scene.info, detail, cache);
				for (const WorldContender& contender :
					 {WorldContender{"btBvhTriangleMeshShape", {}, {tree, solid}},
					  {"exact", ContactMetric::exactly(), {SceneShape(), solid}},
					  {"0.5 % (default)", ContactMetric::errorShare(0.005), {SceneShape(), solid}}})
				{
					progress.update(fmt::format("{} of {} m, {}", title, 2 * half, contender.name), 0);
					WorldContender named = contender;
					named.name += fmt::format(", {} m/s", speed);
					nlohmann::ordered_json row = measureWorld(scene, models, named, runOf(options, 60, 240));
					row["covered"] = 0.5 * double(landscape.triangles.size()) * across * across;
					record.add(std::move(row));
				}
			}
		}
	}
}

void runScaling(ScalingCommandOptions options)
{
	pairScene(options.scene);
	makeDirectory(options.directory);
	cli::requireWritable({options.common.json, options.directory + "/scaling.json"});
	std::sort(options.resolutions.begin(), options.resolutions.end());
	std::sort(options.bodies.begin(), options.bodies.end());
	HierarchyCache cache(options.cache, options.common.quiet);
	cli::Progress progress(options.common.quiet);
	nlohmann::ordered_json report = startReport("scaling");
	report["scene"] = options.scene;
	const std::string base = options.directory + "/scaling";
	std::string table;
	bool plotted = true;
	if (options.has("queries"))
	{
		const nlohmann::ordered_json selections = measureQueries(options, cache, progress, report);
		report["selections"] = selections;
		table = formatScalingTable(selections);
		writeText(base + ".csv", formatScalingCsv(selections));
		plotted = plotScaling(selections, options.scene + ": the same poses, finer and finer meshes", base + ".png");
	}
	nlohmann::ordered_json leftOut = nlohmann::ordered_json::array();
	const Preparation preparation({options.peerDirectory.empty() ? defaultPeerDirectory() : options.peerDirectory},
								  cache.directory().empty() ? "" : cache.directory() + "/peers", 10 * options.mostSeconds);
	Contenders contenders(preparation, leftOut);
	WorldRecord record(base + "-worlds.csv");
	if (options.has("bodies")) measureBodies(options, cache, contenders, progress, record);
	if (options.has("worlds")) measureTriangles(options, cache, contenders, progress, record);
	WorldRecord convex(base + "-convex.csv");
	if (options.has("convex")) measureConvex(options, cache, progress, convex);
	progress.finish();
	std::vector<WorldSweep> sweeps = record.sweeps();
	if (!sweeps.empty()) plotted = plotWorlds(sweeps, base + "-worlds.png") && plotted;
	if (!convex.sweeps().empty()) plotted = plotWorlds(convex.sweeps(), base + "-convex.png") && plotted;
	sweeps.insert(sweeps.end(), convex.sweeps().begin(), convex.sweeps().end());
	if (!sweeps.empty())
	{
		report["worlds"] = nlohmann::ordered_json::array();
		for (const WorldSweep& sweep : sweeps) report["worlds"].push_back(toJson(sweep));
		report["left_out"] = leftOut;
		table += formatWorldTable(sweeps);
	}
	for (const auto& each : leftOut)
		table += fmt::format("left out: {} in {}: {}\n", each["contender"].get<std::string>(), each["scene"].get<std::string>(),
							 each["reason"].get<std::string>());
	writeText(base + ".txt", table);
	writeReport(base + ".json", report);
	writeReport(options.common.json, report);
	if (!options.common.textOnStdout()) return;
	fmt::print("{}wrote {}*.csv, .txt, .json{}\n", table, base, plotted ? ", .png" : " (no plot: gnuplot is not installed)");
}
}  // namespace

void addScalingCommand(CLI::App& program)
{
	auto options = std::make_shared<ScalingCommandOptions>();
	CLI::App* command = program.add_subcommand(
		"scaling", "Queries as the models of a scene grow; whole steps and memory as bodies, threads and triangles do");
	command->footer(
		"Example: clod-bench scaling -o out/scaling\n"
		"         clod-bench scaling bolt-nut --resolutions 0.25,1,4 --only queries -o out/scaling-bolt");
	command->add_option("SCENE", options->scene, "A scene of two bodies")->capture_default_str();
	cli::addFolder(*command, options->directory, "scaling.csv, .txt, .json and .png, and scaling-worlds and scaling-convex, .csv and .png");
	command->add_option("--resolutions", options->resolutions, "Triangles, as shares of the scene's own counts")
		->delimiter(',')
		->type_name("SHARE,...")
		->check(between(1e-4, 1e3))
		->capture_default_str();
	command->add_option("--bodies", options->bodies, "So many digits in flat stacks, on a heap, and each by itself")
		->delimiter(',')
		->type_name("N,...")
		->check(CLI::Range(1, 100'000))
		->capture_default_str();
	command
		->add_option("--only", options->only,
					 "queries: replays of SCENE at each resolution; bodies: worlds of digits; worlds: SCENE at each resolution; "
					 "convex: Bullet's convex shapes over a landscape, beside btBvhTriangleMeshShape")
		->delimiter(',')
		->type_name("PART,...")
		->check(cli::oneOf({"queries", "bodies", "worlds", "convex"}));
	command->add_option("--most-seconds", options->mostSeconds, "A run of a world ends then; more bodies are not tried")
		->type_name("S")
		->check(between(0.01, 1e6))
		->capture_default_str();
	command->add_option("--peers-dir", options->peerDirectory, "Where scripts/peers put its tools (default build/peers)")
		->type_name("DIR");
	command->add_option("--steps", options->steps, "Steps of a run (default: the scene's; of worlds some hundred)")
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
