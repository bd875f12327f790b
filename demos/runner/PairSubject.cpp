// SPDX-License-Identifier: Zlib
#include "demos/runner/PairSubject.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <map>

#include "cli/Failure.h"
#include "cli/Suggestion.h"
#include "demos/runner/Commands.h"
#include "demos/runner/Replay.h"
#include "demos/runner/SceneModels.h"
#include "demos/runner/SceneRun.h"
#include "demos/scenes/Scene.h"
#include "demos/trial/Recommendation.h"

namespace clod::demo
{
namespace
{
using cli::ExitCode;
using cli::Failure;

constexpr std::size_t kTumbledPoses = 1000;
constexpr std::uint64_t kTumblingSeed = 1;
constexpr double kBulletRadius = 5;         // bodies are scaled by a power of ten to about this radius for Bullet

BuiltHierarchy buildModel(HierarchyCache& cache, const SceneModel& model, double resolution)
{
	if (!model.file.empty()) return {cache.open(model.file, {}), std::nan("")};
	return buildTimed(cache, modelSource(model.name, trianglesOf(model.name, resolution)));
}

std::uint32_t bodyNamed(const SceneInfo& info, const std::string& name)
{
	std::vector<std::string> names;
	for (std::uint32_t i = 0; i < info.bodies.size(); ++i)
	{
		if (info.bodies[i].name == name) return i;
		names.push_back(info.bodies[i].name);
	}
	throw Failure(ExitCode::usage, fmt::format("{} has no body '{}'{}; `clod-bench list --json -` names them",
											   info.name, name, cli::didYouMean(name, names)));
}

// The two bodies asked for; else those that are near each other in most steps.
BodyPair pairOf(const PairInput& input, const SceneInfo& info, const std::vector<PoseRow>& poses)
{
	if (!input.bodies.empty())
	{
		const BodyPair pair{bodyNamed(info, input.bodies[0]), bodyNamed(info, input.bodies[1])};
		if (pair.a == pair.b) throw Failure(ExitCode::usage, "--pair takes two different bodies");
		return {std::min(pair.a, pair.b), std::max(pair.a, pair.b)};
	}
	std::map<std::pair<std::uint32_t, std::uint32_t>, int> counts;
	for (const PoseRow& row : poses) ++counts[{row.bodyA, row.bodyB}];
	if (counts.empty()) return {0, 1};
	const auto fewer = [](const auto& l, const auto& r) { return l.second < r.second; };
	const auto most = std::max_element(counts.begin(), counts.end(), fewer)->first;
	return {most.first, most.second};
}

// Simulates the scene in exact mode: these are the poses that everybody is asked at.
PairSubject fromScene(const PairInput& input, const SceneInfo& info, HierarchyCache& cache, cli::Progress& progress)
{
	if (!input.bodies.empty()) pairOf(input, info, {});  // before a long simulation
	SceneRunOptions run;
	run.info = info;
	double seconds = 0;
	for (const SceneModel& model : info.models)
	{
		const BuiltHierarchy built = buildModel(cache, model, input.resolution);
		run.scene.models.push_back(built.hierarchy);
		seconds += built.seconds;
	}
	run.scene.metric = ContactMetric::exactly();
	run.scene.dt = input.dt > 0 ? input.dt : info.dt;
	run.steps = input.steps > 0 ? input.steps : info.steps;
	std::vector<PoseRow> poses =
		simulatePoses(run, [&](double fraction) { progress.update("exact simulation", fraction); });
	const BodyPair pair = pairOf(input, info, poses);
	const auto isOther = [&](const PoseRow& row) { return row.bodyA != pair.a || row.bodyB != pair.b; };
	poses.erase(std::remove_if(poses.begin(), poses.end(), isOther), poses.end());
	const SceneBody &bodyA = info.bodies[pair.a], &bodyB = info.bodies[pair.b];
	return {info.isPair() ? info.name : fmt::format("{}, {} and {}", info.name, bodyA.name, bodyB.name),
			{run.scene.models[bodyA.model], run.scene.models[bodyB.model], seconds},
			std::move(poses),
			info.tolerance,
			{run.scene.dt, !info.isPair()},
			info.worldScale};
}

// Poses that nobody recorded are those of B as it tumbles over A, as `try` has them.
PairSubject fromFiles(const PairInput& input, HierarchyCache& cache, cli::Progress& progress)
{
	const bool isRecorded = input.words.size() == 3;
	Result<std::vector<PoseRow>> poses = isRecorded ? readPoses(input.words[2]) : std::vector<PoseRow>();
	if (!poses) throw Failure(ExitCode::badInput, poses.error());
	const HierarchyPointer a = cache.open(input.words[0], {}), b = cache.open(input.words[1], {});
	const double radius = smallerRadius(*a, *b), tolerance = kDefaultTolerance * radius;
	if (!isRecorded)
		poses = touchingPoses(*a, *b, input.tolerance ? input.tolerance->inMeshUnit(radius) : tolerance, kTumbledPoses,
							  kTumblingSeed, [&](double fraction) { progress.update("poses in touch", fraction); })
					.rows;
	return {input.words[0] + " and " + input.words[1] + (isRecorded ? "" : ", tumbling over each other"),
			{a, b, std::nan("")},
			std::move(poses.value()),
			tolerance,
			{input.dt > 0 ? input.dt : 1.0 / 240, !isRecorded},
			std::pow(10.0, std::round(std::log10(kBulletRadius / radius)))};
}

PairSubject anySubject(const PairInput& input, HierarchyCache& cache, cli::Progress& progress)
{
	if (input.words.size() > 1 && !input.bodies.empty())
		throw Failure(ExitCode::usage, "--pair is for scenes; A B [POSES.csv] has its two bodies");
	if (input.words.size() > 1) return fromFiles(input, cache, progress);
	return fromScene(input, sceneNamed(input.words[0]), cache, progress);
}
}  // namespace

void addPairInput(CLI::App& command, PairInput& input)
{
	command.add_option("INPUT", input.words, "A scene, or A B [POSES.csv]; without poses B tumbles over A")
		->required()
		->expected(1, 3);
	cli::addLength(command, "--tolerance", input.tolerance,
				   "Contacts up to this gap (default: the scene's, else 1% of the smaller radius)");
	addResolution(command, input.resolution);
	command.add_option("--steps", input.steps, "Steps of a scene (default: the scene's)")
		->type_name("N")
		->check(CLI::Range(1, 10'000'000));
	command
		.add_option("--pair", input.bodies,
					"The two bodies to compare on, of a scene of more (default: the two that are near most often)")
		->type_name("NAME,NAME")
		->delimiter(',')
		->expected(2);
	command.add_option("--dt", input.dt, "Seconds between rows (default: the scene's, else 1/240)")
		->type_name("SECONDS")
		->check(between(1e-9, 1e9));
}

PairSubject pairSubject(const PairInput& input, HierarchyCache& cache, cli::Progress& progress)
{
	PairSubject subject = anySubject(input, cache, progress);
	if (input.tolerance)
		subject.tolerance = input.tolerance->inMeshUnit(smallerRadius(*subject.models.a, *subject.models.b));
	if (!(subject.tolerance > 0)) throw Failure(ExitCode::usage, "--tolerance must be positive");
	return subject;
}
}  // namespace clod::demo
