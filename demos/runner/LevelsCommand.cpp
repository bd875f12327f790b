// SPDX-License-Identifier: Zlib
// clod-bench levels: a picture of every contact level of a mesh or hierarchy, as the paper's Figure 5.
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "demos/runner/Commands.h"
#include "demos/runner/LevelPictures.h"

namespace clod::demo
{
namespace
{
struct LevelsOptions
{
	cli::CommonOptions common;
	CacheOptions cache;
	std::string file, output;
	bool paper = false;
};

void runLevels(const LevelsOptions& options)
{
	CacheOptions cacheOptions = options.cache;
	cacheOptions.quiet = options.common.quiet;
	HierarchyCache cache(cacheOptions);
	const HierarchyPointer hierarchy = cache.open(options.file, options.paper);
	const std::string name = std::filesystem::path(options.file).stem().string();
	const Image sheet = paintLevels(*hierarchy, name);
	const Result<std::size_t> written = writePng(options.output, sheet, {{"Title", name + ": levels of detail"}});
	if (!written) throw cli::Failure(cli::ExitCode::failure, written.error());
	if (!options.common.quiet)
		fmt::print("{}: {} contact levels, {}\n", name, hierarchy->coarsestClodLevel() + 1, options.output);
}
}  // namespace

void addLevelsCommand(CLI::App& program)
{
	auto options = std::make_shared<LevelsOptions>();
	CLI::App* command = program.add_subcommand(
		"levels", "Draw a model, a detail and every contact level, one colour a patch (the paper's Figure 5)");
	command->footer("Example: clod-bench levels cup.clod -o cup-levels.png");
	command->add_option("file", options->file, "A .clod file, or a mesh (then built, cached)")
		->required()
		->type_name("FILE");
	command->add_option("-o,--output", options->output, "The picture to write")->required()->type_name("OUT.png");
	command->add_flag("--paper", options->paper, "The hierarchy is built with --paper");
	addCache(*command, options->cache);
	cli::addQuiet(*command, options->common);
	command->callback([options] { runLevels(*options); });
}
}  // namespace clod::demo
