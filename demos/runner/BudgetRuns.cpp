// SPDX-License-Identifier: Zlib
// Simulations under budgets, their figures and their plot.
#include "demos/runner/BudgetRuns.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

#include "demos/runner/Gnuplot.h"
#include "demos/runner/Replay.h"
#include "demos/runner/Statistics.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
constexpr double kOverShare = 1.1;        // of the budget: a step that takes more counts as over it
constexpr double kLeastDrawn = 0.01;       // smaller errors are drawn here: an axis in decades has no zero
constexpr double kHalfANumber = 40;       // pixels, beyond the end of an axis

std::vector<double> column(const BudgetRun& run, const std::function<double(const BudgetRow&)>& value)
{
	std::vector<double> values;
	std::transform(run.rows.begin(), run.rows.end(), std::back_inserter(values), value);
	return values;
}

nlohmann::ordered_json describe(const BudgetRun& run, double radius)
{
	const bool isCounted = run.budget.tests < kOff;
	const double budget = isCounted ? run.budget.tests : run.budget.microseconds;
	nlohmann::ordered_json json = {{"budget", nullptr}, {"steps", run.rows.size()}};
	json["in_tests"] = isCounted;
	if (run.rows.empty()) return json;
	json["dispatch_us"] = spread(column(run, [](const BudgetRow& r) { return r.dispatchMicroseconds; }));
	json["error_percent"] = spread(column(run, [&](const BudgetRow& r) { return 100 * r.contactError / radius; }));
	json["excess"] = spread(column(run, [](const BudgetRow& r) { return r.excess; }));
	json["tests"] = spread(column(run, [](const BudgetRow& r) { return double(r.tests); }));
	if (!run.budget.isLimited()) return json;
	json["budget"] = budget;
	const auto used = [&](const BudgetRow& r) { return isCounted ? double(r.tests) : r.dispatchMicroseconds; };
	json["over"] = spread(column(run, [&](const BudgetRow& r) { return used(r) - budget; }));
	const auto isOver = [&](const BudgetRow& r) { return used(r) > kOverShare * budget; };
	json["share_over"] = double(std::count_if(run.rows.begin(), run.rows.end(), isOver)) / double(run.rows.size());
	return json;
}

std::string budgetName(const nlohmann::ordered_json& run)
{
	return run["budget"].is_null() ? "none" : fmt::format("{:g}", run["budget"].get<double>());
}

// Are the budgets counted in tests?
bool isCounted(const nlohmann::ordered_json& scene)
{
	const auto isOfTests = [](const auto& run) { return run["in_tests"].template get<bool>(); };
	return std::any_of(scene["runs"].begin(), scene["runs"].end(), isOfTests);
}

// Lines of `T median p95 error-median error-p95`, of runs with a budget above 0.
std::string plotData(const nlohmann::ordered_json& scene)
{
	std::string text;
	for (const auto& run : scene["runs"])
	{
		if (run["budget"].is_null() || run["budget"] == 0 || run["steps"] == 0) continue;
		const auto& spent = run["dispatch_us"];
		const auto percent = [&](const char* figure)
		{ return std::max(kLeastDrawn, run["error_percent"][figure].get<double>()); };
		text += fmt::format("{} {} {} {} {}\n", run["budget"].get<double>(), spent["median"].get<double>(),
							spent["p95"].get<double>(), percent("median"), percent("p95"));
	}
	return text;
}

// Of the run without a budget; NaN where there is none.
double unbudgeted(const nlohmann::ordered_json& scene, const std::string& group, const char* figure)
{
	for (const auto& run : scene["runs"])
		if (run["steps"] != 0 && run["budget"].is_null()) return run[group][figure].get<double>();
	return std::nan("");
}

std::string panel(const nlohmann::ordered_json& scene, bool isSpent)
{
	const bool areTests = isCounted(scene);
	std::string text = fmt::format(
		"set title \"{}\"\nset ylabel \"{}\"\nset xlabel \"{}\"\n",
		isSpent ? scene["scene"].get<std::string>() + " under a budget a step" : "",
		isSpent ? "dispatch of a step, microseconds" : "error of the coarsest contact, % of R",
		isSpent ? "" : areTests ? "budget, hull and culling tests a step" : "budget, microseconds a step");
	text += isSpent ? "set key at screen 0.55,0.01 center bottom maxrows 2 Left reverse\n" : "unset key\n";
	const int first = isSpent ? 2 : 4;
	text += fmt::format("plot $scene using 1:{} with linespoints lw 2 pt 7 lc rgb \"#0072B2\" title \"median\", "
						"$scene using 1:{} with linespoints lw 2 pt 9 lc rgb \"#D55E00\" title \"95th percentile\"",
						first, first + 1);
	if (isSpent && !areTests) text += ", x with lines lw 1 dt 2 lc rgb \"#000000\" title \"the budget\"";
	for (const char* figure : {"median", "p95"})
	{
		const double free = unbudgeted(scene, isSpent ? "dispatch_us" : "error_percent", figure);
		const bool isMedian = std::string(figure) == "median";
		if (std::isfinite(free))
			text += fmt::format(", {} with lines lw 2 dt 4 lc rgb \"{}\" title \"{}, no budget\"",
								std::max(free, isSpent ? 0 : kLeastDrawn), isMedian ? "#56B4E9" : "#E69F00",
								isMedian ? "median" : "95th");
	}
	return text + "\n";
}
}  // namespace

