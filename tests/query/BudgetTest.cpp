// SPDX-License-Identifier: GPL-3.0-or-later
// Queries under a budget: any budget answers, none is exceeded, a full one changes nothing, more is never coarser.
#include <gtest/gtest.h>

#include <cmath>

#include "clod/query/AnswerCost.h"
#include "tests/query/Answers.h"
#include "tests/query/TriangleGap.h"

namespace
{
using namespace clod;
using namespace clod::test;

const std::vector<BodyPair>& pairs()
{
	static const std::vector<BodyPair> all = {{body("torus", 900), body("torus", 900)},
											  {body("number8", 600), body("sphere", 300)}};
	return all;
}

// One of several metrics, all of which are not met by the coarsest answer.
Settings anySettings(Random& random, double radius)
{
	Settings settings;
	settings.tolerance = uniform(random, 0.001, 0.02) * radius;
	settings.contactsOnly = random() % 2;
	if (random() % 2) settings.sweep = {0.02 * radius * randomDirection(random), 0.02 * randomDirection(random)};
	switch (random() % 5)
	{
		case 0:
			settings.metric.exact = true;
			break;
		case 1:
			settings.metric.weightedDeviation = std::pow(10, uniform(random, -4, -1)) * radius;
			break;
		case 2:
			settings.metric.maxError = std::pow(10, uniform(random, -3, -1)) * radius;
			break;
		case 3:
			settings.metric.view = {1, radius * randomDirection(random), 0.01, 0};
			break;
		default:
			settings.metric.weightedDeviation = 0.01 * radius;
			settings.metric.velocity = {1, 1e-4 * radius, {0.02 * radius, 0, 0}, {0, 0.05, 0}};
			settings.metric.maxError = 0.02 * radius;
	}
	if (random() % 4 == 0) settings.gapError = uniform(random, 0, 0.01) * radius;
	return settings;
}

Settings with(Settings settings, double tests)
{
	settings.budget.tests = tests;
	return settings;
}
std::uint64_t testsOf(const GapResult& result)
{
	return std::uint64_t(result.stats.boxTests) + result.stats.hullTests;
}

template <class Check>
void forEachPose(std::uint64_t seed, int poses, const Check& check)
{
	Random random(seed);
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < poses; ++i)
		{
			const Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, -0.02, 0.01));
			check(random, pair, pose, anySettings(random, smallerRadius(pair.a, pair.b)));
		}
}

TEST(Budget, AFullOneEqualsTheUnbudgetedQueryBitForBit)
{
	int withContacts = 0, searched = 0;
	const auto check = [&](Random&, const BodyPair& pair, const Transform& pose, const Settings& settings)
	{
		const GapResult expected = fresh(pair, pose, settings);
		const GapResult result = fresh(pair, pose, with(settings, 1e9));
		EXPECT_EQ(difference(result, expected), "") << "exact " << settings.metric.exact;
		EXPECT_EQ(result.excess, 0);
		EXPECT_EQ(result.stats.gapSearches, expected.stats.gapSearches);
		withContacts += !result.contacts.empty();
		searched += expected.stats.gapSearches > 0;
	};
	forEachPose(31, 40, check);
	EXPECT_GT(withContacts, 40);
	EXPECT_GT(searched, 0);
}

TEST(Budget, NoneGivesTheCoarsestValidAnswer)
{
	int coarser = 0;
	const auto check = [&](Random&, const BodyPair& pair, const Transform& pose, Settings settings)
	{
		settings.contactsOnly = false;
		settings.gapError = kOff;  // the certificate of the nodes
		const GapResult withGap = fresh(pair, pose, with(settings, 0));
		settings.contactsOnly = true;  // how exactly a depth is searched depends on maxError
		const GapResult result = fresh(pair, pose, with(settings, 0));
		const GapResult full = fresh(pair, pose, settings);
		settings.metric = Metric{};
		EXPECT_EQ(difference(result, fresh(pair, pose, settings)), "");
		// A pair that touches has an answer, unless the finer levels are out of reach of the coarser ones' certificate.
		if (result.contacts.empty() && !full.contacts.empty())
		{
			EXPECT_TRUE(withGap.contacts.empty());
			EXPECT_LT(settings.tolerance - withGap.errorBound, full.contacts[0].lower);
		}
		coarser += result.excess > 1;
	};
	forEachPose(32, 20, check);
	EXPECT_GT(coarser, 10);
}

