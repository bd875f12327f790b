// SPDX-License-Identifier: GPL-3.0-or-later
// What a budget of a step holds back, spends and leaves, by work and by a clock that the tests move on.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clod/schedule/StepBudget.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
TEST(StepBudget, AStepThatWasCutShortMakesTheNextCoarser)
{
	StepBudget cut, whole;
	for (int step = 0; step < 10; ++step)
		for (StepBudget* budget : {&cut, &whole})
		{
			budget->begin({1000, kOff});
			budget->spend(900, budget == &cut);
			budget->end();
		}
	EXPECT_EQ(whole.coarsening(), 1);
	EXPECT_GT(cut.coarsening(), 1);
}

TEST(StepBudget, WhatLiesStillLeavesWhatOthersTookInTheStepBefore)
{
	StepBudget budget;
	for (int step = 0; step < 2; ++step)
	{
		budget.begin({1000, kOff});
		EXPECT_EQ(budget.spare().tests, step == 0 ? 1000 : 400);
		budget.spend(200, false);
		EXPECT_EQ(budget.spare().tests, step == 0 ? 800 : 400);
		budget.spendSpare(100);
		EXPECT_EQ(budget.spare().tests, step == 0 ? 700 : 300);
		budget.spend(400, false);
		EXPECT_EQ(budget.spare().tests, 300);
		budget.noneToCome();
		EXPECT_EQ(budget.spare().tests, 300);
		budget.end();
	}
	budget.begin({1000, kOff});
	budget.noneToCome();
	EXPECT_EQ(budget.spare().tests, 1000);
}

// Time that passes as the test says.
Clock::time_point g_now;
Clock::time_point toldNow()
{
	return g_now;
}
void pass(double microseconds)
{
	g_now += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::micro>(microseconds));
}
Budget ofTime(double microseconds)
{
	return {kOff, microseconds, &toldNow};
}

// Of time, at what the work of the step has taken so far: from the first step on.
TEST(StepBudget, HoldsBackWhatPointsWillTake)
{
	StepBudget budget;
	budget.begin(ofTime(1e6));
	budget.hold({10, 1000});
	budget.hold({10, 1000});
	pass(1000);
	budget.spend(100, false);  // 10 us each
	EXPECT_DOUBLE_EQ(budget.next({10, 1000}, 1000).microseconds, 1e6 - 1000 - 10 * 2020);
	EXPECT_DOUBLE_EQ(budget.next({10, 1000}, 3000).microseconds, 1e6 - 1000 - 10 * (1010 + 2000));
}

// Whatever stops the program for a while tells nothing of what a coarsening costs.
TEST(StepBudget, AStepThatWasHeldUpChangesNothing)
{
	StepBudget budget;
	const auto step = [&budget](double microseconds)
	{
		budget.begin(ofTime(3000));
		pass(microseconds);
		budget.spend(600, false);
		budget.spendPoints(400);
		budget.end();
	};
	for (int i = 0; i < 20; ++i) step(30);
	EXPECT_EQ(budget.coarsening(), 1);
	for (int i = 0; i < 3; ++i) step(20000);
	step(30);
	EXPECT_EQ(budget.coarsening(), 1);
}

// Pairs that want to spend many times the budget, or a little less than all of it, each step others; the work of each step
// takes its own time. What coarsest answers and their points take is held back up to half of the budget.
TEST(StepBudget, ATimeIsExceededByAtMostHalf)
{
	constexpr int kPairs = 40;
	constexpr std::uint32_t kListing = 5, kCoarsest = 10, kPoints = 60;
	const double ofCoarsest = kPairs * (kListing + kCoarsest + kPoints);
	Random random(3);
	double most = 0;
	int cut = 0, whole = 0;
	for (const double room : {1.0, 1.3, 2.0, 5.0, 20.0})
		for (const double wanted : {0.5, 1.0, 3.0, 30.0})
		{
			StepBudget budget;
			const double microseconds = 0.2 * room * ofCoarsest;
			for (int step = 0; step < 100; ++step)
			{
				const double ofOne = uniform(random, 0.15, 0.2);
				const auto work = [ofOne](double amount) { pass(ofOne * amount); };
				const Clock::time_point start = g_now;
				budget.begin(ofTime(microseconds));
				for (int i = 0; i < kPairs; ++i)
				{
					work(kListing);
					budget.list(kListing);
					budget.hold({kCoarsest, kPoints});
				}
				for (int i = 0; i < kPairs; ++i)
				{
					const double asked = wanted * room * ofCoarsest / kPairs * uniform(random, 0.2, 1.8);
					const std::uint32_t tests = std::uint32_t(asked / std::min(budget.coarsening(), 1e6));
					const double left = budget.next({kCoarsest, kPoints}, kPoints).microseconds / ofOne;
					const bool isCut = tests > left;
					const double done = isCut ? std::floor(left) + kCoarsest : tests;
					work(done);
					budget.spend(std::uint64_t(done), isCut);
					work(kPoints);
					budget.spendPoints(kPoints);
					++(isCut ? cut : whole);
				}
				budget.noneToCome();
				budget.end();
				most = std::max(most, microsecondsBetween(start, g_now) / microseconds);
			}
		}
	EXPECT_LE(most, 1.5);
	EXPECT_GT(most, 1);  // it is the held back that keeps it
	EXPECT_GT(cut, 1000);
	EXPECT_GT(whole, 1000);
}
}  // namespace clod::test
