// SPDX-License-Identifier: Zlib
// clod-bench budget: scenes under budgets of time or tests.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <memory>

#include "cli/Progress.h"
#include "demos/runner/BudgetRuns.h"
#include "demos/runner/Commands.h"
#include "demos/runner/SceneModels.h"
#include "demos/runner/Selection.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
using cli::ExitCode;
using cli::Failure;

struct BudgetCommandOptions
{
	cli::CommonOptions common;
	CacheOptions cache;
	Selection selection;
	std::vector<std::string> scenes = {"spoon-cup", "torus-spiral", "numbers-bowl", "pile-stacks", "pile-heap"};
	std::vector<double> budgets;
	std::string directory;
	double resolution = 1;
	bool areTests = false;
	int steps = 0;
};

void runBudget(const BudgetCommandOptions& options)
{
	for (const std::string& name : options.scenes) sceneNamed(name);  // a typing error is told before anything is built
	if (options.selection.budget.isLimited())
		throw Failure(ExitCode::usage, "budget runs its own budgets: --budgets instead of --budget-tests, --budget-us");
	refuseUnusedCamera(options.selection);
	if (options.selection.hasQueryOnly())
		throw Failure(ExitCode::usage, "--paper and --fresh are for replay: a simulation has neither");
	makeDirectory(options.directory);
	cli::requireWritable({options.common.json, options.directory + "/budget.json"});
	HierarchyCache cache(options.cache, options.common.quiet);
	cli::Progress progress(options.common.quiet);
	std::vector<SceneUnderBudgets> measured;
	std::vector<nlohmann::ordered_json> figures;
	for (const std::string& name : options.scenes)
	{
		const SceneInfo& info = sceneNamed(name);
		const int steps = options.steps > 0 ? options.steps : info.steps;
		SceneSettings settings;
		settings.models = buildModels(info, {options.resolution, false}, cache);
		settings.metric = toMetric(options.selection);
		settings.camera = toCameraPath(options.selection, steps);
		settings.dt = info.dt;
		if (options.areTests) settings.timedBy = TimedBy::thread;  // a budget of time is kept by the clock
		const auto runAll = [&](const std::vector<double>& budgets, double from, double to)
		{
			std::vector<BudgetRun> runs;
			for (const double budget : budgets)
				runs.push_back({options.areTests ? Budget{budget, kOff} : Budget{kOff, budget}, settings.metric, {}});
			return runUnderBudgets(*findDefinition(name), settings, steps, std::move(runs), [&](double fraction)
								   { progress.update(name, from + fraction * (to - from)); });
		};
		if (options.budgets.empty())
		{
			constexpr double kOfEnds = 0.13;  // of the runs: two of fifteen
			measured.push_back(runAll(budgetsBetween(runAll({0}, 0, kOfEnds), options.areTests), kOfEnds, 1));
		}
		else
			measured.push_back(runAll(options.budgets, 0, 1));
		figures.push_back(toJson(measured.back()));
		figures.back()["selection"] = toJson(options.selection, measured.back().radius);
	}
	progress.finish();
	nlohmann::ordered_json report = startReport("budget");
	report["scenes"] = figures;
	const std::string base = options.directory + "/budget", table = formatTable(figures);
	writeText(base + ".csv", formatCsv(measured));
	writeText(base + ".txt", table);
	writeReport(base + ".json", report);
	writeReport(options.common.json, report);
	std::string plots;
	for (std::size_t i = 0; i < figures.size(); ++i)
	{
		const std::string plot = "-" + options.scenes[i] + ".png", why = plotBudget(figures[i], base + plot);
		plots += why.empty() ? ", " + plot : fmt::format(" (no {}: {})", plot, why);
	}
	if (options.common.textOnStdout()) fmt::print("{}wrote {}.csv, .txt, .json{}\n", table, base, plots);
}
}  // namespace

void addBudgetCommand(CLI::App& program)
{
	auto options = std::make_shared<BudgetCommandOptions>();
	CLI::App* command = program.add_subcommand(
		"budget", "Scenes under budgets of time or tests: what a step's dispatch takes, and the error it leaves");
	command->footer(
		"Example: clod-bench budget -o out/budget\n"
		"         clod-bench budget spoon-cup --budgets 0,200,1000 --exact -o out/budget");
	command->add_option("SCENE", options->scenes, "Scenes (default: the paper's three and the two piles)");
	command->add_option("--budgets", options->budgets,
						"Microseconds a step, see --in-tests (default: 12, from what coarsest answers take to twice the "
						"dearest ones without a budget)")
		->delimiter(',')
		->type_name("T,...")
		->check(between(0, 1e9));
	command->add_flag("--in-tests", options->areTests, "The budgets are hull and culling tests a step");
	cli::addFolder(*command, options->directory, "budget.csv, .txt, .json and a .png a scene");
	command->add_option("--steps", options->steps, "Steps of each run (default: the scene's)")
		->type_name("N")
		->check(CLI::Range(1, 10'000'000));
	addResolution(*command, options->resolution);
	addSelection(*command, options->selection);
	addCache(*command, options->cache);
	cli::addQuiet(*command, options->common);
	cli::addJson(*command, options->common);
	command->callback([options] { runBudget(*options); });
}
}  // namespace clod::demo