TEST(Budget, IsNeverExceededAndMoreIsNeverCoarser)
{
	int bound = 0;
	double used = 0, given = 0;
	const auto check = [&](Random&, const BodyPair& pair, const Transform& pose, Settings settings)
	{
		settings.contactsOnly = true;  // the search of a depth is not in the budget
		const std::uint64_t least = testsOf(fresh(pair, pose, with(settings, 0)));
		double excess = kOff;
		std::uint32_t opened = 0;
		for (double tests = 4; tests < 1e5; tests *= 1.7)
		{
			const GapResult result = fresh(pair, pose, with(settings, std::floor(tests)));
			ASSERT_LE(testsOf(result), std::max(std::uint64_t(tests), least)) << tests;
			EXPECT_LE(result.excess, excess);
			EXPECT_GE(result.stats.frontInner, opened);
			excess = result.excess;
			opened = result.stats.frontInner;
			if (result.excess > 0 && tests > double(least))
			{
				++bound;
				used += double(testsOf(result));
				given += std::floor(tests);
			}
		}
	};
	forEachPose(33, 8, check);
	EXPECT_GT(bound, 20);
	EXPECT_GT(used, 0.7 * given);  // and what is given is used
}

TEST(Budget, ItsErrorIsStillCertified)
{
	int proved = 0;
	const auto check = [&](Random& random, const BodyPair& pair, const Transform& pose, Settings settings)
	{
		settings.contactsOnly = false;
		const double radius = smallerRadius(pair.a, pair.b);
		const GapResult result = fresh(pair, pose, with(settings, std::pow(10, uniform(random, 0, 4))));
		if (!std::isfinite(result.errorBound)) return;
		const GapInterval truth = triangleGap(pair.a.triangles, pair.b.triangles, pose, 1e-3 * radius);
		if (std::isfinite(result.minDistance))
		{
			EXPECT_LE(result.minDistance - result.errorBound, truth.high + 1e-8);
			EXPECT_GE(result.minDistance + result.errorBound, truth.low - 1e-8);
		}
		else
			EXPECT_GT(truth.high, settings.tolerance - result.errorBound - 1e-9);
		++proved;
	};
	forEachPose(34, 8, check);
	EXPECT_GT(proved, 5);
}

// Budgets, metrics and the use of a budget at all change from step to step: caches never show.
TEST(Budget, CachedEqualsFreshBitForBit)
{
	Random random(35);
	for (const BodyPair& pair : pairs())
	{
		const double radius = smallerRadius(pair.a, pair.b);
		GapCache cache;
		GapResult result;
		Settings settings = anySettings(random, radius);
		Transform pose = poseWithGap(random, pair.a, pair.b, 0);
		int cut = 0, again = 0;
		for (int step = 0; step < 250; ++step)
		{
			const double size = std::pow(10, uniform(random, -6, -2));
			if (random() % 3)
			{
				pose.rotation = randomRotation(random, size) * pose.rotation;
				pose.translation += size * radius * randomDirection(random);
			}
			else
				++again;
			if (random() % 5 == 0) settings = anySettings(random, radius);
			if (random() % 2)
				settings.budget.tests = random() % 3 ? std::floor(std::pow(10, uniform(random, 0, 5))) : kOff;
			query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
			const GapResult expected = fresh(pair, pose, settings);
			ASSERT_EQ(difference(result, expected), "") << "step " << step;
			ASSERT_EQ(result.excess, expected.excess) << "step " << step;
			cut += result.excess > 0;
		}
		EXPECT_GT(cut, 20);
		EXPECT_GT(again, 20);
	}
}

TEST(Budget, ATimeOfZeroIsTheCoarsestAnswerAndALongOneChangesNothing)
{
	const auto check = [&](Random&, const BodyPair& pair, const Transform& pose, Settings settings)
	{
		const GapResult unbudgeted = fresh(pair, pose, settings), coarsest = fresh(pair, pose, with(settings, 0));
		settings.budget.microseconds = 0;
		EXPECT_EQ(difference(fresh(pair, pose, settings), coarsest), "");
		settings.budget.microseconds = 1e9;
		EXPECT_EQ(difference(fresh(pair, pose, settings), unbudgeted), "");
	};
	forEachPose(36, 5, check);
}

