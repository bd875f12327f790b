// SPDX-License-Identifier: GPL-3.0-or-later
// Budgets over whole steps: held by btClodDispatcher, shared out without it.
#include <gtest/gtest.h>

#include <algorithm>

#include "clod/bullet/WholeStep.h"
#include "tests/bullet/Toruses.h"

namespace clod::test
{
// A budget of time is reckoned by the pairs of nodes that answered.
TEST(BulletBudget, CountsWhatAnsweredAndMoreWithMore)
{
	Toruses world(true);
	world.run(120, kOff, 0);
	const std::uint64_t coarsest = world.answers();
	world.run(1, kOff, 1e9);
	EXPECT_GT(coarsest, 0u);
	EXPECT_GT(world.answers(), coarsest);
}

TEST(BulletBudget, AFullOneGivesTheTrajectoryOfNone)
{
	const std::uint64_t none = Toruses(false).run(120, kOff);
	EXPECT_EQ(Toruses(true).run(120, kOff), none);
	EXPECT_EQ(Toruses(true).run(120, 1e9), none);
	EXPECT_EQ(Toruses(true).run(120, 1e9, 1e12), none);
	EXPECT_EQ(Toruses(false).run(120, 1e9), none);
	EXPECT_EQ(Toruses(true).run(120, kOff, 1e12), none);  // from the second step on not refined (WholeStep.h)
	EXPECT_NE(Toruses(true).run(120, 300), none);         // the comparison sees a smaller one
}

TEST(WholeStep, IsTriedNearTheMetricAndKeptWhileItFits)
{
	WholeStep whole;
	EXPECT_FALSE(whole.isDue(100));
	whole.observeRefined(40, 100);
	EXPECT_FALSE(whole.isDue(100));
	whole.observeRefined(28, 100);
	ASSERT_TRUE(whole.isDue(100));
	whole.observeWhole(190, 100);  // the first may take twice as long
	ASSERT_TRUE(whole.isDue(100));
	for (int i = 0; i < 10; ++i) whole.observeWhole(99, 100);
	ASSERT_TRUE(whole.isDue(100));
	whole.observeWhole(101, 100);
	// One step later it is tried again; after attempts that fail three, seven, ... and at last 63 steps later.
	int waits = 1;
	for (int attempt = 0; attempt < 8; ++attempt)
	{
		for (int i = 0; i < waits; ++i)
		{
			EXPECT_FALSE(whole.isDue(100));
			whole.observeRefined(0, 100);
		}
		EXPECT_FALSE(whole.isDue(100));
		whole.observeRefined(0, 100);
		ASSERT_TRUE(whole.isDue(100));
		whole.observeWhole(201, 100);
		waits = std::min(2 * waits + 1, 63);
	}
}

TEST(WholeStep, IsNotTriedForWhatWasNotSeenToFit)
{
	WholeStep whole;
	whole.observeRefined(0, 0);
	EXPECT_FALSE(whole.isDue(0));
	EXPECT_FALSE(whole.isDue(100));
	whole.observeRefined(0, 100);
	EXPECT_TRUE(whole.isDue(100));
	EXPECT_FALSE(whole.isDue(99));  // not tried yet
	EXPECT_TRUE(whole.isDue(200));
	whole.observeWhole(190, 100);
	EXPECT_TRUE(whole.isDue(100));
	whole.observeWhole(60, 100);
	for (const double budget : {60.0, 80.0, 1e9}) EXPECT_TRUE(whole.isDue(budget)) << budget;
	for (const double budget : {0.0, 1e-9, 59.0}) EXPECT_FALSE(whole.isDue(budget)) << budget;
}

// Whatever fitted in before.
TEST(BulletBudget, NoTimeIsTheCoarsestAnswerAtEveryStep)
{
	const auto coarsest = [](Toruses& scene, int before, double microseconds, bool inTests)
	{
		scene.context.worldMetric = ContactMetric::deviationShare(0.1);  // so near that a whole step is tried
		scene.run(before, kOff, microseconds);
		return inTests ? scene.run(120, 0) : scene.run(120, kOff, 0);
	};
	for (const int before : {0, 60})
	{
		Toruses tests(true), time(true);
		const std::uint64_t expected = coarsest(tests, before, kOff, true);
		EXPECT_EQ(coarsest(time, before, 1e12, false), expected) << before;
		ASSERT_GT(time.look().excess, 1);
		ASSERT_LT(time.look().excess, 30);
	}
}

TEST(BulletBudget, TheSameBudgetGivesTheSameTrajectory)
{
	EXPECT_EQ(Toruses(true).run(120, 1500), Toruses(true).run(120, 1500));
}

TEST(BulletBudget, IsNeverExceededByAWholeStep)
{
	Toruses scene(true);
	scene.run(60, kOff);
	const Toruses::Step none = scene.detect(0), full = scene.detect(1e9);
	ASSERT_GT(none.contacts, 0u);
	EXPECT_GT(none.coarsest, 0u);
	EXPECT_EQ(full.pending, 0u);
	ASSERT_GT(full.tests, none.tests + 500);
	double excess = kOff;
	int cut = 0;
	for (double tests = double(none.tests) / 2; tests < 1.5 * double(full.tests); tests *= 1.15)
	{
		const Toruses::Step step = scene.detect(std::floor(tests));
		EXPECT_LE(step.tests, std::max(std::uint64_t(tests), none.tests));
		EXPECT_LE(step.excess, excess);
		excess = step.excess;
		cut += step.pending > 0;
	}
	EXPECT_GT(cut, 3);
}

// What the dispatcher cannot plan gets a share by what it needed last, and the rest is spent as ever.
TEST(BulletBudget, ChildrenOfCompoundsGetASharedPart)
{
	EXPECT_EQ(Toruses(true, 4, 2).run(120, 1e9), Toruses(false, 4, 2).run(120, kOff));
	EXPECT_EQ(Toruses(true, 4, 2).run(120, 1500), Toruses(true, 4, 2).run(120, 1500));
	for (const int compounds : {1, 2, 4})
	{
		Toruses scene(true, 4, compounds);
		scene.run(60, kOff);
		const auto settle = [&scene](double tests)
		{
			for (int i = 0; i < 5; ++i) scene.detect(tests);
			return scene.detect(tests);
		};
		const Toruses::Step none = settle(0), full = settle(1e9);
		EXPECT_EQ(full.pending, 0u);
		EXPECT_EQ(none.planned == 0, compounds == 4);
		EXPECT_LT(none.planned, none.tests);
		const double budget = std::floor(0.5 * double(none.tests + full.tests));
		const Toruses::Step half = settle(budget);
		EXPECT_GT(half.pending, 0u);
		EXPECT_EQ(half.planned > none.planned, compounds < 4);
		EXPECT_LT(half.tests - half.planned, full.tests - full.planned);
		EXPECT_GT(half.tests - half.planned, none.tests - none.planned);
		EXPECT_LE(double(half.planned), budget - scene.context.unplannedShare());
		EXPECT_LT(double(half.tests), 1.25 * budget);
		EXPECT_GT(double(half.tests), 0.5 * budget);
	}
}

// By time, without the dispatcher: none is the coarsest answer, plenty is all of it, whoever shares it.
TEST(BulletBudget, SharesOfTimeRunFromTheCoarsestAnswerToTheWholeOne)
{
	for (const int compounds : {0, 2})
	{
		EXPECT_EQ(Toruses(false, 4, compounds).run(120, kOff, 0), Toruses(false, 4, compounds).run(120, 0));
		EXPECT_EQ(Toruses(false, 4, compounds).run(120, kOff, 1e12), Toruses(false, 4, compounds).run(120, kOff));
		Toruses scene(false, 4, compounds);
		scene.run(60, kOff);
		const Toruses::Step none = scene.detect(0);
		// A pair's own answer cannot tell how long it took, but what it bought lies between the two.
		for (const double microseconds : {0.0, 1.0, 30.0, 1000.0, 1e9})
		{
			scene.context.budget.microseconds = microseconds;
			for (int i = 0; i < 4; ++i)
			{
				const Toruses::Step step = scene.detect(kOff);
				EXPECT_GE(step.tests, none.tests);
				EXPECT_LE(step.excess, none.excess);
				EXPECT_TRUE(microseconds > 0 || step.tests == none.tests);
				EXPECT_TRUE(microseconds < 1e9 || step.pending == 0);
			}
		}
	}
}

// World, shape and pair, from step to step: a full budget still gives what none does.
TEST(BulletBudget, MetricsMayChangeWithEveryStep)
{
	const auto run = [](bool planned, double tests)
	{
		Toruses scene(planned);
		const btRigidBody& special = scene.body(3);
		int step = 0;
		scene.context.pairMetric = [&](const btCollisionObject& a, const btCollisionObject& b, ContactMetric& metric)
		{
			metric = ContactMetric::deviationShare(0.3);
			return step % 4 > 1 && (&a == &special || &b == &special);
		};
		std::uint64_t hash = 0;
		for (; step < 120; ++step)
		{
			scene.context.worldMetric = step % 3 == 0   ? ContactMetric::deviationShare(0.01)
										: step % 3 == 1 ? ContactMetric::errorShare(0.02)
														: ContactMetric::velocityFactor(1);
			if (step % 40 == 20) scene.shape().setMetric(ContactMetric::exactly());
			if (step % 40 == 30) scene.shape().clearMetric();
			hash = 31 * hash + scene.run(1, tests);
		}
		return hash;
	};
	const std::uint64_t none = run(false, kOff);
	EXPECT_EQ(run(true, 1e9), none);
	EXPECT_EQ(run(false, 1e9), none);
	EXPECT_NE(run(true, 300), none);
	EXPECT_EQ(run(true, 300), run(true, 300));
}

// Planned pairs whose bodies leave, return, or are not dispatched after all.
TEST(BulletBudget, BodiesComeAndGoBetweenPlannedSteps)
{
	const auto run = [](bool planned, double tests)
	{
		Toruses scene(planned);
		std::uint64_t hash = 0;
		for (int step = 0; step < 90; ++step)
		{
			scene.setPresent(1, step % 30 < 20);
			scene.setPresent(4, step % 20 < 15);  // one that others lie on
			const bool isFiltered = step % 7 == 3;
			scene.setNearCallback(isFiltered ? [](btBroadphasePair&, btCollisionDispatcher&, const btDispatcherInfo&) {}
											 : &btCollisionDispatcher::defaultNearCallback);
			hash = 31 * hash + scene.run(1, tests);
			EXPECT_LE(scene.context.lastStep().pairs, 4U);
		}
		scene.setPresent(1, false);
		scene.setPresent(4, false);
		EXPECT_LE(scene.context.lastStep().pairs, 2U);
		return hash;
	};
	const std::uint64_t none = run(false, kOff);
	EXPECT_EQ(run(true, 1e9), none);
	EXPECT_EQ(run(false, 1e9), none);
	EXPECT_EQ(run(true, 400), run(true, 400));
}

// Each has its budget, and neither takes from the other's.
TEST(BulletBudget, WorldsMayShareAContext)
{
	for (const double tests : {kOff, 1500.0})
	{
		Toruses alone(true), aloneToo(true, 2);
		Context shared;
		Toruses first(true, 4, 0, &shared), second(true, 2, 0, &shared);
		for (int step = 0; step < 60; ++step)
		{
			ASSERT_EQ(first.run(1, tests), alone.run(1, tests)) << step;
			ASSERT_EQ(second.run(1, tests), aloneToo.run(1, tests)) << step;
		}
		EXPECT_EQ(shared.lastStep().pairs, alone.context.lastStep().pairs + aloneToo.context.lastStep().pairs);
		EXPECT_EQ(first.look().tests, alone.look().tests + aloneToo.look().tests);
	}
}

// One queue over all pairs: no pair is refined while another exceeds its metric by more.
TEST(BulletBudget, GoesToTheWorstPairFirst)
{
	Toruses scene(true);
	scene.run(60, kOff);
	const Toruses::Step none = scene.detect(0), full = scene.detect(1e9);
	const Toruses::Step half = scene.detect(std::floor(0.5 * double(none.tests + full.tests)));
	ASSERT_GT(half.pending, 0u);
	EXPECT_LT(half.excess, none.excess);
	Toruses shared(false);
	shared.run(60, kOff);
	shared.detect(double(none.tests + full.tests) / 2);
	const Toruses::Step shares = shared.detect(double(none.tests + full.tests) / 2);
	EXPECT_LE(half.excess, shares.excess);
}

// Pairs of very different metrics, each with all it can do at every budget: while one exceeds its metric by more than
// another did at first, that other is not touched.
TEST(BulletBudget, RefinesNoPairWhileAnotherIsWorse)
{
	Toruses scene(true);
	scene.run(60, kOff);
	scene.context.pairMetric = [&scene](const btCollisionObject& a, const btCollisionObject& b, ContactMetric& metric)
	{
		double share = 1e-4;
		for (std::size_t i = 0; i < 4; ++i)
			if (&a == &scene.body(2 * i + 1) || &b == &scene.body(2 * i + 1)) share *= i == 0 ? 8 : i == 2 ? 64 : 1;
		metric = ContactMetric::deviationShare(share);
		return true;
	};
	const auto excesses = [&scene](double tests)
	{
		scene.detect(tests);
		std::vector<double> all;
		scene.context.forEachPair([&all](const PairReport& pair) { all.push_back(pair.result->excess); });
		return all;
	};
	const std::vector<double> none = excesses(0);
	ASSERT_EQ(none.size(), 4u);
	int waited = 0;
	const Toruses::Step least = scene.detect(0), full = scene.detect(1e9);
	for (double tests = double(least.tests); tests < double(full.tests); tests *= 1.1)
	{
		const std::vector<double> now = excesses(std::floor(tests));
		for (std::size_t i = 0; i < now.size(); ++i)
			for (std::size_t other = 0; other < now.size(); ++other)
			{
				EXPECT_TRUE(now[other] <= none[i] || now[i] == none[i])
					<< "with " << tests << " tests: " << now[i] << " of " << none[i] << ", but " << now[other];
				waited += now[other] < none[other] && now[i] == none[i] && none[i] > 0;
			}
	}
	EXPECT_GT(waited, 10);
}

TEST(BulletBudget, SharesStayNearTheBudget)
{
	Toruses scene(false);
	scene.run(60, kOff);
	const Toruses::Step none = scene.detect(0), full = scene.detect(1e9);
	const double budget = std::floor(0.5 * double(none.tests + full.tests));
	Toruses::Step step;
	for (int i = 0; i < 5; ++i) step = scene.detect(budget);
	EXPECT_LT(double(step.tests), 1.5 * budget);
	EXPECT_GT(double(step.tests), 0.3 * budget);
}

TEST(BulletBudget, TheCoarsestAnswersCarryBodiesToo)
{
	Toruses exact(true), coarsest(true), hurried(true);
	exact.run(240, kOff);
	coarsest.run(240, 0);
	hurried.run(240, kOff, 0);  // no time at all
	std::printf("heights %.4f %.4f %.4f\n", exact.height(), coarsest.height(), hurried.height());
	EXPECT_NEAR(coarsest.height(), exact.height(), 0.1);
	EXPECT_NEAR(hurried.height(), exact.height(), 0.1);
}

// What was cut short answers no dispatch that may cost more, however still the bodies lie.
TEST(BulletBudget, ACoarseAnswerEndsWithItsBudget)
{
	for (const double microseconds : {kOff, 1e12})  // the whole step of WholeStep.h has no budget either
	{
		Toruses scene(true);
		scene.context.worldMetric = ContactMetric::deviationShare(0.1);
		scene.run(60, kOff);
		const Toruses::Step full = scene.detect(1e9);
		scene.context.budget = {kOff, 0};
		const Toruses::Step coarse = scene.detect(kOff);
		ASSERT_GT(coarse.excess, 0);
		ASSERT_LT(coarse.excess, 30);  // near enough for a whole step
		scene.context.budget = {kOff, microseconds};
		const Toruses::Step free = scene.detect(kOff);
		EXPECT_EQ(free.excess, 0) << microseconds;
		EXPECT_EQ(free.contacts, full.contacts) << microseconds;
		// And the other way round: a budget is held although a finer answer is at hand.
		scene.context.budget = {};
		const Toruses::Step none = scene.detect(0);
		EXPECT_EQ(none.contacts, coarse.contacts) << microseconds;
		EXPECT_EQ(none.excess, coarse.excess) << microseconds;
	}
}

TEST(BulletBudget, OneThatCannotBeUsedIsSaidAndNotUsed)
{
	Toruses scene(true);
	scene.run(30, kOff);
	std::vector<std::string> said;
	scene.context.warn = [&said](const std::string& message) { said.push_back(message); };
	const Toruses::Step full = scene.detect(1e9), bad = scene.detect(-1);
	EXPECT_EQ(bad.contacts, full.contacts);
	ASSERT_FALSE(said.empty());
	EXPECT_NE(said[0].find("budget.tests"), std::string::npos) << said[0];
}
}  // namespace clod::test
