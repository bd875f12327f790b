// SPDX-License-Identifier: GPL-3.0-or-later
// Coarsening and hard stops: one factor on all limits is those limits so many times as large; what a budget cuts short is the
// coarsest valid answer, which is in the budget unless it alone exceeds it. Which factor a budget buys: BudgetControlTest.cpp.
#include <gtest/gtest.h>

#include <cmath>

#include "clod/query/StopRule.h"
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
Settings coarser(Settings settings, double factor)
{
	settings.metric.coarsening = factor;
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

// The same metric with every limit so many times as large, by hand.
Metric enlarged(Metric metric, double factor, double radius)
{
	const double finest = 1e-4 * radius;
	const auto enlarge = [&](double& limit) { limit = limit < kOff ? factor * std::max(limit, finest) : limit; };
	if (metric.exact) metric.maxError = 0;
	metric.exact = false;
	enlarge(metric.weightedDeviation);
	const double asked = metric.maxError;
	enlarge(metric.maxError);
	// Beyond half the radius it is no coarser than that.
	const bool isAlone = !(std::min({metric.weightedDeviation, metric.velocity.time, metric.view.pixels}) < kOff);
	if (isAlone && metric.maxError < kOff && metric.maxError > std::max(asked, 0.5 * radius)) metric.coarsening = kOff;
	metric.velocity.time *= factor;
	metric.velocity.floor *= factor;
	metric.view.pixels *= factor;
	return metric;
}

TEST(Coarsening, IsEveryLimitSoManyTimesAsLarge)
{
	int coarserThanAsked = 0;
	const auto check = [&](Random& random, const BodyPair& pair, const Transform& pose, Settings settings)
	{
		settings.contactsOnly = true;
		const double factor = std::pow(10, uniform(random, 0, 3));
		Settings byHand = settings;
		byHand.metric = enlarged(settings.metric, factor, smallerRadius(pair.a, pair.b));
		const GapResult result = fresh(pair, pose, coarser(settings, factor));
		EXPECT_EQ(difference(result, fresh(pair, pose, byHand)), "") << factor;
		EXPECT_EQ(difference(fresh(pair, pose, coarser(settings, 1)), fresh(pair, pose, settings)), "");
		EXPECT_LE(result.excess, factor * (1 + 1e-9));
		EXPECT_EQ(result.excess > 0, result.stats.pending > 0);
		coarserThanAsked += result.excess > 1;
	};
	forEachPose(31, 40, check);
	EXPECT_GT(coarserThanAsked, 20);
}

// So far of the cup's coarsest levels, that reach over its hollow, none answers a small body.
TEST(Coarsening, WithoutEndErrsByHalfTheSmallerRadiusWhileApart)
{
	Random random(38);
	const BodyPair pair{body("cup", 3000), body("number8", 600)};
	const auto error = [&pair](const Contact& contact)
	{ return certifiedErrorApart(pair.a.hierarchy->node(contact.nodeA), pair.b.hierarchy->node(contact.nodeB)); };
	const double most = 0.5 * smallerRadius(pair.a, pair.b);
	int coarse = 0;
	for (int i = 0; i < 20; ++i)
	{
		const Transform pose = poseWithGap(random, pair.a, pair.b, 0);
		Settings settings = anySettings(random, smallerRadius(pair.a, pair.b));
		const GapResult coarsest = fresh(pair, pose, coarser(settings, kOff));
		for (const Contact& contact : coarsest.contacts) EXPECT_LE(error(contact), most);
		settings.metric = Metric{};
		for (const Contact& contact : fresh(pair, pose, settings).contacts) coarse += error(contact) > most;
	}
	EXPECT_GT(coarse, 5);
}

// Its levels are others, and so is what it proves of bodies apart.
TEST(Coarsening, WithoutEndIsNotWhatWasRememberedOfLess)
{
	Random random(39);
	const BodyPair pair{body("cup", 3000), body("number8", 600)};
	const double radius = smallerRadius(pair.a, pair.b);
	Settings settings;
	settings.tolerance = 0.01 * radius;
	const Transform pose = poseWithGap(random, pair.a, pair.b, 0.3);
	GapCache cache;
	GapResult result;
	std::uint32_t kept = 0;
	for (const double factor : {2.0, 2.0, kOff, kOff, 2.0})
	{
		query(*pair.a.hierarchy, *pair.b.hierarchy, pose, coarser(settings, factor), cache, result);
		EXPECT_EQ(difference(result, fresh(pair, pose, coarser(settings, factor))), "") << factor;
		kept += result.stats.stillApart;
	}
	EXPECT_EQ(kept, 1U);
}

TEST(Coarsening, WithoutEndIsTheCoarsestValidAnswer)
{
	int coarserThanAsked = 0;
	const auto check = [&](Random&, const BodyPair& pair, const Transform& pose, Settings settings)
	{
		settings.contactsOnly = true;
		const GapResult result = fresh(pair, pose, coarser(settings, kOff));
		coarserThanAsked += result.excess > 1;
		settings.metric = Metric{};
		EXPECT_EQ(difference(result, fresh(pair, pose, settings)), "");
	};
	forEachPose(32, 20, check);
	EXPECT_GT(coarserThanAsked, 10);
}

// Fresh it never gets through, so that neighbouring levels could not be changed where the budget is that of either.
// What is evaluated anew each time, the hulls of contacts, is little of large queries.
TEST(Budget, WhatIsCutShortGoesOnInTheNextQuery)
{
	int through = 0;
	const auto check = [&](Random& random, const BodyPair& pair, Transform pose, Settings settings)
	{
		settings.contactsOnly = true;
		const GapResult whole = fresh(pair, pose, settings);
		if (testsOf(whole) < 100) return;
		const double coarsest = double(testsOf(fresh(pair, pose, with(settings, 0))));
		const Settings limited = with(settings, std::floor(coarsest + 0.8 * double(testsOf(whole))));
		if (fresh(pair, pose, limited).stats.cutShort == 0) return;
		GapCache cache;
		GapResult result;
		int queries = 0;
		do
		{
			pose.translation += 1e-6 * smallerRadius(pair.a, pair.b) * randomDirection(random);
			query(*pair.a.hierarchy, *pair.b.hierarchy, pose, limited, cache, result);
			EXPECT_LE(testsOf(result), std::uint64_t(limited.budget.tests));
		} while (result.stats.cutShort == 1 && ++queries < 10);
		EXPECT_GT(queries, 0);
		EXPECT_LT(queries, 10);
		EXPECT_EQ(difference(result, fresh(pair, pose, settings)), "");
		++through;
	};
	forEachPose(37, 100, check);
	EXPECT_GT(through, 30);
}

TEST(Budget, CutsShortToTheCoarsestAnswerOrChangesNothing)
{
	int cut = 0, whole = 0, early = 0;
	const auto check = [&](Random&, const BodyPair& pair, const Transform& pose, Settings settings)
	{
		settings.contactsOnly = true;  // the search of a depth is not in the budget
		const GapResult expected = fresh(pair, pose, settings), coarsest = fresh(pair, pose, coarser(settings, kOff));
		const double least = double(testsOf(fresh(pair, pose, with(settings, 0))));
		GapCache cache;
		const Outline outline = outlineCoarsest(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache.pair);
		// Nothing is held back but the coarsest answer, and what one more answer may take.
		const double enough = double(testsOf(fresh(pair, pose, with(settings, 1e9)))) + outline.answering + 6;
		for (double tests = 1; tests < 1e5; tests *= 1.7)
		{
			const GapResult result = fresh(pair, pose, with(settings, std::floor(tests)));
			const bool isCut = result.stats.cutShort > 0;
			EXPECT_EQ(difference(result, isCut ? coarsest : expected), "") << tests;
			// The search for what the bodies may move is part of the budget, and left out where it does not fit.
			EXPECT_LE(double(testsOf(result)), std::max(std::floor(tests), least)) << tests;
			EXPECT_FALSE(isCut && tests > enough) << tests;
			cut += isCut, whole += !isCut;
			early += isCut && tests > double(testsOf(expected));
		}
	};
	forEachPose(33, 8, check);
	EXPECT_GT(cut, 50);
	EXPECT_GT(whole, 50);
	EXPECT_LT(early, cut / 4);
}

// What the coarsest answer takes is known before it is needed, and listing its pairs is not paid twice.
TEST(Budget, TellsWhatTheCoarsestAnswerTakes)
{
	int cut = 0;
	const auto check = [&](Random&, const BodyPair& pair, const Transform& pose, Settings settings)
	{
		settings.contactsOnly = true;
		const GapResult nothing = fresh(pair, pose, with(settings, 0));
		if (nothing.stats.cutShort == 0) return;
		GapCache cache;
		GapResult result;
		const Outline outline = outlineCoarsest(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache.pair);
		EXPECT_GT(outline.listing, 0U);
		EXPECT_EQ(outlineCoarsest(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache.pair).listing, 0U);
		query(*pair.a.hierarchy, *pair.b.hierarchy, pose, with(settings, 0), cache, result);
		EXPECT_EQ(difference(result, nothing), "");
		EXPECT_EQ(outline.listing + testsOf(result), testsOf(nothing));
		EXPECT_LE(testsOf(result), outline.answering);
		EXPECT_LE(outline.answering, 2 * testsOf(result));
		++cut;
	};
	forEachPose(38, 8, check);
	EXPECT_GT(cut, 8);
}

// A trial has the answer without a budget, or none and no more tests than it may take; and goes on where it stopped.
TEST(Budget, ATrialIsWholeOrNothing)
{
	int failed = 0, whole = 0;
	const auto check = [&](Random& random, const BodyPair& pair, const Transform& pose, Settings settings)
	{
		settings.contactsOnly = true;
		const ContactSettings& asked = settings;
		PairCache cache, other;
		ContactResult without, result;
		contacts(*pair.a.hierarchy, *pair.b.hierarchy, pose, asked, other, without);
		ContactSettings trial = asked;
		trial.isTrial = true;
		trial.budget.tests = std::floor(std::pow(10, uniform(random, 0, 4)));
		contacts(*pair.a.hierarchy, *pair.b.hierarchy, pose, trial, cache, result);
		EXPECT_LE(result.stats.boxTests + result.stats.hullTests, trial.budget.tests);
		const bool isCut = result.stats.cutShort > 0;
		++(isCut ? failed : whole);
		EXPECT_EQ(result.contacts.size(), isCut ? 0 : without.contacts.size());
		if (!isCut) return;
		contacts(*pair.a.hierarchy, *pair.b.hierarchy, pose, asked, cache, result);
		ASSERT_EQ(result.contacts.size(), without.contacts.size());
		for (std::size_t i = 0; i < result.contacts.size(); ++i)
			EXPECT_TRUE(sameBits(result.contacts[i], without.contacts[i]));
	};
	forEachPose(36, 30, check);
	EXPECT_GT(failed, 5);
	EXPECT_GT(whole, 5);
}

TEST(Budget, ItsErrorIsStillCertified)
{
	int proved = 0;
	const auto check = [&](Random& random, const BodyPair& pair, const Transform& pose, Settings settings)
	{
		settings.contactsOnly = false;
		const double radius = smallerRadius(pair.a, pair.b);
		const double tests = std::pow(10, uniform(random, 0, 4));
		settings = with(coarser(settings, std::pow(10, uniform(random, 0, 3))), tests);
		const GapResult result = fresh(pair, pose, settings);
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

// Budgets, factors and metrics change from step to step: caches show in nothing but in what is cut short.
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
			if (random() % 2) settings.metric.coarsening = random() % 3 ? std::pow(10, uniform(random, 0, 3)) : 1;
			if (random() % 8 == 0) settings.metric.coarsening = kOff;
			if (random() % 2)
				settings.budget.tests = random() % 3 ? std::floor(std::pow(10, uniform(random, 0, 5))) : kOff;
			query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
			Settings free = settings;
			free.budget = {};
			if (result.stats.cutShort > 0) free.metric.coarsening = kOff;
			const GapResult expected = fresh(pair, pose, free);
			ASSERT_EQ(difference(result, expected), "") << "step " << step;
			ASSERT_EQ(result.excess, expected.excess) << "step " << step;
			cut += result.stats.cutShort;
		}
		EXPECT_GT(cut, 20);
		EXPECT_GT(again, 20);
	}
}

