// SPDX-License-Identifier: GPL-3.0-or-later
// clod-build export FILE --level K -o OUT
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <filesystem>

#include "builder/cli/Commands.h"
#include "builder/cli/LevelSurface.h"
#include "cli/Files.h"
#include "cli/Failure.h"
#include "cli/Program.h"

namespace clod::builder
{
namespace
{
using cli::ExitCode;
using cli::Failure;

struct ExportOptions : cli::CommonOptions
{
	std::string file, output;
	long long level = 0;
	bool allLevels = false;
};

std::string encodeAs(const std::string& path, const LevelSurface& surface)
{
	const std::string ending = std::filesystem::path(path).extension().string();
	if (ending == ".ply") return encodePly(surface);
	if (ending == ".obj") return encodeObj(surface);
	if (ending == ".glb") return encodeGlb(surface);
	throw Failure(ExitCode::usage, fmt::format("{} does not end in .ply, .obj or .glb", path));
}

// Value: what was written, for the report.
nlohmann::ordered_json exportLevel(const Hierarchy& hierarchy, std::uint32_t level, const std::string& path,
								   bool textOnStdout)
{
	const LevelSurface surface = levelSurface(hierarchy, level);
	const std::string error = cli::writeFile(path, encodeAs(path, surface));
	if (!error.empty()) throw Failure(ExitCode::failure, error);
	if (textOnStdout)
		fmt::print("level {}: {} triangles in {} patches: {}\n", level, surface.triangles.size(), surface.patchCount, path);
	return {{"level", level}, {"triangles", surface.triangles.size()}, {"patches", surface.patchCount}, {"file", path}};
}

// "cup.ply" becomes "cup.3.ply".
std::string numbered(const std::string& path, std::uint32_t level)
{
	const std::filesystem::path whole(path);
	return (whole.parent_path() / fmt::format("{}.{}{}", whole.stem().string(), level, whole.extension().string()))
		.string();
}

void run(const ExportOptions& options)
{
	encodeAs(options.output, {});  // the ending is checked before anything is read
	cli::requireWritable({options.json, options.allLevels ? std::string() : options.output}, {options.file});
	const auto hierarchy = loadHierarchy(options.file);
	const std::uint32_t coarsest = hierarchy->coarsestClodLevel();
	nlohmann::ordered_json report = {{"schema", 1}, {"levels", nlohmann::ordered_json::array()}};
	const auto write = [&](std::uint32_t level, const std::string& path)
	{ report["levels"].push_back(exportLevel(*hierarchy, level, path, options.textOnStdout())); };
	if (options.allLevels)
		for (std::uint32_t level = 0; level <= coarsest; ++level) write(level, numbered(options.output, level));
	else if (options.level < 0 || options.level > (long long)(coarsest))
		throw Failure(ExitCode::usage, fmt::format("--level: {} is not a level with a surface; those are 0 to {}",
												   options.level, coarsest));
	else
		write(std::uint32_t(options.level), options.output);
	if (!options.json.empty()) writeReport(options.json, report);
}
}  // namespace

void addExportCommand(CLI::App& program)
{
	const auto options = std::make_shared<ExportOptions>();
	CLI::App& command = *program.add_subcommand("export", "Write the surface of a level, one colour a patch");
	command.add_option("file", options->file, "The .clod file")->required()->type_name("FILE");
	CLI::Option* const level =
		command.add_option("--level", options->level, "0, the default: the input surface")->type_name("K");
	CLI::Option* const all = command.add_flag("--all-levels", options->allLevels,
											  "Every contact level; OUT.ply becomes OUT.0.ply, OUT.1.ply, ...");
	level->excludes(all);
	cli::addOutput(command, options->output, "OUT", "A .ply, .glb or .obj file, in the mesh's own frame");
	cli::addJson(command, *options);
	cli::addQuiet(command, *options);
	command.footer("Example: clod-build export cup.clod --level 3 -o cup3.ply");
	command.callback([options] { run(*options); });
}
}  // namespace clod::builder