std::vector<double> budgetsBetween(const SceneUnderBudgets& ends, bool areTests)
{
	constexpr int kBudgets = 12;
	const auto spent = [areTests](const BudgetRow& row)
	{ return areTests ? double(row.tests) : row.dispatchMicroseconds; };
	if (ends.runs.front().rows.empty() || ends.runs.back().rows.empty()) return {};
	const std::vector<double> free = column(ends.runs.back(), spent);
	const double low = std::max(1.0, quantile(column(ends.runs.front(), spent), 0.5));
	// By the clock a step takes long, too, where others have the processor.
	const double high = std::max(low, 2 * quantile(free, areTests ? 1 : 0.95));
	std::vector<double> budgets;
	for (int i = 0; i < kBudgets; ++i) budgets.push_back(std::floor(low * std::pow(high / low, i / (kBudgets - 1.0))));
	budgets.erase(std::unique(budgets.begin(), budgets.end()), budgets.end());
	return budgets;
}

SceneUnderBudgets runUnderBudgets(const SceneDefinition& scene, const SceneSettings& settings, int steps,
								  std::vector<BudgetRun> runs, const std::function<void(double)>& progress)
{
	SceneUnderBudgets result;
	result.scene = scene.info.name;
	result.radius = settings.models[0]->asset().radius;
	for (const auto& model : settings.models) result.radius = std::min(result.radius, double(model->asset().radius));
	SceneSettings silent = settings;
	silent.printsWarnings = false;
	double done = 0;
	const auto advance = [&] { progress(++done / (steps * (double(runs.size()) + 1))); };
	const auto add = [](BudgetRun& run, const SceneState& state)
	{
		if (!state.points.empty())
			run.rows.push_back({int(state.step), state.dispatchMicroseconds, state.contactError, state.excess, state.tests,
								state.coarsestTests});
	};
	const std::unique_ptr<Scene> leader = makeScene(scene, silent);
	std::vector<SceneState> states = {leader->state()};
	BudgetRun free;
	free.metric = settings.metric;
	for (int step = 0; step < steps; ++step, advance())
	{
		leader->step();
		states.push_back(leader->state());
		add(free, states.back());
	}
	for (BudgetRun& run : runs)
	{
		silent.budget = run.budget;
		silent.metric = run.metric;
		const std::unique_ptr<Scene> follower = makeScene(scene, silent);
		for (int step = 0; step < steps; ++step, advance())
		{
			follower->place(states[std::size_t(step)]);
			follower->step();
			add(run, follower->state());
		}
	}
	runs.push_back(std::move(free));
	result.runs = std::move(runs);
	return result;
}

nlohmann::ordered_json toJson(const SceneUnderBudgets& scene)
{
	nlohmann::ordered_json json = {{"scene", scene.scene}, {"radius", scene.radius}};
	json["runs"] = nlohmann::ordered_json::array();
	for (const BudgetRun& run : scene.runs) json["runs"].push_back(describe(run, scene.radius));
	return json;
}

std::string formatCsv(const std::vector<SceneUnderBudgets>& scenes)
{
	std::string text = "scene,budget_us,budget_tests,dispatch_us,error_bound,excess,tests\n";
	for (const SceneUnderBudgets& scene : scenes)
		for (const BudgetRun& run : scene.runs)
			for (const BudgetRow& row : run.rows)
				text += fmt::format("{},{},{},{:.3f},{},{},{}\n", scene.scene, number(run.budget.microseconds),
									number(run.budget.tests), row.dispatchMicroseconds, number(row.contactError),
									number(row.excess), row.tests);
	return text;
}

std::string formatTable(const std::vector<nlohmann::ordered_json>& scenes)
{
	std::string text =
		fmt::format("{:<14}{:>10}{:>8}{:>12}{:>11}{:>12}{:>12}{:>10}{:>14}{:>11}{:>10}\n", "scene", "T", "steps",
					"dispatch us", "p95 us", "over T", "p95", "over, %", "error, % R", "p95", "excess");
	for (const auto& scene : scenes)
		for (const auto& run : scene["runs"])
		{
			text += fmt::format("{:<14}{:>10}{:>8}", scene["scene"].get<std::string>(), budgetName(run),
								run["steps"].get<std::size_t>());
			if (run["steps"] != 0)
			{
				const auto at = [&](const char* group, const char* figure) { return run[group][figure].get<double>(); };
				text += fmt::format("{:>12.1f}{:>11.1f}", at("dispatch_us", "median"), at("dispatch_us", "p95"));
				text += run.contains("over")
							? fmt::format("{:>12.1f}{:>12.1f}{:>10.1f}", at("over", "median"), at("over", "p95"),
										  100 * run["share_over"].get<double>())
							: fmt::format("{:>12}{:>12}{:>10}", "-", "-", "-");
				text += fmt::format("{:>14.3f}{:>11.3f}{:>10.2f}", at("error_percent", "median"),
									at("error_percent", "p95"), at("excess", "median"));
			}
			text += '\n';
		}
	return text;
}

std::string plotBudget(const nlohmann::ordered_json& scene, const std::string& path)
{
	constexpr int kWidth = 1000, kHeight = 1150;
	const std::string data = plotData(scene);
	if (data.empty()) return "nothing touched";
	std::string text = pngTerminal(kWidth, kHeight) + "$scene << END\n" + data + "END\n";
	text += fmt::format("set multiplot layout 2,1 margins 0.14,{},0.13,0.95 spacing 0.08,0.07\n"
						"set logscale xy\nset format \"%g\"\nset grid xtics ytics lc rgb \"#dddddd\"\n",
						1 - kHalfANumber / kWidth);
	for (const bool isSpent : {true, false}) text += panel(scene, isSpent);
	return drawPlot(text + "unset multiplot\n", path) ? "" : "gnuplot is missing or failed";
}
}  // namespace clod::demo