TEST(Budget, ATimeOfZeroIsTheCoarsestAnswerAndALongOneChangesNothing)
{
	const auto check = [&](Random&, const BodyPair& pair, const Transform& pose, Settings settings)
	{
		const GapResult unbudgeted = fresh(pair, pose, settings), coarsest = fresh(pair, pose, coarser(settings, kOff));
		settings.budget.microseconds = 0;
		EXPECT_EQ(difference(fresh(pair, pose, settings), coarsest), "");
		settings.budget.microseconds = 1e9;
		EXPECT_EQ(difference(fresh(pair, pose, settings), unbudgeted), "");
	};
	forEachPose(36, 5, check);
}

TEST(Budget, RefusesWhatCannotBeUsedByName)
{
	for (const double bad : {-1.0, std::nan("")})
	{
		Settings settings = with({}, bad);
		EXPECT_NE(settingsError(settings).find("budget.tests"), std::string::npos);
		settings.budget = {kOff, bad};
		EXPECT_NE(settingsError(settings).find("budget.microseconds"), std::string::npos);
		EXPECT_NE(settingsError(coarser({}, bad)).find("metric.coarsening"), std::string::npos);
	}
	Settings settings = with({}, 100);
	EXPECT_EQ(settingsError(settings), "");
	settings.budget.now = nullptr;
	EXPECT_NE(settingsError(settings).find("budget.now"), std::string::npos);
	settings.budget.now = Budget{}.now;
	settings.distance = true;
	EXPECT_NE(settingsError(settings).find("distance"), std::string::npos);
}
}  // namespace
