// SPDX-License-Identifier: GPL-3.0-or-later
// Which coarsening a budget buys, against bodies whose cost is known: a power of the factor, with noise and steps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "clod/schedule/BudgetControl.h"
#include "clod/schedule/StepBudget.h"
#include "tests/query/Bodies.h"

namespace
{
using namespace clod;
using namespace clod::test;

// What a step costs at a factor.
struct Plant
{
	double fixed, least, exponent;  // least + fixed factor^-exponent
	double at(double factor) const { return least + (factor < kOff ? fixed * std::pow(factor, -exponent) : 0); }
};

struct Outcome
{
	double over = 0, median = 0;  // share of the steps over the budget; of the factors
	double most = 0;
};
Outcome run(BudgetControl& control, const Plant& plant, const Budget& budget, int steps, double noise = 0)
{
	Random random(5);
	std::vector<double> factors;
	Outcome outcome;
	for (int i = 0; i < steps; ++i)
	{
		const double factor = control.coarsening(budget);
		const double wanted = plant.at(factor) * (1 + noise * uniform(random, -1, 1));
		const double most = std::min(budget.tests, budget.microseconds);
		const bool isCut = wanted > most;  // then so much is spent, and the coarsest answer given
		const double spent = isCut ? std::max(most, plant.least) : wanted;
		control.observe({budget.tests < kOff ? spent : 0, budget.microseconds < kOff ? spent : 1, isCut});
		factors.push_back(factor);
		outcome.over += isCut ? 1.0 / steps : 0;
	}
	outcome.most = *std::max_element(factors.begin(), factors.end());
	std::nth_element(factors.begin(), factors.begin() + steps / 2, factors.end());
	outcome.median = factors[std::size_t(steps) / 2];
	return outcome;
}

TEST(BudgetControl, FindsTheFactorThatFits)
{
	for (const double exponent : {0.4, 0.5, 1.0})
		for (const double noise : {0.0, 0.2})
			for (const double budget : {60.0, 200.0, 900.0, 4000.0})
			{
				const Plant plant{5000, 20, exponent};
				const double ideal = std::pow(5000 / (budget - 20), 1 / exponent);
				for (const Budget& given : {Budget{budget, kOff}, Budget{kOff, budget}})
				{
					BudgetControl control;
					run(control, plant, given, 300, noise);
					const Outcome outcome = run(control, plant, given, 2000, noise);
					EXPECT_LT(outcome.over, 0.07) << budget << " " << exponent << " " << noise;
					EXPECT_LE(outcome.median, ideal * std::pow(2, 0.5 + (0.25 + noise) / exponent)) << budget << " " << exponent << " " << noise;
				}
			}
}

// Levels that differ by a factor of two in cost, and the first step at a factor takes half as much again: what is cut short
// then is not too dear.
TEST(BudgetControl, AFirstStepMayCostMore)
{
	BudgetControl control;
	double before = 0;
	int fits = 0;
	for (int i = 0; i < 1000; ++i)
	{
		const double factor = control.coarsening({1000, kOff}), level = std::floor(std::log2(factor));
		const double wanted = 3600 / std::exp2(level) * (factor == before ? 1 : 1.5);
		before = factor;
		control.observe({std::min(wanted, 1000.0), 1, wanted > 1000});
		fits += i >= 200 && level == 2 && wanted <= 1000;
	}
	EXPECT_GT(fits, 700);
}

// A hundred pairs that are cheap once answered at a factor: fewer are cut in each step, until none is. Where they stay dear
// as many are cut as before, and it does not end.
TEST(BudgetControl, GoesOnWhileFewerPairsAreCut)
{
	for (const bool ends : {true, false})
	{
		BudgetControl control;
		double before = 0, finest = kOff;
		int known = 0;
		for (int i = 0; i < 200; ++i)
		{
			const double factor = control.coarsening({1000, kOff});
			known = factor == before && (ends || known == 0) ? known : 0;  // pairs
			before = factor;
			const double ofNew = 50 / factor, ofKnown = 5 / factor;
			const int most = int((1000 - known * ofKnown) / ofNew), fresh = std::min(100 - known, most);
			StepCost cost;
			cost.answered = std::uint32_t(known + fresh);
			cost.cut = 100 - cost.answered;
			cost.tests = cost.cut > 0 ? 1000 : known * ofKnown + fresh * ofNew;
			cost.microseconds = 1;
			known += fresh;
			control.observe(cost);
			if (i >= 150) finest = std::min(finest, cost.cut > 0 ? kOff : factor);
		}
		EXPECT_LT(finest, ends ? 2 : 10);
		EXPECT_GT(finest, ends ? 0 : 4);
	}
}

// What a change cut off in several steps would be cut off again: however cheap the next steps are, nothing finer is tried
// in three times as many.
TEST(BudgetControl, RestsAfterAChangeThatCut)
{
	BudgetControl control;
	double before = 0, settled = 0;
	int known = 0, cutInARow = 0, rest = 0, rests = 0;
	for (int i = 0; i < 200; ++i)
	{
		const double factor = control.coarsening({1000, kOff});
		if (rest > 0)
		{
			EXPECT_GE(factor, settled) << i;
		}
		known = factor == before ? known : 0;  // pairs
		before = factor;
		const double ofNew = 180 / factor, ofKnown = 18 / factor;
		const int fresh = std::min(100 - known, int((1000 - known * ofKnown) / ofNew));
		StepCost cost;
		cost.answered = std::uint32_t(known + fresh);
		cost.cut = 100 - cost.answered;
		cost.tests = cost.cut > 0 ? 1000 : rest > 0 ? 1 : known * ofKnown + fresh * ofNew;
		cost.microseconds = 1;
		known += fresh;
		control.observe(cost);
		rest = std::max(0, rest - 1);
		if (cost.cut == 0 && cutInARow > 1)
		{
			rest = std::min(10, 3 * (cutInARow - 1));
			settled = factor;
			++rests;
		}
		cutInARow = cost.cut > 0 ? cutInARow + 1 : 0;
	}
	EXPECT_GT(rests, 0);
}

// Of 33 pairs one was answered, twice: all would have cost some 30 times the budget. Factors a little coarser need not be
// tried.
TEST(BudgetControl, KnowsByThePairsAnsweredWhatAllWouldCost)
{
	BudgetControl control;
	StepCost cost;
	cost.tests = 1000;
	cost.ofCut = 100;
	cost.answered = 1;
	cost.cut = 32;
	for (int i = 0; i < 2; ++i)
	{
		EXPECT_EQ(control.coarsening({1000, kOff}), 1);
		control.observe(cost);
	}
	EXPECT_GT(control.coarsening({1000, kOff}), 4);
}

// Where bodies meet all factors cost more, and as little as before when they part.
TEST(BudgetControl, APeakIsSoonForgotten)
{
	BudgetControl control;
	for (int i = 0; i < 200; ++i)
	{
		const bool isPeak = i >= 100 && i < 130;
		const double factor = control.coarsening({1000, kOff}), wanted = (isPeak ? 3000 : 500) * std::pow(factor, -0.5);
		control.observe({std::min(wanted, 1000.0), 1, wanted > 1000});
		EXPECT_TRUE(i != 129 || factor > 4) << factor;
		EXPECT_TRUE((i >= 100 && i < 145) || factor == 1) << factor << " in step " << i;
	}
}

TEST(BudgetControl, EnoughIsNoCoarseningAtAll)
{
	BudgetControl control;
	EXPECT_EQ(run(control, {5000, 20, 0.5}, {6100, kOff}, 500, 0.2).most, 1);
	// Nor is a rare step that is cut short.
	BudgetControl other;
	for (int i = 0; i < 500; ++i)
	{
		EXPECT_EQ(other.coarsening({1000, kOff}), 1);
		other.observe({i % 25 == 12 ? 1000.0 : 600, 1, i % 25 == 12});
	}
}

TEST(BudgetControl, NoneIsNoneAndNothingIsTheCoarsest)
{
	BudgetControl control;
	const Plant plant{5000, 20, 0.5};
	EXPECT_EQ(run(control, plant, {}, 10).most, 1);
	for (const Budget& nothing : {Budget{0, kOff}, Budget{kOff, 0}})
	{
		EXPECT_EQ(control.coarsening(nothing), kOff);
		control.observe({20, 20, true});
		run(control, plant, nothing, 20);
		EXPECT_EQ(control.coarsening(nothing), kOff);
		control.observe({20, 20, true});
		EXPECT_EQ(control.coarsening({1e9, 1e9}), 1);  // what is plenty is so at once
		control.observe({5020, 20, false});
		EXPECT_EQ(control.coarsening({}), 1);
		control.observe({5020, 20, false});
	}
}

// Where each finer level costs far more than the one before, it is tried again later and later.
TEST(BudgetControl, WhatDoesNotFitIsTriedSeldom)
{
	BudgetControl control;
	int tries = 0;
	for (int i = 0; i < 2000; ++i)
	{
		const bool isCut = control.coarsening({1000, kOff}) < 8;
		control.observe({isCut ? 1000.0 : 50.0, 1, isCut});
		tries += i > 300 && isCut;
	}
	EXPECT_LT(tries, 30);
	EXPECT_GT(tries, 0);
}

// What waits gets what is left once all others have taken as much as in the last step; or have taken more already.
TEST(StepBudget, WhatWaitsLeavesWhatTheLastStepTook)
{
	StepBudget step;
	const Budget budget{1000, kOff};
	step.begin(budget);
	step.spend(600, false);
	step.end();
	step.begin(budget);
	step.spend(200, false);
	EXPECT_EQ(step.spare().tests, 1000 - 600);
	step.spend(500, false);
	EXPECT_EQ(step.spare().tests, 1000 - 700);
	step.noneToCome();
	EXPECT_EQ(step.spare().tests, 1000 - 700);
}
}  // namespace
