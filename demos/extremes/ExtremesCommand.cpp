// SPDX-License-Identifier: Zlib
// clod-bench extremes: the stability matrix, a row a case with its bound and what was measured.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <memory>

#include "cli/Progress.h"
#include "demos/extremes/MatrixReport.h"
#include "demos/extremes/Solids.h"
#include "demos/runner/Commands.h"

namespace clod::demo
{
namespace
{
struct ExtremesOptions
{
	cli::CommonOptions common;
	CacheOptions cache;
	std::string directory;
	MatrixOptions matrix;
};

void runExtremes(const ExtremesOptions& options)
{
	std::vector<Row> rows = chosenRows(allRows(), options.matrix);
	makeDirectory(options.directory);
	cli::requireWritable({options.common.json, options.directory + "/extremes.json"});
	HierarchyCache cache(options.cache, true);
	Workshop workshop(cache);
	cli::Progress progress(options.common.quiet);
	const Matrix matrix = runMatrix(std::move(rows), workshop, options.matrix.isQuick,
									[&](const std::string&, double fraction) { progress.update("rows", fraction); });
	progress.update("rows", 1);
	progress.finish();
	nlohmann::ordered_json report = startReport("extremes");
	addToReport(report, matrix);
	const std::string base = options.directory + "/extremes", table = printable(matrix);
	writeText(base + ".csv", formatCsv(matrix));
	writeText(base + ".txt", table);
	writeText(base + ".svg", validityMap(matrix));
	writeReport(base + ".json", report);
	writeReport(options.common.json, report);
	if (options.common.textOnStdout()) fmt::print("{}wrote {}.csv, .txt, .json, .svg\n", table, base);
	demandBounds(matrix);
}
}  // namespace

void addExtremesCommand(CLI::App& program)
{
	auto options = std::make_shared<ExtremesOptions>();
	CLI::App* command = program.add_subcommand(
		"extremes",
		"The stability matrix: extremes and closed forms beside Bullet's own shapes; exit 4 outside a bound");
	command->footer(
		"Example: clod-bench extremes -o out/extremes\n"
		"         clod-bench extremes --only A13 -o out/bowl");
	cli::addFolder(*command, options->directory, "extremes.csv, .txt, .json and .svg");
	command->add_flag("--quick", options->matrix.isQuick, "A minute: some rows, their first case and step");
	command->add_option("--only", options->matrix.only, "One row, by its id")->type_name("ROW");
	command
		->add_option("--bounds", options->matrix.shareOfBounds,
					 "Times every bound; below 1 it shows what has little room")
		->type_name("SHARE")
		->check(between(0, 1000))
		->capture_default_str();
	addCache(*command, options->cache);
	cli::addQuiet(*command, options->common);
	cli::addJson(*command, options->common);
	command->callback([options] { runExtremes(*options); });
}
}  // namespace clod::demo
