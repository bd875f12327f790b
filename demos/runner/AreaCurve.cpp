// SPDX-License-Identifier: Zlib
// The runs, the table and the plot of cost over contact area.
#include "demos/runner/AreaCurve.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "cli/Failure.h"
#include "demos/runner/Commands.h"
#include "demos/runner/Gnuplot.h"
#include "demos/runner/SceneModels.h"
#include "demos/runner/SceneRun.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
constexpr const char* kAreaScene = "contact-area";
constexpr std::size_t kParts = 6;  // of the largest area
constexpr int kPasses = 5;         // a row keeps its least time

struct AreaSelection
{
	const char* name;
	const char* prefix;  // of its columns
	ContactMetric metric;
	const char* color;  // Okabe & Ito
};
const std::vector<AreaSelection>& selections()
{
	static const std::vector<AreaSelection> all = {
		{"exact", "exact", ContactMetric::exactly(), "#000000"},
		{"max-error 0.5 %", "max_error_0.5", ContactMetric::errorShare(0.005), "#0072B2"},
		{"s0 = 0.35 %", "s0_0.35", ContactMetric::deviationShare(0.0035), "#009E73"},
		{"s0 = 3.5 %", "s0_3.5", ContactMetric::deviationShare(0.035), "#D55E00"}};
	return all;
}

using Rows = std::vector<ReplayRow>;
struct AreaRuns
{
	std::vector<Rows> rows;  // one a selection; the first is exact
	std::size_t areaOf(std::size_t row) const { return rows.front()[row].contacts; }
	std::size_t largestArea() const
	{
		std::size_t largest = 0;
		for (const ReplayRow& row : rows.front()) largest = std::max(largest, row.contacts);
		return largest;
	}
	// 0 to kParts - 1; precondition: the row touches.
	std::size_t partOf(std::size_t row) const { return (areaOf(row) - 1) * kParts / largestArea(); }
};

AreaRuns measureAreas(const SceneInfo& info, const FigureOptions& options, HierarchyCache& cache,
					  const FigureProgress& progress)
{
	SceneRunOptions run;
	run.info = info;
	run.steps = options.steps > 0 ? options.steps : info.steps;
	run.scene.models = buildModels(info, {options.resolution, false}, cache);
	run.scene.dt = info.dt;
	run.scene.metric = ContactMetric::exactly();
	const std::vector<PoseRow> poses =
		simulatePoses(run, [&](double fraction) { progress("contact area: courses", fraction); });
	AreaRuns runs;
	for (const AreaSelection& selection : selections())
	{
		ReplayOptions asked = run.queries();
		asked.metric = selection.metric;
		asked.repeat = kPasses;
		asked.contactsOnly = true;
		const std::string phase = std::string("contact area: ") + selection.name;
		runs.rows.push_back(replay(run.bodies(), poses, asked, [&](double fraction) { progress(phase, fraction); }));
	}
	if (runs.largestArea() == 0)
		throw cli::Failure(cli::ExitCode::badInput, "nothing touches in the steps asked for: contact-area needs more");
	return runs;
}

Rows rowsOf(const AreaRuns& runs, std::size_t selection, std::size_t part)
{
	Rows rows;
	for (std::size_t i = 0; i < runs.rows[selection].size(); ++i)
		if (runs.areaOf(i) > 0 && runs.partOf(i) == part) rows.push_back(runs.rows[selection][i]);
	return rows;
}

double median(const Rows& rows, double (*value)(const ReplayRow&))
{
	std::vector<double> values;
	for (const ReplayRow& row : rows) values.push_back(value(row));
	return quantile(values, 0.5);
}

nlohmann::ordered_json describe(const AreaRuns& runs, std::size_t selection)
{
	const auto medians = [&](double (*value)(const ReplayRow&))
	{
		nlohmann::ordered_json list = nlohmann::ordered_json::array();
		for (std::size_t part = 0; part < kParts; ++part) list.push_back(median(rowsOf(runs, selection, part), value));
		return list;
	};
	nlohmann::ordered_json rows = nlohmann::ordered_json::array();
	for (std::size_t part = 0; part < kParts; ++part) rows.push_back(rowsOf(runs, selection, part).size());
	nlohmann::ordered_json json = {{"selection", selections()[selection].name},
								   {"rows", rows},
								   {"query_us", medians([](const ReplayRow& r) { return r.queryMicroseconds; })},
								   {"tests", medians([](const ReplayRow& r) { return double(r.tests()); })},
								   {"contacts", medians([](const ReplayRow& r) { return double(r.contacts); })}};
	for (const char* figure : {"query_us", "tests", "contacts"})
		json["growth"][figure] = json[figure].back().get<double>() / json[figure].front().get<double>();
	return json;
}

