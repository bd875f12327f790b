// SPDX-License-Identifier: GPL-3.0-or-later
// What a cache may do: nothing but save time. CLOD_WALK_STEPS, CLOD_CREEPS, CLOD_APPROACHES and CLOD_PARTINGS lengthen
// the tests.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "clod/hierarchy/ConvexPiece.h"
#include "tests/query/Questions.h"

namespace
{
using namespace clod;
using namespace clod::test;

// A pair asked again and again, with one cache.
struct Walk
{
	BodyPair pair;
	Transform pose;
	Settings settings;
	GapCache cache{};
	GapResult result{};
	int queries = 0;
};

// What happened on walks.
struct Tally
{
	int queries = 0, withContacts = 0, deep = 0, stillApart = 0, frontKept = 0;
	// Queries with another number of contacts than the one before, with some after none, with none after some.
	int changed = 0, came = 0, went = 0;
	int ofSigns = 0;
	std::uint64_t boxTests = 0, freshBoxTests = 0, skipped = 0;
};

// All that contacts tell of signs only.
void leaveSigns(std::vector<Contact>& contacts)
{
	for (Contact& contact : contacts)
	{
		const double isApart = contact.lower > 0, isNoOverlap = contact.upper > 0;
		contact = {contact.nodeA, contact.nodeB, isApart, isNoOverlap, {}, {}, {}};
	}
}

// The answer is that of a fresh query, bit for bit; of signs only, that of one that tells all.
void ask(Walk& walk, Tally& tally)
{
	const GapResult& result = walk.result;
	const std::size_t before = result.contacts.size();
	query(*walk.pair.a.hierarchy, *walk.pair.b.hierarchy, walk.pose, walk.settings, walk.cache, walk.result);
	Settings all = walk.settings;
	all.signsOnly = false;
	GapResult expected = fresh(walk.pair, walk.pose, all);
	if (walk.settings.signsOnly)
	{
		++tally.ofSigns;
		leaveSigns(expected.contacts);
		leaveSigns(walk.result.contacts);
	}
	ASSERT_EQ(difference(result, expected), "")
		<< walk.pair.a.name << " query " << walk.queries << ": " << result.minDistance << " +- " << result.errorBound
		<< " deep " << result.deep << ", fresh " << expected.minDistance << " +- " << expected.errorBound
		<< ", contacts " << result.contacts.size() << ", still clear " << result.stats.stillApart << ", exact "
		<< walk.settings.metric.exact << ", distance " << walk.settings.distance << ", contacts only "
		<< walk.settings.contactsOnly << ", gap error " << walk.settings.gapError << ", searches "
		<< result.stats.gapSearches << "," << expected.stats.gapSearches << ", point queries "
		<< result.stats.pointQueries << "," << expected.stats.pointQueries;
	++tally.queries;
	tally.withContacts += !result.contacts.empty();
	tally.deep += result.deep;
	tally.stillApart += int(result.stats.stillApart);
	tally.frontKept += int(result.stats.frontKept);
	tally.changed += result.contacts.size() != before;
	tally.came += walk.queries > 0 && before == 0 && !result.contacts.empty();
	tally.went += before > 0 && result.contacts.empty();
	tally.boxTests += result.stats.boxTests;
	tally.freshBoxTests += expected.stats.boxTests;
	tally.skipped += result.stats.skippedBySlack;
	++walk.queries;
}

// move(step) changes the walk before each query.
template <class Move>
void go(Walk& walk, int steps, Tally& tally, const Move& move)
{
	for (int step = 0; step < steps; ++step)
	{
		move(step);
		ASSERT_NO_FATAL_FAILURE(ask(walk, tally));
	}
}

TEST(Query, CachedEqualsFreshBitForBit)
{
	Random random(6);
	const int steps = setting("CLOD_WALK_STEPS", 500);
	Tally tally;
	for (const BodyPair& pair : pairs())
	{
		const double radius = smallerRadius(pair.a, pair.b);
		Walk walk{pair, poseWithGap(random, pair.a, pair.b, 0), exactSettings(0.01 * radius)};
		Transform& pose = walk.pose;
		Settings& settings = walk.settings;
		double smallest = -6;  // power of ten of the motion: at times the bodies are almost at rest
		const auto move = [&](int)
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
				settings.signsOnly = settings.contactsOnly && walk.queries % 2;
				if (random() % 3 == 0) settings.gapError = uniform(random, 0, 0.01) * radius;
			}
			// Half of the steps look ahead, mostly along a motion that changes little.
			if (random() % 20 == 0) settings.sweep = random() % 2 ? randomSweep(random, radius) : Sweep{};
			if (!settings.sweep.isZero())
				settings.sweep.linear += 1e-3 * length(settings.sweep.linear) * randomDirection(random);
			if (random() % 100 == 0) walk.cache.clear();
		};
		ASSERT_NO_FATAL_FAILURE(go(walk, steps, tally, move));
	}
	std::printf("%d steps with contacts, %d deep, %d still clear, box tests %.0f %% of fresh\n",
				tally.withContacts, tally.deep, tally.stillApart,
				100.0 * double(tally.boxTests) / double(tally.freshBoxTests));
	EXPECT_GT(tally.withContacts, steps);
	EXPECT_GT(tally.ofSigns, steps / 4);
	EXPECT_GT(tally.stillApart, steps / 20);
	EXPECT_LT(tally.boxTests, tally.freshBoxTests);
	EXPECT_GT(tally.skipped, 0u);
	EXPECT_LT(tally.skipped, 10 * tally.freshBoxTests);  // more of them than of what a fresh query looks at are none
}

