// SPDX-License-Identifier: Zlib
// A scene under budgets: what a step's collision dispatch takes against what it was given, and how far its
// contacts may then be off.
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "demos/scenes/Scene.h"

namespace clod::demo
{
// A step in which bodies touch.
struct BudgetRow
{
	int step = 0;
	double dispatchMicroseconds = 0;  // wall time of the whole dispatch, broadphase included
	double contactError = 0, excess = 0;
	std::uint64_t tests = 0, coarsestTests = 0;
};

// One run, under one budget a step for all pairs, of one metric.
struct BudgetRun
{
	Budget budget;
	ContactMetric metric;
	std::vector<BudgetRow> rows;
};

struct SceneUnderBudgets
{
	std::string scene;
	double radius = 0;  // the smallest of its models: unit of every percentage
	std::vector<BudgetRun> runs;
};

// Simulates the scene without a budget, then dispatches every step again, from the same poses and velocities, as each
// of the runs says, and fills in its rows; a run without a budget, of the scene's metric, is added as the last.
SceneUnderBudgets runUnderBudgets(const SceneDefinition& scene, const SceneSettings& settings, int steps,
								  std::vector<BudgetRun> runs, const std::function<void(double fraction)>& progress);

// Of a run under a budget of nothing: at most twelve, by equal factors from the median of what its steps took to twice
// what the dearest step without a budget took, or of microseconds all but the dearest twentieth.
std::vector<double> budgetsBetween(const SceneUnderBudgets& ends, bool areTests);

// One element a run: budget (null: none) in microseconds or tests, steps, dispatch_us, tests, over (what was used less
// the budget), share_over (more than a tenth over the budget), error_percent and excess as spreads.
nlohmann::ordered_json toJson(const SceneUnderBudgets& scene);
std::string formatCsv(const std::vector<SceneUnderBudgets>& scenes);         // a row a step that touches
std::string formatTable(const std::vector<nlohmann::ordered_json>& scenes);  // of toJson's
// Of one of toJson's: what a step's dispatch took above, its certified error below, both over the budget. Empty, or why
// there is no plot.
std::string plotBudget(const nlohmann::ordered_json& scene, const std::string& path);
}  // namespace clod::demo