std::string formatCsv(const AreaRuns& runs)
{
	std::string text = "step,area";
	for (const AreaSelection& selection : selections())
		text += fmt::format(",{0}_us,{0}_tests,{0}_contacts", selection.prefix);
	text += '\n';
	for (std::size_t i = 0; i < runs.rows.front().size(); ++i)
	{
		text += fmt::format("{},{}", runs.rows.front()[i].step, runs.areaOf(i));
		for (const Rows& rows : runs.rows)
			text += fmt::format(",{:.3f},{},{}", rows[i].queryMicroseconds, rows[i].tests(), rows[i].contacts);
		text += '\n';
	}
	return text;
}

// A line a selection: query time in each part of the area, and growth.
std::string formatAreas(const nlohmann::ordered_json& curves)
{
	std::string text =
		fmt::format("median query us by parts of the contact area, and growth from first to last\n{:<17}", "selection");
	for (std::size_t part = 0; part < kParts; ++part)
		text += fmt::format("{:>9}", fmt::format("{}/{}", part + 1, kParts));
	text += fmt::format("{:>9}{:>9}{:>10}\n{:<17}", "time", "tests", "contacts", "rows");
	for (const auto& rows : curves[0]["rows"]) text += fmt::format("{:>9}", rows.get<std::size_t>());
	text += '\n';
	for (const auto& curve : curves)
	{
		text += fmt::format("{:<17}", curve["selection"].get<std::string>());
		for (const auto& us : curve["query_us"]) text += fmt::format("{:>9.0f}", us.get<double>());
		const auto growth = [&](const char* figure)
		{ return fmt::format("{:.2f} x", curve["growth"][figure].get<double>()); };
		text += fmt::format("{:>9}{:>9}{:>10}\n", growth("query_us"), growth("tests"), growth("contacts"));
	}
	return text;
}

// Time and tests of every row over its area. Column c of the csv is the first of a selection's three.
std::string plotScript(const std::string& csv)
{
	std::string text =
		pngTerminal(1700, 800) +
		"set datafile separator \",\"\nset grid xtics ytics lc rgb \"#dddddd\"\nset logscale y\nset format \"%g\"\n"
		"set xlabel \"contact area: pairs of patches in contact in exact mode\"\nset key bottom right\n"
		"set multiplot layout 1,2 title \"A nut screwed onto a bolt: cost over contact area at fixed resolution\" font "
		"\"DejaVu Sans,20\"\n";
	constexpr const char* panels[] = {"query time, microseconds", "tests of a query, hulls and boxes"};
	for (std::size_t panel = 0; panel < std::size(panels); ++panel)
	{
		std::string plots;
		for (std::size_t i = 0; i < selections().size(); ++i)
			plots +=
				fmt::format("{}\"{}\" every ::1 using ($2 > 0 ? $2 : NaN):{} with points {} lc rgb \"{}\" title \"{}\"",
							plots.empty() ? "plot " : ", ", csv, 3 + 3 * i + panel,
							i == 0 ? "pt 6 ps 1.3" : "pt 7 ps 0.7", selections()[i].color, selections()[i].name);
		text += fmt::format("set title \"{}\"\n{}\n", panels[panel], plots);
	}
	return text + "unset multiplot\n";
}
}  // namespace

nlohmann::ordered_json makeAreaCurve(const FigureOptions& options, HierarchyCache& cache,
									 const FigureProgress& progress)
{
	const SceneInfo& info = *findScene(kAreaScene);
	const AreaRuns runs = measureAreas(info, options, cache, progress);
	nlohmann::ordered_json report = {{"scene", info.name},
									 {"tolerance", info.tolerance},
									 {"largest_area", runs.largestArea()},
									 {"parts", kParts},
									 {"curves", nlohmann::ordered_json::array()}};
	for (std::size_t i = 0; i < selections().size(); ++i) report["curves"].push_back(describe(runs, i));
	const std::string base = options.directory + "/area";
	const std::string table = formatAreas(report["curves"]);
	writeText(base + ".csv", formatCsv(runs));
	writeText(base + ".txt", table);
	report["table"] = table;
	report["files"] = {base + ".csv", base + ".txt"};
	if (drawPlot(plotScript(base + ".csv"), base + ".png")) report["files"].push_back(base + ".png");
	return report;
}
}  // namespace clod::demo