// Bodies that creep straight into each other, or apart: most boxes need not be compared again, and no contact comes late.
TEST(Query, CreepingBodiesFindAllThatAFreshQueryFinds)
{
	Random random(17);
	Tally tally;
	for (const BodyPair& pair : pairs())
		for (int creep = 0; creep < setting("CLOD_CREEPS", 24); ++creep)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			Settings settings;
			settings.tolerance = 0.02 * radius;
			settings.contactsOnly = true;
			settings.signsOnly = creep % 8 >= 4;
			if (creep % 4 == 0) settings.metric.exact = true;
			if (creep % 4 == 1) settings.metric.weightedDeviation = 0.03 * radius;
			if (creep % 4 == 2) settings.metric.maxError = 0.01 * radius;
			if (creep % 4 == 3) settings.metric.weightedDeviation = settings.metric.maxError = 0.02 * radius;
			if (creep % 3 == 2) settings.sweep.linear = 0.01 * radius * randomDirection(random);
			// One contact at first, or a little more; the motion of a translation is known exactly. Some part again.
			const bool parts = creep % 8 >= 6;
			Walk walk{pair, poseWithGap(random, pair.a, pair.b, parts ? 0.01 : 0.015), settings};
			const Vec3 towards = normalized(walk.pose.translation);
			const Vec3 way = 4e-5 * radius * (randomVector(random, 0, 1) + (parts ? 1 : -1) * towards);
			const auto move = [&](int) { walk.pose.translation += way; };
			ASSERT_NO_FATAL_FAILURE(go(walk, 400, tally, move)) << "creep " << creep;
		}
	std::printf("%d queries, box tests %.0f %% of fresh, the number of contacts changed in %d\n", tally.queries,
				100.0 * double(tally.boxTests) / double(tally.freshBoxTests), tally.changed);
	EXPECT_LT(2 * tally.boxTests, tally.freshBoxTests);
	EXPECT_GT(tally.changed, tally.queries / 200);
}

// A convex body of one piece that tumbles over a mesh or coarse levels of it: most steps ask the pairs of a front made for more than the tolerance.
TEST(Query, TumblingPiecesFindAllThatAFreshQueryFinds)
{
	Random random(23);
	Tally tally;
	for (const double margin : {0.0, 0.2})
	{
		std::vector<Vec3> points;
		for (int i = 0; i < (margin > 0 ? 2 : 8); ++i)
			points.push_back(0.1 * Vec3{i & 1 ? 1. : -1., i & 2 ? 1. : -1., i & 4 ? 1. : -1.});
		const Body piece = bodyOf("piece", convexPiece(convexPolyhedron(points, 8), margin).value());
		const BodyPair pair{body("torus", 900), piece};
		for (int start = 0; start < setting("CLOD_TUMBLES", 40); ++start)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			Walk walk{pair, poseWithGap(random, pair.a, pair.b, 0), exactSettings(margin + 0.01 * radius)};
			walk.settings.contactsOnly = true;
			if (start % 4 >= 2)
			{
				walk.settings.metric = {};
				walk.settings.metric.maxError = std::pow(10, uniform(random, -2.3, -0.7)) * double(pair.a.hierarchy->asset().radius);
			}
			const double size = std::pow(10, uniform(random, -3, -1));
			Vec3 way = size * radius * randomDirection(random);
			const Mat3 turn = randomRotation(random, 3 * size);
			const auto move = [&](int step)
			{
				if (step % 25 == 24) way = -way;
				if (step % 10 == 9) walk.settings.tolerance = margin + uniform(random, 0, 0.02) * radius;
				if (start % 2) walk.settings.sweep = {uniform(random, 0, 20) * way, size * randomDirection(random)};
				walk.pose.rotation = turn * walk.pose.rotation;
				walk.pose.translation += way;
			};
			ASSERT_NO_FATAL_FAILURE(go(walk, 100, tally, move)) << "start " << start;
		}
	}
	std::printf("%d queries, %d with contacts, %d kept their front, the number of contacts changed in %d\n", tally.queries,
				tally.withContacts, tally.frontKept, tally.changed);
	EXPECT_GT(tally.withContacts, tally.queries / 3);
	EXPECT_GT(tally.frontKept, tally.queries / 3);
	EXPECT_GT(tally.changed, tally.queries / 10);
}