// A fixed cost, a peak in between, and what was seen too long ago to count.
TEST(AnswerCost, IsAStraightLineBetweenWhatWasSeenLately)
{
	AnswerCost cost(10);
	EXPECT_EQ(cost.estimate(5), 50);
	cost.observe(10, 100);
	cost.observe(100, 280);
	cost.observe(0, 1e9);  // no answers tell nothing
	EXPECT_DOUBLE_EQ(cost.estimate(10), 100);
	EXPECT_DOUBLE_EQ(cost.estimate(55), 190);
	EXPECT_DOUBLE_EQ(cost.estimate(200), 560);
	EXPECT_DOUBLE_EQ(cost.estimate(5), 50);
	cost.observe(40, 900);
	EXPECT_DOUBLE_EQ(cost.estimate(40), 900);
	EXPECT_DOUBLE_EQ(cost.estimate(25), 500);
	for (int i = 0; i < 121; ++i) cost.observe(10, 120);
	EXPECT_DOUBLE_EQ(cost.estimate(40), 480);
}

// A plan is a query in two parts, whatever is refined between; a query for anything else drops it.
TEST(QueryPlan, IsFinishedByTheNextQuery)
{
	const OwnThreshold own = [](const Place&) { return 1e-4; };
	int refined = 0;
	const auto check = [&](Random& random, const BodyPair& pair, const Transform& pose, Settings settings)
	{
		if (random() % 3 == 0) settings.metric.own = &own;
		settings.contactsOnly = true;
		const GapResult expected = fresh(pair, pose, settings);
		settings = with(settings, 0);
		GapCache cache;
		GapResult result;
		const auto finish = [&](const Transform& at) -> const GapResult&
		{
			query(*pair.a.hierarchy, *pair.b.hierarchy, at, settings, cache, result);
			return result;
		};
		QueryPlan plan(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache.pair);
		const std::uint64_t least = plan.committed();
		EXPECT_LE(testsOf(fresh(pair, pose, settings)), least);
		while (plan.excess() > 0)
		{
			const std::uint64_t most = plan.committed() + plan.cost();
			plan.refine();
			ASSERT_LE(plan.committed(), most);
			++refined;
		}
		const std::uint64_t committed = plan.committed();
		if (expected.stats.gapSearches == 0)
		{
			EXPECT_EQ(difference(finish(pose), expected), "");
			EXPECT_LE(testsOf(result), committed);
			EXPECT_GE(2 * testsOf(result), committed);
		}
		QueryPlan dropped(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache.pair);
		while (dropped.excess() > 0) dropped.refine();
		Transform other = pose;
		other.translation.x += 1e-3 * smallerRadius(pair.a, pair.b);
		EXPECT_EQ(difference(finish(other), fresh(pair, other, settings)), "");
	};
	forEachPose(37, 6, check);
	EXPECT_GT(refined, 100);
}

// A plan that no query finishes leaves the last result behind: it is that of another pose.
TEST(QueryPlan, WhatIsDroppedAnswersNothing)
{
	const BodyPair& pair = pairs()[0];
	const double radius = smallerRadius(pair.a, pair.b);
	Settings settings;
	settings.tolerance = 0.01 * radius;
	settings.metric.weightedDeviation = 0.03 * radius;
	settings.contactsOnly = true;
	Transform near, far;
	near.translation = {0.3 * radius, 0, 0};
	far.translation = {20 * radius, 0, 0};
	for (const double tests : {1e9, 1e4, kOff})
	{
		GapCache cache;
		GapResult result;
		query(*pair.a.hierarchy, *pair.b.hierarchy, far, with(settings, 0), cache, result);
		ASSERT_TRUE(result.contacts.empty());
		{
			QueryPlan dropped(*pair.a.hierarchy, *pair.b.hierarchy, near, with(settings, 0), cache.pair);
		}
		query(*pair.a.hierarchy, *pair.b.hierarchy, near, with(settings, tests), cache, result);
		EXPECT_FALSE(result.contacts.empty());
		EXPECT_EQ(difference(result, fresh(pair, near, with(settings, tests))), "") << tests;
	}
}

TEST(Budget, RefusesWhatCannotBeUsedByName)
{
	for (const double bad : {-1.0, std::nan("")})
	{
		Settings settings = with({}, bad);
		EXPECT_NE(settingsError(settings).find("budget.tests"), std::string::npos);
		settings.budget = {kOff, bad};
		EXPECT_NE(settingsError(settings).find("budget.microseconds"), std::string::npos);
	}
	Settings settings = with({}, 100);
	EXPECT_EQ(settingsError(settings), "");
	settings.distance = true;
	EXPECT_NE(settingsError(settings).find("distance"), std::string::npos);
}
}  // namespace
