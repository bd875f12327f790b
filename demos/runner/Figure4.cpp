// SPDX-License-Identifier: Zlib
// The runs, the table and the plot of Figure 4.
#include "demos/runner/Figure4.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/Failure.h"
#include "demos/models/Models.h"
#include "demos/runner/Commands.h"
#include "demos/runner/Gnuplot.h"
#include "demos/runner/SceneModels.h"
#include "demos/runner/SceneRun.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
constexpr const char* kFigureScene = "spoon-cup";

struct Selection4
{
	const char* name;
	double share;       // s0, of the radius of the cup's opening; 0: exact
	const char* color;  // Okabe & Ito
};
constexpr Selection4 kSelections[] = {{"exact", 0, "#000000"},
									  {"s0 = 0.035 %", 0.00035, "#0072B2"},
									  {"s0 = 0.35 %", 0.0035, "#009E73"},
									  {"s0 = 3.5 %", 0.035, "#D55E00"}};

struct Mode
{
	const char* name;
	const char* title;
	bool paper;
};
constexpr Mode kModes[] = {{"ours", "ours", false}, {"paper", "the paper's culling and rules (--paper)", true}};

// One replay: a line of the figure.
struct Curve
{
	const Mode* mode;
	const Selection4* selection;
	std::vector<ReplayRow> rows;
};

std::vector<double> column(const Curve& curve, const std::vector<Regime>& regimes, Regime regime,
						   double (*value)(const ReplayRow&))
{
	std::vector<double> values;
	for (std::size_t i = 0; i < curve.rows.size(); ++i)
		if (regimes[i] == regime) values.push_back(value(curve.rows[i]));
	return values;
}

double microseconds(const ReplayRow& row)
{
	return row.queryMicroseconds;
}
double front(const ReplayRow& row)
{
	return row.stats.front;
}
double churn(const ReplayRow& row)
{
	return double(row.churn);
}

nlohmann::ordered_json byRegime(const Curve& curve, const std::vector<Regime>& regimes)
{
	nlohmann::ordered_json figures;
	for (const Regime regime : kRegimes)
	{
		const std::vector<double> times = column(curve, regimes, regime, microseconds);
		if (times.empty())
			figures[name(regime)] = {{"rows", 0}};
		else
			figures[name(regime)] = {{"rows", times.size()},
									 {"query_us", spread(times)},
									 {"front", spread(column(curve, regimes, regime, front))},
									 {"churn", spread(column(curve, regimes, regime, churn))}};
	}
	return figures;
}

std::string formatCsv(const std::vector<Curve>& curves, const std::vector<Regime>& regimes, double dt)
{
	std::string text = "step,time,regime";
	for (const Curve& curve : curves)
	{
		const std::string prefix =
			fmt::format("{}_{}", curve.mode->name,
						curve.selection->share > 0 ? fmt::format("{:g}", 100 * curve.selection->share) : "exact");
		text += fmt::format(",{0}_us,{0}_front,{0}_churn,{0}_contacts", prefix);
	}
	text += '\n';
	for (std::size_t i = 0; i < regimes.size(); ++i)
	{
		const std::int64_t step = curves.front().rows[i].step;
		text += fmt::format("{},{:.6g},{}", step, double(step) * dt, name(regimes[i]));
		for (const Curve& curve : curves)
			text += fmt::format(",{:.3f},{},{},{}", curve.rows[i].queryMicroseconds, curve.rows[i].stats.front,
								curve.rows[i].churn, curve.rows[i].contacts);
		text += '\n';
	}
	return text;
}

// Medians, a line a curve and regime.
std::string formatCurves(const nlohmann::ordered_json& curves)
{
	std::string text = fmt::format("{:<7}{:<14}{:<10}{:>6}{:>12}{:>12}{:>10}{:>10}\n", "mode", "selection", "regime",
								   "rows", "query us", "p95 us", "front", "churn");
	for (const auto& curve : curves)
	{
		const nlohmann::ordered_json& regimes = curve["regimes"];
		for (const auto& [regime, figures] : regimes.items())
		{
			text += fmt::format("{:<7}{:<14}{:<10}{:>6}", curve["mode"].get<std::string>(),
								curve["selection"].get<std::string>(), regime, figures["rows"].get<std::size_t>());
			if (figures["rows"] != 0)
				text += fmt::format("{:>12.1f}{:>12.1f}{:>10.0f}{:>10.0f}", figures["query_us"]["median"].get<double>(),
									figures["query_us"]["p95"].get<double>(), figures["front"]["median"].get<double>(),
									figures["churn"]["median"].get<double>());
			text += '\n';
		}
	}
	return text;
}