// Bodies that come near each other, turning, past each other or into contact: not looked at while they are apart, and
// no step too long.
TEST(Query, BodiesApartAreLeftAloneUntilTheyCanTouch)
{
	Random random(16);
	Tally tally;
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
			Walk walk{pair, poseWithGap(random, pair.a, pair.b, 0.2), settings};
			const Vec3 towards = -normalized(walk.pose.translation);
			const auto move = [&](int)
			{
				walk.pose.rotation = randomRotation(random, 1e-3) * walk.pose.rotation;
				walk.pose.translation += 0.002 * radius * (towards + 0.3 * randomDirection(random));
			};
			ASSERT_NO_FATAL_FAILURE(go(walk, 150, tally, move)) << "approach " << approach;
		}
	std::printf("%d queries, %d still clear, %d with contacts\n", tally.queries, tally.stillApart, tally.withContacts);
	EXPECT_GT(tally.stillApart, tally.queries / 3);
	EXPECT_GT(tally.withContacts, tally.queries / 10);
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
		GapCache cache;
		GapResult result;
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
	Tally tally;
	for (const BodyPair& pair : pairs())
		for (int parting = 0; parting < setting("CLOD_PARTINGS", 60); ++parting)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			Settings settings;
			settings.metric.maxError = std::pow(10, uniform(random, -2, -0.5)) * radius;
			if (parting % 3 == 1) settings.metric.weightedDeviation = 10 * settings.metric.maxError;
			settings.tolerance = (parting % 2 ? 1e-4 : 1e-3) * radius;
			settings.contactsOnly = parting % 5 != 4;
			Walk walk{pair, poseWithGap(random, pair.a, pair.b, uniform(random, 0.001, 0.02)), settings};
			const Vec3 away = normalized(walk.pose.translation);
			const Vec3 way = 2e-4 * radius * normalized(away + 0.5 * randomDirection(random));
			const auto move = [&](int) { walk.pose.translation += way; };
			ASSERT_NO_FATAL_FAILURE(go(walk, 100, tally, move)) << "parting " << parting;
		}
	std::printf("%d queries, %d still clear, contacts began %d times\n", tally.queries, tally.stillApart, tally.came);
	EXPECT_GT(tally.stillApart, tally.queries / 20);
	EXPECT_GT(tally.came, 0);
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
	Tally tallies[kSelections][2];  // with the gap, contacts only
	for (const BodyPair& pair : pairs())
		for (int kind = 0; kind < kSelections; ++kind)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			double level = 0.1;
			const OwnThreshold own = [&](const Place& place)
			{ return level * radius * (1.1 + std::sin(place.center.x / radius)); };
			Walk walk{pair, {}, {}};
			Transform& pose = walk.pose;
			for (int done = 0; done < steps; done += 60)
			{
				pose = poseWithGap(random, pair.a, pair.b, uniform(random, 0.01, 0.3));
				const double size = std::pow(10, uniform(random, -5, -2.5)) * radius;
				Vec3 way = size * (0.5 * randomDirection(random) - normalized(pose.translation));
				if (random() % 3 == 0) way = -1.0 * way;
				walk.settings = selection(random, kind, radius, own);
				Metric& metric = walk.settings.metric;
				const auto move = [&](int step)
				{
					if (step % 20 == 0)
					{
						const Vec3 linear = randomDirection(random);
						metric.velocity.linear = std::pow(10, uniform(random, -2, 1)) * radius * linear;
						const Vec3 angular = randomDirection(random);
						metric.velocity.angular = std::pow(10, uniform(random, -2, 1)) * angular;
						metric.view.eye = randomVector(random, 0, 20 * radius);
						level = std::pow(10, uniform(random, -3, 0));
						walk.settings.sweep = random() % 3 ? Sweep{} : Sweep{2.0 * way, {}};
					}
					pose.translation += way;
					pose.rotation = randomRotation(random, 0.1 * length(way) / radius) * pose.rotation;
					metric.velocity.linear += 0.02 * length(metric.velocity.linear) * randomDirection(random);
					metric.view.eye += 0.02 * length(metric.view.eye) * randomDirection(random);
				};
				Tally& tally = tallies[kind][walk.settings.contactsOnly];
				ASSERT_NO_FATAL_FAILURE(go(walk, std::min(60, steps - done), tally, move)) << kSelectionNames[kind];
			}
		}
	int contacts = 0;
	for (int kind = 0; kind < kSelections; ++kind)
		for (const int only : {0, 1})
		{
			const Tally& tally = tallies[kind][only];
			const double share = 100.0 * tally.stillApart / std::max(1, tally.queries - tally.withContacts);
			std::printf("%s, %s: %.0f %% of the queries apart still clear\n", kSelectionNames[kind],
						only ? "contacts only" : "gap", share);
			EXPECT_GT(share, 30) << kSelectionNames[kind] << only;
			contacts += tally.withContacts;
		}
	EXPECT_GT(contacts, steps / 4);
}

