// SPDX-License-Identifier: GPL-3.0-or-later
// What a cache may do: nothing but save time. CLOD_WALK_STEPS, CLOD_CREEPS, CLOD_APPROACHES and CLOD_PARTINGS lengthen
// the tests.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/query/Questions.h"

namespace
{
using namespace clod;
using namespace clod::test;

TEST(Query, CachedEqualsFreshBitForBit)
{
	Random random(6);
	const int steps = setting("CLOD_WALK_STEPS", 500);
	int withContacts = 0, deep = 0, stillClear = 0, frontKept = 0;
	std::uint64_t cachedTests = 0, freshTests = 0;
	for (const BodyPair& pair : pairs())
	{
		const double radius = smallerRadius(pair.a, pair.b);
		PairCache cache;
		QueryResult result;
		Settings settings = exactSettings(0.01 * radius);
		Transform pose = poseWithGap(random, pair.a, pair.b, 0);
		double smallest = -6;  // power of ten of the motion: at times the bodies are almost at rest
		for (int step = 0; step < steps; ++step)
		{
			if (random() % 30 == 0) smallest = random() % 2 ? -6 : -9;
			const double size = std::pow(10, uniform(random, smallest, smallest < -6 ? -6 : -1));
			if (random() % 40 == 0)
				pose = poseWithGap(random, pair.a, pair.b, uniform(random, -0.05, 0.05));
			else if (random() % 10)
			{
				pose.rotation = randomRotation(random, size) * pose.rotation;
				pose.translation += size * radius * randomDirection(random);
			}
			if (random() % 30 == 0)
			{
				const double tolerance = settings.tolerance;
				settings = Settings{};
				settings.tolerance = random() % 2 ? tolerance : uniform(random, 0, 0.03) * radius;
				settings.metric.exact = random() % 3 == 0;
				if (random() % 2) settings.metric.weightedDeviation = std::pow(10, uniform(random, -4, 0)) * radius;
				if (random() % 3 == 0) settings.metric.maxError = std::pow(10, uniform(random, -3, -1)) * radius;
				settings.distance = random() % 3 == 0;
				settings.contactsOnly = !settings.distance && random() % 2;
				if (random() % 3 == 0) settings.gapError = uniform(random, 0, 0.01) * radius;
			}
			// Half of the steps look ahead, mostly along a motion that changes little.
			if (random() % 20 == 0) settings.sweep = random() % 2 ? randomSweep(random, radius) : Sweep{};
			if (!settings.sweep.isZero())
				settings.sweep.linear += 1e-3 * length(settings.sweep.linear) * randomDirection(random);
			if (random() % 100 == 0) cache.clear();
			query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
			const QueryResult expected = fresh(pair, pose, settings);
			ASSERT_EQ(difference(result, expected), "")
				<< pair.a.name << " step " << step << ": " << result.minDistance << " +- " << result.errorBound
				<< " deep " << result.deep << ", fresh " << expected.minDistance << " +- " << expected.errorBound
				<< ", contacts " << result.contacts.size() << ", exact " << settings.metric.exact << ", distance "
				<< settings.distance << ", searches " << result.stats.gapSearches << "," << expected.stats.gapSearches
				<< ", point queries " << result.stats.pointQueries << "," << expected.stats.pointQueries;
			withContacts += !result.contacts.empty();
			deep += result.deep;
			stillClear += int(result.stats.stillClear);
			frontKept += int(result.stats.frontKept);
			cachedTests += result.stats.boxTests;
			freshTests += expected.stats.boxTests;
		}
	}
	std::printf("%d steps with contacts, %d deep, %d still clear, %d fronts kept, box tests %.0f %% of fresh\n",
				withContacts, deep, stillClear, frontKept, 100.0 * double(cachedTests) / double(freshTests));
	EXPECT_GT(withContacts, steps);
	EXPECT_GT(frontKept, steps / 2);
	EXPECT_GT(stillClear, steps / 20);
	EXPECT_LT(cachedTests, freshTests);
}

// Bodies that creep straight into each other: most steps keep the front, and none that brings another contact does.
TEST(Query, CreepingBodiesKeepTheirFrontUntilItChanges)
{
	Random random(17);
	int kept = 0, total = 0, changes = 0;
	for (const BodyPair& pair : pairs())
		for (int creep = 0; creep < setting("CLOD_CREEPS", 24); ++creep)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			Settings settings;
			settings.tolerance = 0.02 * radius;
			settings.contactsOnly = true;
			if (creep % 4 == 0) settings.metric.exact = true;
			if (creep % 4 == 1) settings.metric.weightedDeviation = 0.03 * radius;
			if (creep % 4 == 2) settings.metric.maxError = 0.01 * radius;
			if (creep % 4 == 3) settings.metric.weightedDeviation = settings.metric.maxError = 0.02 * radius;
			if (creep % 3 == 2) settings.sweep.linear = 0.01 * radius * randomDirection(random);
			// One contact at first, or a little more; the motion of a translation is known exactly.
			Transform pose = poseWithGap(random, pair.a, pair.b, 0.015);
			const Vec3 way =
				4e-5 * radius * (uniform(random, 0, 1) * randomDirection(random) - normalized(pose.translation));
			PairCache cache;
			QueryResult result;
			std::size_t contacts = 0;
			for (int step = 0; step < 400; ++step)
			{
				pose.translation += way;
				query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
				ASSERT_EQ(difference(result, fresh(pair, pose, settings)), "")
					<< pair.a.name << " creep " << creep << " step " << step;
				changes += result.contacts.size() != contacts;
				contacts = result.contacts.size();
				kept += int(result.stats.frontKept);
				++total;
			}
		}
	std::printf("%d queries, %d kept their front, the number of contacts changed in %d\n", total, kept, changes);
	EXPECT_GT(kept, total / 2);
	EXPECT_GT(changes, total / 200);
}

