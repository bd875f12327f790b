// SPDX-License-Identifier: GPL-3.0-or-later
// clod-build build MESH -o OUT.clod
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <optional>

#include "builder/cli/Commands.h"
#include "builder/intake/ReadMesh.h"
#include "builder/library/Asset.h"
#include "cli/Files.h"
#include "cli/Length.h"
#include "cli/Program.h"
#include "cli/Progress.h"

namespace clod::builder
{
namespace
{
using cli::ExitCode;
using cli::Failure;

// In the order of Placement.
const std::vector<std::string>& placementNames()
{
	static const std::vector<std::string> names = {"filter", "quadric", "probabilistic"};
	return names;
}

Placement placementNamed(const std::string& name)
{
	const auto& names = placementNames();
	return Placement(std::find(names.begin(), names.end(), name) - names.begin());
}

struct BuildOptions : cli::CommonOptions
{
	std::string mesh, output;
	bool paper = false;
	std::string placement = placementNames().front();
	FileFrame frame;
	bool repair = false;
	std::optional<cli::Length> wrap, maxMove;
};

// What a user can try after a refusal; empty where nothing of ours helps.
std::string nextStep(Reason reason, const BuildOptions& options)
{
	const auto command = [&](const std::string& words)
	{ return fmt::format("\n  Try: clod-build build {} {} -o {}", options.mesh, words, options.output); };
	switch (reason)
	{
		case Reason::degenerate:
		case Reason::duplicate:
		case Reason::nonManifoldEdge:
		case Reason::nonManifoldVertex:
		case Reason::openBoundary:
		case Reason::orientation:
		case Reason::inverted:
		case Reason::zeroVolume:
		case Reason::rounding:
		case Reason::selfIntersection:
		case Reason::notFinite:
			return options.wrap ? command("--wrap 5%") : options.repair ? command("--wrap 2%") : command("--repair");
		case Reason::limit:
			return options.repair ? command("--wrap 2%") : "";
		default:
			return "";
	}
}

// The largest radius that is taken for metres without a word: of a room. Larger things are mostly millimetres.
constexpr double kRoomRadius = 5;

void nameUnit(const BuildOptions& options, double radius)
{
	if (options.quiet || !options.frame.unit.empty() || radius <= kRoomRadius) return;
	fmt::print(
		stderr,
		"{}: its radius is {:.4g} of its own unit, which looks like millimetres; `--unit mm` makes metres of it\n",
		options.mesh, radius);
}

// Before minutes are spent on what could not be written.
void checkOutput(const std::string& path)
{
	cli::PartialFile file(path);  // never committed
	const std::string problem = cli::writeFile(file.temporaryPath(), std::string());
	if (!problem.empty()) throw Failure(ExitCode::failure, problem);
}

Progress progressOn(cli::Progress& bar)
{
	return [&bar](const char* phase, double fraction)
	{
		bar.update(phase, fraction);
		return true;
	};
}

Repaired readSolid(const BuildOptions& options)
{
	cli::Progress bar(options.quiet);
	try
	{
		Soup soup = readMesh(options.mesh);
		convert(options.frame, soup);
		const double radius = radiusOf(soup);
		nameUnit(options, radius);
		Mending mending;
		mending.repair = options.repair;
		if (options.maxMove) mending.maxMove = options.maxMove->inMeshUnit(radius);
		if (options.wrap) mending.wrap = options.wrap->inMeshUnit(radius);
		return solidOf(soup, mending, progressOn(bar));
	}
	catch (const Refused& refused)
	{
		const ExitCode code = refused.reason() == Reason::limit ? ExitCode::limitReached : ExitCode::badInput;
		throw Failure(code, options.mesh + ": " + refused.what() + nextStep(refused.reason(), options));
	}
}

nlohmann::ordered_json describeDistance(const DistanceBracket& distance)
{
	return {
		{"lower", distance.lower}, {"upper", distance.upper}, {"at", {distance.at.x, distance.at.y, distance.at.z}}};
}

// What repair or wrap did; empty when neither was asked for.
std::string repairAsText(const Repaired& repaired, const BuildOptions& options, double radius)
{
	if (!options.repair && !options.wrap) return "";
	if (repaired.changes.empty()) return "repair: nothing to do\n";
	std::string text;
	for (const std::string& change : repaired.changes) text += "repair: " + change + "\n";
	const auto line = [&](const char* from, const DistanceBracket& d)
	{
		return fmt::format(
			"repair: every point of the {} within {:.4g} ({:.3g} % of the radius), certified; farthest "
			"seen {:.4g} at ({:.4g}, {:.4g}, {:.4g})\n",
			from, d.upper, 100 * d.upper / radius, d.lower, d.at.x, d.at.y, d.at.z);
	};
	return text + line("new surface has the file's", repaired.added) +
		   line("file's surface has the new one", repaired.lost);
}

HierarchyContent buildContent(const Intake& solid, const BuildOptions& options)
{
	BuildConfig config;
	config.paper = options.paper;
	config.placement = placementNamed(options.placement);
	config.threads = options.threads;
	config.seed = options.seed;
	cli::Progress bar(options.quiet);
	return buildAsset(solid, config, progressOn(bar));
}

void run(const BuildOptions& options)
{
	const auto start = std::chrono::steady_clock::now();
	checkOutput(options.output);
	const Repaired repaired = readSolid(options);
	const Intake& solid = repaired.solid;
	if (!options.quiet && solid.weldedCount + solid.unusedCount > 0 && !options.repair && !options.wrap)
		fmt::print(stderr, "{}: {} repeated vertices welded, {} unused ones dropped\n", options.mesh, solid.weldedCount,
				   solid.unusedCount);
	if (!options.quiet && solid.componentCount > 1)
		fmt::print(stderr, "{}: {} components, {} of them bound cavities\n", options.mesh, solid.componentCount,
				   solid.cavityCount);
	const HierarchyContent content = buildContent(solid, options);
	const Result<std::shared_ptr<const Hierarchy>> hierarchy = Hierarchy::fromBytes(encode(content));
	if (!hierarchy)
		throw Failure(ExitCode::failure, "the result is not sound, nothing is written: " + hierarchy.error());
	const std::string error = cli::writeFile(options.output, hierarchy.value()->bytes());
	if (!error.empty()) throw Failure(ExitCode::failure, error);
	const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	const Hierarchy& built = *hierarchy.value();
	if (!options.json.empty())
	{
		nlohmann::ordered_json report = describe(built, seconds);
		report["cavities"] = solid.cavityCount;
		if (options.repair || options.wrap)
			report["repair"] = {{"changes", repaired.changes},
								{"added", describeDistance(repaired.added)},
								{"lost", describeDistance(repaired.lost)}};
		writeReport(options.json, report);
	}
	if (options.textOnStdout())
		fmt::print("{}{}built in {:.1f} s: {}\n", repairAsText(repaired, options, built.asset().radius),
				   describeAsText(built), seconds, options.output);
}
}  // namespace

void addBuildCommand(CLI::App& program)
{
	const auto options = std::make_shared<BuildOptions>();
	CLI::App& command = *program.add_subcommand("build", "Build the dual hierarchy of a closed triangle mesh");
	command.add_option("mesh", options->mesh, "OBJ, OFF, PLY, STL, glTF or GLB file")->required()->type_name("MESH");
	command.add_option("-o,--output", options->output, "The .clod file to write")->required()->type_name("FILE");
	addFileFrame(command, options->frame);
	CLI::Option* const repair =
		command.add_flag("--repair", options->repair,
						 "Mend what is wrong with the mesh; says what it did and how far the surface moved");
	cli::addLength(command, "--max-move", options->maxMove, "Refuse a repair that moves the surface farther [25%]")
		->needs(repair);
	cli::addLength(command, "--wrap", options->wrap,
				   "Build a watertight wrap round the mesh instead, closing gaps narrower than this")
		->excludes(repair);
	CLI::Option* const paper =
		command.add_flag("--paper", options->paper, "Exactly the choices of the paper (Otaduy & Lin 2003)");
	cli::addChoice(command, "--placement", options->placement, placementNames(),
				   "Where a collapse first puts its vertex: the paper's filter, or what to compare it with")
		->needs(paper);
	cli::addThreads(command, *options);
	cli::addSeed(command, *options);
	cli::addJson(command, *options);
	cli::addQuiet(command, *options);
	command.footer(
		"Example: clod-build build cup.obj -o cup.clod --json cup.json\n"
		"         clod-build build scan.ply --unit mm --up z --repair -o scan.clod");
	command.callback([options] { run(*options); });
}
}  // namespace clod::builder