// Three panels a mode: time, front, churn over the simulation. Column c of the csv is the first of a curve's four.
std::string plotScript(const std::vector<Curve>& curves, const std::string& csv)
{
	constexpr const char* panels[] = {"query time, microseconds", "pairs in the front", "contact pairs come and gone"};
	std::string text =
		pngTerminal(1900, 1500) +
		"set datafile separator \",\"\nset logscale y\nset format y \"%g\"\nset grid xtics ytics lc rgb \"#dddddd\"\n"
		"set multiplot layout 3,2 margins 0.075,0.985,0.10,0.92 spacing 0.06,0.05 title \"Spoon in a cup: exact and at "
		"thresholds of the cup's opening radius (Figure 4 of the paper)\" font \"DejaVu Sans,20\"\n";
	for (std::size_t panel = 0; panel < std::size(panels); ++panel)
		for (const Mode& mode : kModes)
		{
			text +=
				fmt::format("set ylabel \"{}\"\nset xlabel \"{}\"\nset title \"{}\"\n", mode.paper ? "" : panels[panel],
							panel + 1 == std::size(panels) ? "time, s" : "", panel == 0 ? mode.title : "");
			text +=
				panel == 0 && !mode.paper ? "set key at screen 0.5,0.025 center bottom horizontal\n" : "unset key\n";
			// Logarithmic, from the same number for both modes; zeros are left out.
			text += panel == 0 ? "set yrange [1:*]\n" : "set yrange [0.8:*]\n";
			std::string plots;
			for (std::size_t i = 0; i < curves.size(); ++i)
			{
				if (curves[i].mode != &mode) continue;
				plots += fmt::format("{}\"{}\" every ::1 using 2:{} with lines lw 1.2 lc rgb \"{}\" title \"{}\"",
									 plots.empty() ? "plot " : ", ", csv, 4 + 4 * i + panel, curves[i].selection->color,
									 curves[i].selection->name);
			}
			text += plots + "\n";
		}
	return text + "unset multiplot\n";
}

std::vector<Curve> measureCurves(const SceneInfo& info, const FigureOptions& options, HierarchyCache& cache,
								 const FigureProgress& progress)
{
	std::vector<Curve> curves;
	std::vector<PoseRow> poses;
	for (const Mode& mode : kModes)
	{
		SceneRunOptions run;
		run.info = info;
		run.paper = mode.paper;
		run.steps = options.steps > 0 ? options.steps : info.steps;
		run.scene.models = buildModels(info, {options.resolution, mode.paper}, cache);
		run.scene.dt = info.dt;
		run.scene.metric = ContactMetric::exactly();
		if (poses.empty())
			poses = simulatePoses(run, [&](double fraction) { progress("Figure 4: simulation", fraction); });
		for (const Selection4& selection : kSelections)
		{
			ReplayOptions asked = run.queries();
			asked.metric = ContactMetric{};
			asked.metric.exact = selection.share == 0;
			if (!asked.metric.exact) asked.metric.weightedDeviation = selection.share * CUP_OPENING_RADIUS;
			const std::string phase = fmt::format("Figure 4: {}, {}", mode.name, selection.name);
			curves.push_back({&mode, &selection,
							  replay(run.bodies(), poses, asked, [&](double fraction) { progress(phase, fraction); })});
		}
	}
	return curves;
}
}  // namespace

nlohmann::ordered_json makeFigure4(const FigureOptions& options, HierarchyCache& cache, const FigureProgress& progress)
{
	const SceneInfo& info = *findScene(kFigureScene);
	const std::vector<Curve> curves = measureCurves(info, options, cache, progress);
	const std::vector<Regime> regimes = regimesOf(curves.front().rows, info.tolerance);
	nlohmann::ordered_json report = {{"scene", info.name},
									 {"opening_radius", CUP_OPENING_RADIUS},
									 {"tolerance", info.tolerance},
									 {"curves", nlohmann::ordered_json::array()}};
	for (const Curve& curve : curves)
		report["curves"].push_back({{"mode", curve.mode->name},
									{"selection", curve.selection->name},
									{"s0", curve.selection->share * CUP_OPENING_RADIUS},
									{"regimes", byRegime(curve, regimes)}});
	const std::string base = options.directory + "/figure4";
	writeText(base + ".csv", formatCsv(curves, regimes, info.dt));
	writeText(base + ".txt", formatCurves(report["curves"]));
	report["files"] = {base + ".csv", base + ".txt"};
	if (drawPlot(plotScript(curves, base + ".csv"), base + ".png")) report["files"].push_back(base + ".png");
	return report;
}
}  // namespace clod::demo
