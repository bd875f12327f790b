// SPDX-License-Identifier: GPL-3.0-or-later
// clod-build build MESH -o OUT.clod
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>

#include "builder/cli/Commands.h"
#include "builder/intake/ReadMesh.h"
#include "builder/library/Asset.h"
#include "clod/hierarchy/PackedFile.h"
#include "cli/Files.h"
#include "cli/Length.h"
#include "cli/MeshPath.h"
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
	bool withoutAdvice = false;
	bool parts = false;      // each part of the scene by itself
	std::optional<cli::Length> wrap, maxMove;
	std::size_t mostTriangles = 0;
};

// The words after `clod-build build MESH` that say how the file is to be read.
std::string frameWords(const FileFrame& frame)
{
	std::string words;
	if (!frame.unit.empty()) words += "--unit " + frame.unit + " ";
	if (frame.up != FileFrame().up) words += "--up " + frame.up + " ";
	if (frame.scale != 1) words += fmt::format("--scale {} ", frame.scale);
	return words;
}

// Can --repair or --wrap make a solid of it, or another wrap?
bool isMendable(Reason reason, const BuildOptions& options)
{
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
			return true;
		case Reason::limit:
			return options.repair || options.wrap;
		default:
			return false;
	}
}

// What a user can try after a refusal; empty where nothing of ours helps.
std::string nextStep(Reason reason, const BuildOptions& options)
{
	if (isMendable(reason, options))
	{
		if (options.withoutAdvice) return "";
		const bool isLimit = reason == Reason::limit;
		return fmt::format("\n  Try: clod-build build {} {}{}{} -o {}", cli::shellWord(options.mesh),
						   options.parts ? "--parts " : "", frameWords(options.frame),
						   isLimit ? cli::mendingAfter(true, {}) : cli::mendingAfter(options.repair, options.wrap),
						   cli::shellWord(options.output));
	}
	switch (reason)
	{
		case Reason::noSuchPart:
			return "\n  Try: clod-build parts " + cli::shellWord(cli::meshPath(options.mesh).file);
		case Reason::unreadable:
		case Reason::syntax:
		{
			const std::string file = cli::meshPath(options.mesh).file,
							  other = cli::shellWord(cli::nameOf({file, {}}) + "-exported.obj");
			std::error_code error;
			if (!std::filesystem::is_regular_file(file, error)) return "";
			return fmt::format("\n  Try: assimp export {} {} (Debian's assimp-utils), and {}", cli::shellWord(file),
							   other, other);
		}
		case Reason::empty:
		case Reason::indexOutOfRange:
			return "\n  Nothing mends this: export the file again.";
		default:
			return "";
	}
}

ExitCode codeOf(Reason reason)
{
	return reason == Reason::limit ? ExitCode::limitReached : ExitCode::badInput;
}

// The largest radius that is taken for metres without a word: of a room. Larger things are mostly millimetres.
constexpr double kRoomRadius = 5;

void nameUnit(const BuildOptions& options, double radius)
{
	if (options.quiet || options.withoutAdvice || !options.frame.unit.empty() || radius <= kRoomRadius) return;
	fmt::print(
		stderr,
		"{}: its radius is {:.4g} of its own unit, which looks like millimetres; `--unit mm` makes metres of it\n",
		options.mesh, radius);
}

Progress progressOn(cli::Progress& bar)
{
	return [&bar](const char* phase, double fraction)
	{
		bar.update(phase, fraction);
		return true;
	};
}

Repaired mend(const Soup& soup, const BuildOptions& options)
{
	cli::Progress bar(options.quiet);
	const double radius = radiusOf(soup);
	Mending mending;
	mending.repair = options.repair;
	if (options.maxMove) mending.maxMove = options.maxMove->inMeshUnit(radius);
	if (options.wrap) mending.wrap = options.wrap->inMeshUnit(radius);
	mending.mostTriangles = options.mostTriangles;
	return solidOf(soup, mending, progressOn(bar));
}

