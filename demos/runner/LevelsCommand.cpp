// SPDX-License-Identifier: Zlib
// clod-bench levels: a picture of every contact level of a mesh or hierarchy, as the paper's Figure 5.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <vector>

#include "cli/MeshPath.h"
#include "demos/runner/Commands.h"
#include "demos/runner/Gnuplot.h"
#include "demos/runner/LevelPictures.h"

namespace clod::demo
{
namespace
{
struct LevelsOptions
{
	cli::CommonOptions common;
	CacheOptions cache;
	std::string file, output, errors, plot;
	bool paper = false;
};

constexpr double kSmallestPercent = 0.001;  // of errors on a logarithmic axis

// Triangles, patches and certified errors of the contact levels, one axis of numbers and one of shares of the radius.
void plotLevels(const Hierarchy& hierarchy, const std::string& name, const std::string& path)
{
	std::string data = "$levels << END\n";
	for (std::size_t k = 0; k <= hierarchy.coarsestClodLevel(); ++k)
	{
		const Level& level = hierarchy.levels()[k];
		std::vector<float> errors;
		for (std::uint32_t i = 0; i < level.nodeCount; ++i)
			errors.push_back(hierarchy.node(level.firstNode + i).deviation);
		std::nth_element(errors.begin(), errors.begin() + std::ptrdiff_t(errors.size() / 2), errors.end());
		const auto percent = [&](float error)
		{ return std::max(kSmallestPercent, 100 * double(error) / double(hierarchy.asset().radius)); };
		data += fmt::format("{} {} {} {:.6g} {:.6g}\n", k, level.faceCount, level.nodeCount,
							percent(level.maxDeviation), percent(errors[errors.size() / 2]));
	}
	const std::string script =
		data + "END\n" + pngTerminal(1000, 640) + "set title \"" + name +
		": contact levels\"\n"
		"set xlabel \"level\"\nset xtics 1\nset grid\nset key outside bottom center horizontal\n"
		"set logscale y\nset ylabel \"triangles, patches\"\n"
		"set logscale y2\nset y2tics\nset format y2 \"%g\"\nset y2range [0.0009:]\n"
		"set y2label \"certified error, % of the radius (0.001: that or less)\"\nset ytics nomirror\n"
		"plot $levels using 1:2 with linespoints lw 2 pt 5 lc rgb \"#000000\" title \"triangles\", "
		"$levels using 1:3 with linespoints lw 2 pt 7 lc rgb \"#0072B2\" title \"patches\", "
		"$levels using 1:4 axes x1y2 with linespoints lw 2 dt 2 pt 9 lc rgb \"#D55E00\" title \"largest error\", "
		"$levels using 1:5 axes x1y2 with linespoints lw 2 dt 2 pt 11 lc rgb \"#009E73\" title \"median error\"\n";
	if (!drawPlot(script, path)) throw cli::Failure(cli::ExitCode::failure, path + ": gnuplot is missing or failed");
}

void save(const Image& sheet, const std::string& path, const std::string& name)
{
	const Result<std::size_t> written = writePng(path, sheet, {{"Title", name + ": levels of detail"}});
	if (!written) throw cli::Failure(cli::ExitCode::failure, written.error());
}

void runLevels(const LevelsOptions& options)
{
	for (const std::string& picture : {options.output, options.errors, options.plot})
		if (!picture.empty() && std::filesystem::path(picture).extension() != ".png")
			throw cli::Failure(cli::ExitCode::usage, picture + " does not end in .png");
	cli::requireWritable({options.output, options.errors, options.plot, options.common.json},
						 {cli::meshPath(options.file).file});
	HierarchyCache cache(options.cache, options.common.quiet);
	const HierarchyPointer hierarchy = cache.open(options.file, {options.paper});
	const std::string name = std::filesystem::path(options.file).stem().string();
	if (!options.plot.empty()) plotLevels(*hierarchy, name, options.plot);
	if (!options.output.empty()) save(paintLevels(*hierarchy, name), options.output, name);
	if (!options.errors.empty()) save(paintLevelErrors(*hierarchy, name), options.errors, name);
	nlohmann::ordered_json report = startReport("levels");
	report["model"] = describeHierarchy(*hierarchy, name);
	for (const std::string& picture : {options.output, options.errors, options.plot})
		if (!picture.empty()) report["files"].push_back(picture);
	if (options.common.textOnStdout())
		fmt::print("{}: {} contact levels; wrote {}\n", name, hierarchy->coarsestClodLevel() + 1,
				   fmt::join(report["files"].get<std::vector<std::string>>(), ", "));
	writeReport(options.common.json, report);
}
}  // namespace

void addLevelsCommand(CLI::App& program)
{
	auto options = std::make_shared<LevelsOptions>();
	CLI::App* command = program.add_subcommand(
		"levels", "Draw a model, a detail and every contact level, one colour a patch (the paper's Figure 5)");
	command->footer("Example: clod-bench levels cup.clod -o cup-levels.png --plot cup-plot.png");
	command->add_option("file", options->file, "A .clod file, or a mesh (then built, cached)")
		->required()
		->type_name("FILE");
	CLI::Option* const picture =
		command->add_option("-o,--output", options->output, "The picture to write")->type_name("OUT.png");
	CLI::Option* const errors =
		command->add_option("--errors", options->errors, "A heat map of every level: how far it is off the full mesh")
			->type_name("OUT.png");
	CLI::Option* const plot =
		command->add_option("--plot", options->plot, "Plot triangles, patches and certified errors by level (gnuplot)")
			->type_name("PLOT.png");
	command->callback(
		[options, picture, errors, plot]
		{
			if (picture->count() + errors->count() + plot->count() == 0)
				throw cli::Failure(cli::ExitCode::usage,
								   "levels: -o OUT.png, --errors OUT.png or --plot PLOT.png is needed");
			runLevels(*options);
		});
	command->add_flag("--paper", options->paper, "The hierarchy is built with --paper");
	addCache(*command, options->cache);
	cli::addQuiet(*command, options->common);
	cli::addJson(*command, options->common);
}
}  // namespace clod::demo