// Coarse hulls reach farther than fine ones: what is apart at one speed may touch at another, and where it is seen
// from.
TEST(Query, ThresholdsThatRiseAreSeenAtOnce)
{
	Random random(23);
	Tally tally;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 30; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			double level = 0;
			const OwnThreshold own = [&](const Place&) { return level; };
			Settings settings;
			settings.tolerance = 1e-4 * radius;
			settings.contactsOnly = i % 2 == 0;
			if (i % 3 == 0) settings.metric.velocity.time = 1;
			if (i % 3 == 1) settings.metric.view.pixels = settings.metric.view.pixelSize = 1;
			if (i % 3 == 2) settings.metric.own = &own;
			Walk walk{pair, poseWithGap(random, pair.a, pair.b, uniform(random, 0.002, 0.02)), settings};
			const Vec3 way = 1e-5 * radius * randomDirection(random);
			const auto move = [&](int step)
			{
				walk.pose.translation += way;
				if (step % 12 == 0) level = (step % 24 == 0 ? 1e-4 : 3.0) * radius;
				walk.settings.metric.velocity.linear = {level, 0, 0};
				walk.settings.metric.view.nearest = level;
			};
			ASSERT_NO_FATAL_FAILURE(go(walk, 120, tally, move)) << "walk " << i;
		}
	const int changes = tally.came + tally.went;
	std::printf("%d queries, %d still clear, contacts came or went %d times\n", tally.queries, tally.stillApart,
				changes);
	EXPECT_GT(tally.stillApart, tally.queries / 10);
	EXPECT_GT(changes, 20);
}

// Bodies that come so near that hulls of the base levels, or of coarser nodes, overlap while the finer ones behind them
// are beyond the tolerance, and go back a little: then the coarse hulls answer again. Tolerances are smaller than what
// hulls protrude.
TEST(Query, BodiesApartAreLookedAtWhenCoarseHullsComeApartAgain)
{
	Random random(18);
	Tally tally;
	int vanished = 0;
	for (const BodyPair& pair : pairs())
		for (int approach = 0; approach < setting("CLOD_RETURNS", 40); ++approach)
		{
			const double radius = smallerRadius(pair.a, pair.b), share = std::pow(10, uniform(random, -1.7, -0.7));
			Settings settings;
			settings.tolerance = uniform(random, 5e-4, 15e-4) * radius;
			settings.metric.maxError = share * radius;
			settings.contactsOnly = true;
			Walk walk{pair, poseWithGap(random, pair.a, pair.b, 1.5 * share), settings};
			const Vec3 step = -5e-4 * radius * normalized(walk.pose.translation);
			std::size_t before = 0;
			for (int i = 0; i < 400 && walk.result.contacts.size() < 20; ++i)
			{
				ASSERT_NO_FATAL_FAILURE(ask(walk, tally)) << "approach " << approach;
				const bool vanishes = before > 0 && walk.result.contacts.empty();
				before = walk.result.contacts.size();
				vanished += int(vanishes);
				if (vanishes)
				{
					walk.pose.translation -= 0.4 * step;
					ASSERT_NO_FATAL_FAILURE(ask(walk, tally)) << "approach " << approach;
					walk.pose.translation += 0.4 * step;
				}
				walk.pose.translation += step;
			}
		}
	std::printf("%d queries, %d still clear, contacts vanished in %d\n", tally.queries, tally.stillApart, vanished);
	EXPECT_GT(tally.stillApart, tally.queries / 20);
	EXPECT_GT(vanished, 2);
}

TEST(Query, TheComparisonSeesOneBit)
{
	const BodyPair pair = pairs()[0];
	Random random(7);
	const Transform pose = poseWithGap(random, pair.a, pair.b, -0.001);
	const GapResult result = fresh(pair, pose, exactSettings(0.01 * smallerRadius(pair.a, pair.b)));
	ASSERT_FALSE(result.contacts.empty());
	GapResult fault = result;
	fault.contacts.back().upper = std::nextafter(fault.contacts.back().upper, 1e300);
	EXPECT_EQ(difference(result, result), "");
	EXPECT_NE(difference(result, fault), "");
	fault = result;
	fault.contacts.pop_back();
	EXPECT_NE(difference(result, fault), "");
}
}  // namespace
