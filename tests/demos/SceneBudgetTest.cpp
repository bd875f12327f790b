// SPDX-License-Identifier: GPL-3.0-or-later
// Budgets counted in tests, over the scenes they are meant for, at twelve values from what the coarsest answers take to twice
// what all answers do where they are dearest: none is exceeded but by the coarsest answers, more buys no worse an answer, and
// one with a little room changes nothing; bodies that come to rest come down to the metric. All runs are asked at the poses of one without a budget.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "demos/runner/BudgetRuns.h"
#include "demos/runner/SceneModels.h"
#include "demos/runner/Statistics.h"
#include "tests/demos/KeptHierarchies.h"
#include "tests/query/Questions.h"

namespace
{
using namespace clod;
using demo::BudgetRun;
using demo::BudgetRow;
using test::setting;

constexpr int kBudgets = 12;
constexpr double kComesDown = 0.137;  // of the dearest step, what stacks come down to the metric by: one more budget

double medianOf(const BudgetRun& run, double (*value)(const BudgetRow&))
{
	std::vector<double> values;
	for (const BudgetRow& row : run.rows) values.push_back(value(row));
	std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
	return values[values.size() / 2];
}
double tests(const BudgetRow& row)
{
	return double(row.tests);
}
double error(const BudgetRow& row)
{
	return row.contactError;
}

struct Asked
{
	demo::SceneSettings settings;
	const demo::SceneInfo* info = nullptr;
	int steps = 0;
	// In the order of `runs`; behind them one without a budget.
	std::vector<BudgetRun> operator()(std::vector<BudgetRun> runs) const
	{
		return demo::runUnderBudgets(*info, settings, steps, std::move(runs), [](double) {}).runs;
	}
};

class SceneBudgets : public testing::TestWithParam<const char*>
{
};

TEST_P(SceneBudgets, AreKeptAndWellSpent)
{
	Asked ask;
	ask.info = &demo::sceneNamed(GetParam());
	const int bodySteps = setting("CLOD_BUDGET_BODY_STEPS", 4000), bodies = int(ask.info->bodies.size());
	ask.steps = std::min({bodySteps / bodies, ask.info->steps, 240});
	ask.settings.models = demo::buildModels(*ask.info, {0.01 * setting("CLOD_SCENE_PERCENT", 3), false}, test::keptHierarchies());
	ask.settings.metric = ContactMetric::errorShare(0.005);
	ask.settings.dt = ask.info->dt;
	const ContactMetric metric = ask.settings.metric;
	const std::vector<BudgetRun> ends = ask({{{0, kOff}, metric, {}}});
	const BudgetRun &coarsest = ends[0], &whole = ends[1];
	ASSERT_GT(whole.rows.size(), 10U);
	double dearest = 0;
	for (const BudgetRow& row : whole.rows) dearest = std::max(dearest, double(row.tests));
	const double low = medianOf(coarsest, tests);
	ASSERT_GT(dearest, 5 * low);

	std::vector<BudgetRun> runs;
	for (int i = 0; i < kBudgets; ++i)
		runs.push_back({{std::floor(low * std::pow(2 * dearest / low, i / (kBudgets - 1.0))), kOff}, metric, {}});
	runs.push_back({{std::floor(kComesDown * dearest), kOff}, metric, {}});
	std::sort(runs.begin(), runs.end(), [](const BudgetRun& l, const BudgetRun& r) { return l.budget.tests < r.budget.tests; });
	runs = ask(std::move(runs));
	double before = std::numeric_limits<double>::infinity();
	for (std::size_t i = 0; i <= kBudgets; ++i)
	{
		const BudgetRun& run = runs[i];
		const double budget = run.budget.tests, now = medianOf(run, error);
		std::size_t same = 0;
		for (const BudgetRow& row : run.rows)
		{
			same += row.excess == 0;
			EXPECT_LE(row.tests, std::max(std::uint64_t(budget), row.coarsestTests)) << budget << ", step " << row.step;
		}
		std::printf("%-12s %8.0f: %8.0f tests, error %.3g, as without in %zu of %zu\n", GetParam(), budget,
					medianOf(run, tests), now, same, run.rows.size());
		EXPECT_LE(now, 1.05 * before) << budget;
		EXPECT_GE(double(same), budget > 1.2 * dearest ? 0.95 * double(run.rows.size()) : 0) << budget;
		const bool comesDown = ask.info->name == "pile-stacks" && budget >= std::floor(kComesDown * dearest);
		EXPECT_GE(double(same), comesDown ? 0.4 * double(run.rows.size()) : 0) << budget;
		before = now;
	}
	EXPECT_LT(before, medianOf(coarsest, error));
}

INSTANTIATE_TEST_SUITE_P(Scenes, SceneBudgets, testing::Values("spoon-cup", "torus-spiral", "numbers-bowl", "pile-stacks"));
}  // namespace