// Bodies that come near each other, turning, past each other or into contact: not looked at while they are apart, and
// no step too long.
TEST(Query, BodiesApartAreLeftAloneUntilTheyCanTouch)
{
	Random random(16);
	int stillClear = 0, total = 0, contacts = 0;
	for (const BodyPair& pair : pairs())
		for (int approach = 0; approach < setting("CLOD_APPROACHES", 6); ++approach)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			Settings settings = exactSettings(0.01 * radius);
			settings.metric.exact = approach % 3 == 0;
			if (approach % 3 == 1) settings.metric.weightedDeviation = 0.1 * radius;
			if (approach % 3 == 2) settings.metric.maxError = 0.05 * radius;
			settings.contactsOnly = true;
			if (approach % 2) settings.sweep.linear = 0.002 * radius * randomDirection(random);
			Transform pose = poseWithGap(random, pair.a, pair.b, 0.2);
			const Vec3 towards = -normalized(pose.translation);
			PairCache cache;
			QueryResult result;
			for (int step = 0; step < 150; ++step)
			{
				pose.rotation = randomRotation(random, 1e-3) * pose.rotation;
				pose.translation += 0.002 * radius * (towards + 0.3 * randomDirection(random));
				query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
				ASSERT_EQ(difference(result, fresh(pair, pose, settings)), "")
					<< pair.a.name << " approach " << approach << " step " << step;
				stillClear += int(result.stats.stillClear);
				contacts += !result.contacts.empty();
				++total;
			}
		}
	std::printf("%d queries, %d still clear, %d with contacts\n", total, stillClear, contacts);
	EXPECT_GT(stillClear, total / 3);
	EXPECT_GT(contacts, total / 10);
}