Repaired readSolid(const BuildOptions& options)
{
	try
	{
		Soup soup = readMesh(options.mesh);
		convert(options.frame, soup);
		nameUnit(options, radiusOf(soup));
		if (!options.quiet && soup.parts.size() > 1)
			fmt::print(
				stderr,
				"{}: its {} parts become one body; --parts builds each by itself, `clod-build parts` lists them\n",
				options.mesh, soup.parts.size());
		return mend(soup, options);
	}
	catch (const Refused& refused)
	{
		if (options.withoutAdvice && !options.json.empty())
			writeReport(options.json, {{"schema", 1}, {"mendable", isMendable(refused.reason(), options)}});
		throw Failure(codeOf(refused.reason()),
					  options.mesh + ": " + refused.what() + nextStep(refused.reason(), options));
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

// part: of a scene that was read and converted; Refused is thrown of it as it is.
nlohmann::ordered_json buildOne(const BuildOptions& options, const Soup* part = nullptr)
{
	const auto start = std::chrono::steady_clock::now();
	cli::requireWritable({options.output});
	const Repaired repaired = part ? mend(*part, options) : readSolid(options);
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
	const std::vector<std::byte> file = pack(hierarchy.value()->bytes());
	const std::string error = cli::writeFile(options.output, file);
	if (!error.empty()) throw Failure(ExitCode::failure, error);
	const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	const Hierarchy& built = *hierarchy.value();
	if (options.textOnStdout())
		fmt::print("{}{}built in {:.1f} s: {}\n", repairAsText(repaired, options, built.asset().radius),
				   describeAsText(built, file.size()), seconds, options.output);
	nlohmann::ordered_json report = describe(built, file.size(), seconds);
	report["cavities"] = solid.cavityCount;
	if (options.repair || options.wrap)
		report["repair"] = {{"changes", repaired.changes},
							{"added", describeDistance(repaired.added)},
							{"lost", describeDistance(repaired.lost)}};
	return report;
}

// Every part of the scene into a file of its own in the folder named as the output. What is refused is told, and the
// others are built.
void buildParts(const BuildOptions& options)
{
	Soup scene = readParts(options.mesh);
	convert(options.frame, scene);
	nameUnit(options, radiusOf(scene));
	std::error_code error;
	std::filesystem::create_directories(options.output, error);
	if (error) throw Failure(ExitCode::failure, fmt::format("{}: {}", options.output, error.message()));
	nlohmann::ordered_json report = {{"schema", 1}, {"parts", nlohmann::ordered_json::array()}};
	std::vector<Reason> refusals;
	for (const Part& part : scene.parts)
	{
		BuildOptions one = options;
		one.mesh = options.mesh + "#" + part.name;
		one.output = (std::filesystem::path(options.output) / (part.name + ".clod")).string();
		nlohmann::ordered_json entry = {{"name", part.name}, {"file", one.output}};
		try
		{
			const Soup piece = partOf(scene, part.name);
			entry.update(buildOne(one, &piece));
		}
		catch (const Refused& refused)
		{
			fmt::print(stderr, "part {}: {}\n", part.name, refused.what());
			entry = {{"name", part.name}, {"refused", refused.what()}};
			refusals.push_back(refused.reason());
		}
		report["parts"].push_back(entry);
	}
	if (!options.json.empty()) writeReport(options.json, report);
	if (refusals.empty()) return;
	throw Failure(codeOf(refusals.front()),
				  fmt::format("{}: {} of {} parts are refused, each for the reason above{}", options.mesh,
							  refusals.size(), scene.parts.size(), nextStep(refusals.front(), options)));
}

void run(const BuildOptions& options)
{
	if (options.wrap && !(options.wrap->value > 0)) throw Failure(ExitCode::usage, "--wrap must be positive");
	cli::requireWritable({options.json, options.parts ? std::string() : options.output},
						 {cli::meshPath(options.mesh).file});
	if (options.parts) return buildParts(options);
	const nlohmann::ordered_json report = buildOne(options);
	if (!options.json.empty()) writeReport(options.json, report);
}
}  // namespace

void addBuildCommand(CLI::App& program)
{
	const auto options = std::make_shared<BuildOptions>();
	CLI::App& command = *program.add_subcommand("build", "Build the dual hierarchy of a closed triangle mesh");
	command
		.add_option("mesh", options->mesh, "OBJ, OFF, PLY, STL, glTF or GLB file; FILE#PART: one part of a glTF scene")
		->required()
		->type_name("MESH");
	cli::addOutput(command, options->output, "FILE", "The .clod file to write; with --parts, the folder for them");
	command.add_flag("--parts", options->parts, "Each part of a glTF scene by itself, in the scene's frame");
	addFileFrame(command, options->frame);
	CLI::Option* const repair =
		command.add_flag("--repair", options->repair,
						 "Mend what is wrong with the mesh; says what it did and how far the surface moved");
	cli::addLength(command, "--max-move", options->maxMove, "Refuse a repair that moves the surface farther [25%]")
		->needs(repair);
	CLI::Option* const wrap =
		cli::addLength(command, "--wrap", options->wrap,
					   "Build a watertight wrap round the mesh instead, closing gaps narrower than this")
			->excludes(repair);
	command
		.add_option("--most-triangles", options->mostTriangles, "Make the wrap so much coarser that it has no more")
		->needs(wrap)
		->check(CLI::Range(1000, 100000000))
		->type_name("N");
	CLI::Option* const paper =
		command.add_flag("--paper", options->paper, "Exactly the choices of the paper (Otaduy & Lin 2003)");
	cli::addChoice(command, "--placement", options->placement, placementNames(),
				   "Where a collapse first puts its vertex: the paper's filter, or what to compare it with")
		->needs(paper);
	// For a program that runs this one and knows better what its user can do: the report says whether --repair or
	// --wrap can.
	command.add_flag("--no-advice", options->withoutAdvice)->group("");
	cli::addThreads(command, *options);
	cli::addSeed(command, *options);
	cli::addJson(command, *options);
	cli::addQuiet(command, *options);
	command.footer(
		"Example: clod-build build cup.obj -o cup.clod --json cup.json\n"
		"         clod-build build scan.ply --unit mm --up z --repair -o scan.clod\n"
		"         clod-build build engine.glb --parts -o engine");
	command.callback([options] { run(*options); });
}
}  // namespace clod::builder
