// SPDX-License-Identifier: Zlib
// clod-bench paper: what Otaduy & Lin 2003 print, beside ours. Table 1: models and associated hierarchies, built with
// --paper; the numbers row is the mean over the ten digits, as in the paper. Figure 4: see Figure4.h. Figure 5: every
// model at every contact level. Contact area (sec. 3.1): see AreaCurve.h.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <memory>

#include "cli/Progress.h"
#include "demos/models/Models.h"
#include "demos/runner/AreaCurve.h"
#include "demos/runner/Commands.h"
#include "demos/runner/Figure4.h"
#include "demos/runner/LevelPictures.h"

namespace clod::demo
{
namespace
{
using cli::ExitCode;
using cli::Failure;

struct PaperCommandOptions
{
	cli::CommonOptions common;
	CacheOptions cache;
	std::string directory, only;
	double resolution = 1;  // of Figure 4 and the contact area
	int steps = 0;
	bool pictures = true;
	bool has(const char* part) const { return only.empty() || only == part; }
};

// The columns of Table 1, in its order.
constexpr std::array<const char*, 6> kColumns = {"tris_orig", "bvs_orig", "tris_simp", "bvs_simp", "clods", "lods"};
using Counts = std::array<double, kColumns.size()>;

struct TableRow
{
	std::string label;
	std::vector<std::string> models;
	Counts paper;
};

std::vector<TableRow> tableRows()
{
	std::vector<std::string> digits;
	for (int i = 0; i < 10; ++i) digits.push_back("number" + std::to_string(i));
	return {
		{"cup", {"cup"}, {64000, 15490, 1532, 241, 7, 14}},     {"spoon", {"spoon"}, {86016, 16125, 1074, 61, 9, 14}},
		{"spiral", {"spiral"}, {32160, 6448, 716, 100, 7, 13}}, {"torus", {"torus"}, {32000, 5919, 644, 92, 7, 13}},
		{"bowl", {"bowl"}, {12288, 4336, 634, 63, 8, 13}},      {"numbers", digits, {1080, 161, 306, 37, 3, 9}}};
}

Counts countsOf(const Hierarchy& hierarchy)
{
	const Span<Level> levels = hierarchy.levels();
	const std::uint32_t coarsest = hierarchy.coarsestClodLevel();
	return {double(levels[0].faceCount),        double(levels[0].nodeCount), double(levels[coarsest].faceCount),
			double(levels[coarsest].nodeCount), double(coarsest + 1),        double(levels.size)};
}

// What issue and readers compare: ours divided by the paper's, and the levels the paper's own rule (a level whenever
// the patches halve) gives for our counts.
nlohmann::ordered_json describeRow(const TableRow& row, const Counts& ours)
{
	nlohmann::ordered_json paper, own;
	for (std::size_t i = 0; i < kColumns.size(); ++i)
	{
		paper[kColumns[i]] = row.paper[i];
		own[kColumns[i]] = ours[i];
	}
	return {{"model", row.label},
			{"paper", paper},
			{"ours", own},
			{"bvs_orig_ratio", ours[1] / row.paper[1]},
			{"bvs_simp_ratio", ours[3] / row.paper[3]},
			{"clods_by_halving", std::floor(std::log2(ours[1] / ours[3]))}};
}

std::string formatTable(const nlohmann::ordered_json& rows)
{
	std::string text = fmt::format("{:<9}{:<7}", "model", "");
	for (const char* column : kColumns) text += fmt::format("{:>10}", column);
	text += '\n';
	for (const auto& row : rows)
	{
		for (const char* who : {"paper", "ours"})
		{
			text += fmt::format("{:<9}{:<7}", row["model"].get<std::string>(), who);
			for (const char* column : kColumns) text += fmt::format("{:>10.0f}", row[who][column].get<double>());
			text += '\n';
		}
	}
	return text;
}

void writeFigure5(const std::string& directory, const std::string& model, const Hierarchy& hierarchy)
{
	makeDirectory(directory + "/figure5");
	const std::string path = directory + "/figure5/" + model + ".png";
	const Result<std::size_t> written =
		writePng(path, paintLevels(hierarchy, model), {{"Title", model + ": levels of detail (the paper's Figure 5)"}});
	if (!written) throw Failure(ExitCode::failure, written.error());
}

nlohmann::ordered_json makeTable1(const PaperCommandOptions& options, HierarchyCache& cache, cli::Progress& progress)
{
	nlohmann::ordered_json rows = nlohmann::ordered_json::array();
	const std::vector<TableRow> table = tableRows();
	for (std::size_t i = 0; i < table.size(); ++i)
	{
		Counts mean{};
		for (const std::string& model : table[i].models)
		{
			progress.update("Table 1: " + table[i].label, double(i) / double(table.size()));
			const HierarchyPointer hierarchy = cache.build(modelSource(model, 0), {true});
			if (options.pictures) writeFigure5(options.directory, model, *hierarchy);
			const Counts counts = countsOf(*hierarchy);
			for (std::size_t c = 0; c < counts.size(); ++c) mean[c] += counts[c] / double(table[i].models.size());
		}
		rows.push_back(describeRow(table[i], mean));
	}
	return rows;
}

void runPaper(const PaperCommandOptions& options)
{
	makeDirectory(options.directory);
	cli::requireWritable({options.common.json, options.directory + "/paper.json"});
	HierarchyCache cache(options.cache, true);
	cli::Progress progress(options.common.quiet);
	nlohmann::ordered_json report = startReport("paper");
	std::string text;
	if (options.has("table1"))
	{
		report["table1"] = makeTable1(options, cache, progress);
		text += formatTable(report["table1"]);
		writeText(options.directory + "/table1.txt", text);
	}
	const FigureOptions figure{options.directory, options.resolution, options.steps};
	const auto show = [&](const std::string& phase, double fraction) { progress.update(phase, fraction); };
	if (options.has("figure4"))
	{
		report["figure4"] = makeFigure4(figure, cache, show);
		for (const auto& file : report["figure4"]["files"]) text += "wrote " + file.get<std::string>() + "\n";
	}
	if (options.has("area"))
	{
		report["area"] = makeAreaCurve(figure, cache, show);
		text += report["area"]["table"].get<std::string>();
		for (const auto& file : report["area"]["files"]) text += "wrote " + file.get<std::string>() + "\n";
	}
	progress.finish();
	if (options.common.textOnStdout()) fmt::print("{}", text);
	writeReport(options.directory + "/paper.json", report);
	writeReport(options.common.json, report);
}
}  // namespace

void addPaperCommand(CLI::App& program)
{
	auto options = std::make_shared<PaperCommandOptions>();
	CLI::App* command = program.add_subcommand("paper",
											   "The paper's Table 1, Figure 4 and Figure 5 beside ours (hierarchies "
											   "built with --paper), and cost over contact "
											   "area");
	command->footer("Example: clod-bench paper -o out/paper");
	cli::addFolder(*command, options->directory, "table1.txt, figure4.*, area.*, figure5/*.png and paper.json");
	cli::addChoice(*command, "--only", options->only, {"table1", "figure4", "area"},
				   "One of them; Figure 5 comes with Table 1");
	command->add_flag_callback(
		"--no-pictures", [options] { options->pictures = false; }, "Without Figure 5");
	command->add_option("--steps", options->steps, "Steps of the figures' scenes (default: the scene's)")
		->type_name("N")
		->check(CLI::Range(1, 10'000'000));
	addResolution(*command, options->resolution);
	addCache(*command, options->cache);
	cli::addQuiet(*command, options->common);
	cli::addJson(*command, options->common);
	command->callback([options] { runPaper(*options); });
}
}  // namespace clod::demo