// Those that came less those that left are the pairs of nodes a fresh query finds; where nothing has changed but the
// settings' last bits nothing moves, and the pair of roots stays when all below it leaves.
TEST(Query, MovesOfTheFrontAddUp)
{
	Random random(23);
	std::uint64_t moves = 0;
	int apart = 0;
	for (const BodyPair& pair : pairs())
	{
		const double radius = smallerRadius(pair.a, pair.b);
		Settings settings = exactSettings(0.01 * radius);
		settings.metric.exact = false;
		PairCache cache;
		QueryResult result;
		std::uint64_t kept = 0;
		Transform pose = poseWithGap(random, pair.a, pair.b, 0.005);
		for (int step = 0; step < 40; ++step)
		{
			if (step % 20 == 10) pose.translation = 3 * pose.translation;
			if (step % 20 == 11) pose = poseWithGap(random, pair.a, pair.b, -0.01);
			pose.rotation = randomRotation(random, 0.02) * pose.rotation;
			settings.metric.weightedDeviation = 0.02 * radius;
			query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
			const QueryStats first = result.stats;
			const std::uint64_t before = kept;
			kept += first.frontCame;
			kept -= first.frontGone;
			ASSERT_EQ(kept, fresh(pair, pose, settings).stats.frontCame) << pair.a.name << " step " << step;
			EXPECT_TRUE(before != 1 || first.frontGone == 0) << pair.a.name << " step " << step;
			moves += first.frontCame + first.frontGone;
			apart += int(kept == 1);
			settings.metric.weightedDeviation *= 1 + 1e-12;
			query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
			EXPECT_EQ(result.stats.frontKept, 0u);
			EXPECT_EQ(result.stats.frontCame, 0u) << pair.a.name << " step " << step;
			EXPECT_EQ(result.stats.frontGone, 0u) << pair.a.name << " step " << step;
		}
	}
	EXPECT_GT(moves, 500u);
	EXPECT_GE(apart, 3);
}

// Coarse hulls that overlap where surfaces are apart answer as soon as they part: that, too, is a contact to come.
TEST(Query, BodiesThatPartMayTouchByCoarserHulls)
{
	Random random(21);
	int stillClear = 0, total = 0, began = 0;
	for (const BodyPair& pair : pairs())
		for (int parting = 0; parting < setting("CLOD_PARTINGS", 60); ++parting)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			Settings settings;
			settings.metric.maxError = std::pow(10, uniform(random, -2, -0.5)) * radius;
			if (parting % 3 == 1) settings.metric.weightedDeviation = 10 * settings.metric.maxError;
			settings.tolerance = (parting % 2 ? 1e-4 : 1e-3) * radius;
			settings.contactsOnly = parting % 5 != 4;
			Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, 0.001, 0.02));
			const Vec3 way = 2e-4 * radius * normalized(normalized(pose.translation) + 0.5 * randomDirection(random));
			PairCache cache;
			QueryResult result;
			bool hadContacts = true;
			for (int step = 0; step < 100; ++step)
			{
				pose.translation += way;
				query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
				ASSERT_EQ(difference(result, fresh(pair, pose, settings)), "")
					<< pair.a.name << " parting " << parting << " step " << step;
				stillClear += int(result.stats.stillClear);
				began += !hadContacts && !result.contacts.empty();
				hadContacts = !result.contacts.empty();
				++total;
			}
		}
	std::printf("%d queries, %d still clear, contacts began %d times\n", total, stillClear, began);
	EXPECT_GT(stillClear, total / 20);
	EXPECT_GT(began, 0);
}

namespace
{
// Every kind of selection, with its gap or without: exact, size, certified, both, velocity, view, own, and mixed.
constexpr int kSelections = 8;
const char* const kSelectionNames[kSelections] = {"exact",    "size", "certified", "both",
												  "velocity", "view", "own",       "mixed"};
Settings selection(Random& random, int kind, double radius, const OwnThreshold& own)
{
	Settings settings;
	settings.tolerance = std::pow(10, uniform(random, -3, -1.5)) * radius;
	settings.contactsOnly = random() % 2;
	if (!settings.contactsOnly && random() % 3 == 0) settings.gapError = uniform(random, 0, 0.01) * radius;
	Metric& metric = settings.metric;
	metric.exact = kind == 0;
	if (kind == 1 || kind == 3 || kind == 7) metric.weightedDeviation = std::pow(10, uniform(random, -3, 0)) * radius;
	if (kind == 2 || kind == 3) metric.maxError = std::pow(10, uniform(random, -3, -1)) * radius;
	if (kind == 4 || kind == 7) metric.velocity.time = 0.1, metric.velocity.floor = 0.01 * radius;
	if (kind == 5 || kind == 7)
		metric.view.pixels = 2, metric.view.pixelSize = 0.002, metric.view.nearest = 0.1 * radius;
	if (kind == 6) metric.own = &own;
	if (kind >= 4 && random() % 2) metric.combine = Combine::kRelaxed;
	if (kind >= 4 && random() % 3 == 0) metric.maxError = 0.05 * radius;
	return settings;
}
}  // namespace

