// SPDX-License-Identifier: GPL-3.0-or-later
// clod-build build MESH -o OUT.clod
#include <fmt/format.h>

#include <chrono>

#include "builder/cli/Commands.h"
#include "builder/intake/Intake.h"
#include "demos/cli/Files.h"
#include "demos/cli/Program.h"
#include "demos/cli/Progress.h"

namespace clod::builder
{
namespace
{
using cli::ExitCode;
using cli::Failure;

struct BuildOptions : cli::CommonOptions
{
	std::string mesh, output;
	bool paper = false;
};

Intake readSolid(const std::string& path)
{
	try
	{
		return intakeFile(path);
	}
	catch (const Refused& refused)
	{
		const ExitCode code = refused.reason() == Reason::limit ? ExitCode::limitReached : ExitCode::badInput;
		throw Failure(code, path + ": " + refused.what());
	}
}

HierarchyContent buildContent(const Intake& solid, const BuildOptions& options)
{
	BuildConfig config;
	config.paper = options.paper;
	config.threads = options.threads;
	config.seed = options.seed;
	cli::Progress bar(options.quiet);
	const Progress progress = [&bar](const char* phase, double fraction)
	{
		bar.update(phase, fraction);
		return true;
	};
	const LodSequence lods = buildLods(solid.mesh, config, progress);
	HierarchyContent content = assembleHierarchy(lods, config, progress);
	for (int i = 0; i < 3; ++i) content.asset.meshFromBody[i] = solid.meshFromBody[i];
	content.asset.componentCount = std::uint32_t(solid.componentCount);
	return content;
}

void run(const BuildOptions& options)
{
	const auto start = std::chrono::steady_clock::now();
	const Intake solid = readSolid(options.mesh);
	if (!options.quiet && solid.weldedCount + solid.unusedCount > 0)
		fmt::print(stderr, "{}: {} repeated vertices welded, {} unused ones dropped\n", options.mesh, solid.weldedCount,
				   solid.unusedCount);
	const HierarchyContent content = buildContent(solid, options);
	const Result<std::shared_ptr<const Hierarchy>> hierarchy = Hierarchy::fromBytes(encode(content));
	if (!hierarchy)
		throw Failure(ExitCode::failure, "the result is not sound, nothing is written: " + hierarchy.error());
	const std::string error = cli::writeFile(options.output, hierarchy.value()->bytes());
	if (!error.empty()) throw Failure(ExitCode::failure, error);
	const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	if (!options.json.empty()) writeReport(options.json, describe(*hierarchy.value(), seconds));
	if (options.textOnStdout())
		fmt::print("{}built in {:.1f} s: {}\n", describeAsText(*hierarchy.value()), seconds, options.output);
}
}  // namespace

void addBuildCommand(CLI::App& program)
{
	const auto options = std::make_shared<BuildOptions>();
	CLI::App& command = *program.add_subcommand("build", "Build the dual hierarchy of a closed triangle mesh");
	command.add_option("mesh", options->mesh, "OBJ, OFF, PLY, STL, glTF or GLB file")->required()->type_name("MESH");
	command.add_option("-o,--output", options->output, "The .clod file to write")->required()->type_name("FILE");
	command.add_flag("--paper", options->paper, "Exactly the choices of the paper (Otaduy & Lin 2003)");
	cli::addThreads(command, *options);
	cli::addSeed(command, *options);
	cli::addJson(command, *options);
	cli::addQuiet(command, *options);
	command.footer("Example: clod-build build cup.obj -o cup.clod --json cup.json");
	command.callback([options] { run(*options); });
}
}  // namespace clod::builder