// Most of the time apart, whatever selects: now nearer, now farther, along a way of its own for hundreds of steps,
// while the velocity and the eye change as they like.
TEST(Query, WalksApartOfEverySelection)
{
	Random random(22);
	const int steps = setting("CLOD_WALK_STEPS", 500);
	int clear[kSelections][2] = {}, total[kSelections][2] = {}, contacts = 0;
	for (const BodyPair& pair : pairs())
		for (int kind = 0; kind < kSelections; ++kind)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			double level = 0.1;
			const OwnThreshold own = [&](const Place& place)
			{ return level * radius * (1.1 + std::sin(place.center.x / radius)); };
			PairCache cache;
			QueryResult result;
			Settings settings = selection(random, kind, radius, own);
			Transform pose = poseWithGap(random, pair.a, pair.b, 0.1);
			Vec3 way, turn;
			for (int step = 0; step < steps; ++step)
			{
				if (step % 60 == 0)
				{
					pose = poseWithGap(random, pair.a, pair.b, uniform(random, 0.01, 0.3));
					const double size = std::pow(10, uniform(random, -5, -2.5)) * radius;
					way = size * (0.5 * randomDirection(random) - normalized(pose.translation));
					if (random() % 3 == 0) way = -1.0 * way;
					settings = selection(random, kind, radius, own);
				}
				if (step % 20 == 0)
				{
					Metric& metric = settings.metric;
					metric.velocity.linear = std::pow(10, uniform(random, -2, 1)) * radius * randomDirection(random);
					metric.velocity.angular = std::pow(10, uniform(random, -2, 1)) * randomDirection(random);
					metric.view.eye = uniform(random, 0, 20) * radius * randomDirection(random);
					level = std::pow(10, uniform(random, -3, 0));
					settings.sweep = random() % 3 ? Sweep{} : Sweep{2.0 * way, {}};
				}
				pose.translation += way;
				pose.rotation = randomRotation(random, 0.1 * length(way) / radius) * pose.rotation;
				settings.metric.velocity.linear +=
					0.02 * length(settings.metric.velocity.linear) * randomDirection(random);
				settings.metric.view.eye += 0.02 * length(settings.metric.view.eye) * randomDirection(random);
				query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
				const QueryResult expected = fresh(pair, pose, settings);
				ASSERT_EQ(difference(result, expected), "")
					<< pair.a.name << ", " << kSelectionNames[kind] << " step " << step << ": +- " << result.errorBound
					<< ", fresh +- " << expected.errorBound << ", still clear " << result.stats.stillClear
					<< ", contacts only " << settings.contactsOnly << ", gap error " << settings.gapError;
				contacts += !result.contacts.empty();
				if (!expected.contacts.empty()) continue;
				clear[kind][settings.contactsOnly] += int(result.stats.stillClear);
				++total[kind][settings.contactsOnly];
			}
		}
	for (int kind = 0; kind < kSelections; ++kind)
	{
		const auto share = [&](int only) { return 100.0 * clear[kind][only] / std::max(1, total[kind][only]); };
		std::printf("%s: apart and still clear, gap %.0f %%, contacts only %.0f %%\n", kSelectionNames[kind], share(0),
					share(1));
		EXPECT_GT(share(0), 30) << kSelectionNames[kind];
		EXPECT_GT(share(1), 30) << kSelectionNames[kind];
	}
	EXPECT_GT(contacts, steps / 4);
}

// Coarse hulls reach farther than fine ones: what is apart at one speed may touch at another, and where it is seen
// from.
TEST(Query, ThresholdsThatRiseAreSeenAtOnce)
{
	Random random(23);
	int stillClear = 0, changes = 0, total = 0;
	for (const BodyPair& pair : pairs())
		for (int walk = 0; walk < 30; ++walk)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			double level = 0;
			const OwnThreshold own = [&](const Place&) { return level; };
			Settings settings;
			settings.tolerance = 1e-4 * radius;
			settings.contactsOnly = walk % 2 == 0;
			Metric& metric = settings.metric;
			if (walk % 3 == 0) metric.velocity.time = 1;
			if (walk % 3 == 1) metric.view.pixels = metric.view.pixelSize = 1;
			if (walk % 3 == 2) metric.own = &own;
			Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, 0.002, 0.02));
			const Vec3 way = 1e-5 * radius * randomDirection(random);
			PairCache cache;
			QueryResult result;
			bool touched = false;
			for (int step = 0; step < 120; ++step)
			{
				pose.translation += way;
				if (step % 12 == 0) level = (step % 24 == 0 ? 1e-4 : 3.0) * radius;
				metric.velocity.linear = {level, 0, 0};
				metric.view.nearest = level;
				query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
				ASSERT_EQ(difference(result, fresh(pair, pose, settings)), "")
					<< pair.a.name << " walk " << walk << " step " << step << ", still clear "
					<< result.stats.stillClear;
				stillClear += int(result.stats.stillClear);
				changes += touched == result.contacts.empty();
				touched = !result.contacts.empty();
				++total;
			}
		}
	std::printf("%d queries, %d still clear, contacts came or went %d times\n", total, stillClear, changes);
	EXPECT_GT(stillClear, total / 10);
	EXPECT_GT(changes, 20);
}

// Bodies that come so near that hulls of the base levels, or of coarser nodes, overlap while the finer ones behind them
// are beyond the tolerance, and go back a little: then the coarse hulls answer again. Tolerances are smaller than what
// hulls protrude.
TEST(Query, BodiesApartAreLookedAtWhenCoarseHullsComeApartAgain)
{
	Random random(18);
	int stillClear = 0, vanished = 0, total = 0;
	for (const BodyPair& pair : pairs())
		for (int approach = 0; approach < setting("CLOD_RETURNS", 40); ++approach)
		{
			const double radius = smallerRadius(pair.a, pair.b), share = std::pow(10, uniform(random, -1.7, -0.7));
			Settings settings;
			settings.tolerance = uniform(random, 5e-4, 15e-4) * radius;
			settings.metric.maxError = share * radius;
			settings.contactsOnly = true;
			Transform pose = poseWithGap(random, pair.a, pair.b, 1.5 * share);
			const Vec3 step = -5e-4 * radius * normalized(pose.translation);
			PairCache cache;
			QueryResult result;
			std::size_t before = 0;
			const auto look = [&](int i)
			{
				query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
				ASSERT_EQ(difference(result, fresh(pair, pose, settings)), "")
					<< pair.a.name << " approach " << approach << " step " << i << ", share " << share << ", tolerance "
					<< settings.tolerance / radius << " of the radius";
				stillClear += int(result.stats.stillClear);
				++total;
			};
			for (int i = 0; i < 400 && result.contacts.size() < 20; ++i)
			{
				ASSERT_NO_FATAL_FAILURE(look(i));
				const bool vanishes = before > 0 && result.contacts.empty();
				before = result.contacts.size();
				vanished += int(vanishes);
				if (vanishes)
				{
					pose.translation -= 0.4 * step;
					ASSERT_NO_FATAL_FAILURE(look(i));
					pose.translation += 0.4 * step;
				}
				pose.translation += step;
			}
		}
	std::printf("%d queries, %d still clear, contacts vanished in %d\n", total, stillClear, vanished);
	EXPECT_GT(stillClear, total / 20);
	EXPECT_GT(vanished, 2);
}

TEST(Query, TheComparisonSeesOneBit)
{
	const BodyPair pair = pairs()[0];
	Random random(7);
	const Transform pose = poseWithGap(random, pair.a, pair.b, -0.001);
	const QueryResult result = fresh(pair, pose, exactSettings(0.01 * smallerRadius(pair.a, pair.b)));
	ASSERT_FALSE(result.contacts.empty());
	QueryResult fault = result;
	fault.contacts.back().upper = std::nextafter(fault.contacts.back().upper, 1e300);
	EXPECT_EQ(difference(result, result), "");
	EXPECT_NE(difference(result, fault), "");
	fault = result;
	fault.contacts.pop_back();
	EXPECT_NE(difference(result, fault), "");
}
}  // namespace
