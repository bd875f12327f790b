// SPDX-License-Identifier: GPL-3.0-or-later
// The query against brute force: leaf pairs, pruning, sweeps, monotony, settings.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <utility>

#include "clod/distance/SurfaceDistance.h"
#include "clod/hierarchy/ConvexPiece.h"
#include "clod/query/QueryContext.h"
#include "clod/query/StopRule.h"
#include "tests/query/Questions.h"
#include "tests/query/TriangleGap.h"

namespace
{
using namespace clod;
using namespace clod::test;

TEST(Query, ExactEqualsBruteForceOverAllLeafPairs)
{
	Random random(1);
	std::size_t contacts = 0;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 9; ++i)
		{
			const Transform pose = poseWithGap(random, pair.a, pair.b, stratifiedGap(random, i));
			const double tolerance = uniform(random, 0, 0.05) * smallerRadius(pair.a, pair.b);
			const GapResult result = fresh(pair, pose, exactSettings(tolerance));
			const QueryContext context(*pair.a.hierarchy, *pair.b.hierarchy, pose);
			std::size_t found = 0;
			for (std::uint32_t a = 0; a < pair.a.hierarchy->levels()[0].nodeCount; ++a)
				for (std::uint32_t b = 0; b < pair.b.hierarchy->levels()[0].nodeCount; ++b)
				{
					const HullDistance distance = canonicalDistance(context, a, b, tolerance);
					if (distance.lower > tolerance) continue;
					ASSERT_LT(found, result.contacts.size());
					const Contact expected{
						a, b, distance.lower, distance.upper, distance.pointOnA, distance.pointOnB, distance.normal};
					EXPECT_TRUE(sameBits(expected, result.contacts[found])) << pair.a.name << " " << a << "," << b;
					++found;
				}
			EXPECT_EQ(found, result.contacts.size());
			contacts += found;
		}
	EXPECT_GT(contacts, 100u);
}

// Leaf pairs that come within the tolerance somewhere on B's way, by brute force.
std::size_t missingOnTheWay(const BodyPair& pair, const Transform& pose, const Settings& settings,
							const GapResult& result, std::size_t& onlyOnTheWay)
{
	std::size_t missing = 0;
	for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0})
	{
		const QueryContext context(*pair.a.hierarchy, *pair.b.hierarchy, sweptPose(pose, settings.sweep, share));
		for (std::uint32_t a = 0; a < pair.a.hierarchy->levels()[0].nodeCount; ++a)
			for (std::uint32_t b = 0; b < pair.b.hierarchy->levels()[0].nodeCount; ++b)
			{
				if (canonicalDistance(context, a, b, settings.tolerance).upper > settings.tolerance) continue;
				const bool found =
					std::any_of(result.contacts.begin(), result.contacts.end(),
								[&](const Contact& contact) { return contact.nodeA == a && contact.nodeB == b; });
				missing += !found;
				onlyOnTheWay += found && share > 0;
			}
	}
	return missing;
}

TEST(Query, SweepFindsEveryPairOnTheWay)
{
	Random random(10);
	std::size_t onlyOnTheWay = 0, missedWithout = 0;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 20; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			const Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, 0, 0.03));
			Settings settings = exactSettings(0.002 * radius);
			const GapResult without = fresh(pair, pose, settings);
			settings.sweep = {0.03 * radius * randomDirection(random), 0.03 * randomDirection(random)};
			const GapResult result = fresh(pair, pose, settings);
			EXPECT_EQ(missingOnTheWay(pair, pose, settings, result, onlyOnTheWay), 0u) << pair.a.name << " " << i;
			std::size_t ignored = 0;
			missedWithout += missingOnTheWay(pair, pose, settings, without, ignored);
		}
	EXPECT_GT(onlyOnTheWay, 50u);
	EXPECT_GT(missedWithout, 50u);  // the brute force sees what a query of the pose alone leaves out
}

// Whatever a query has known of a pair before it was a contact.
TEST(Query, ContactsKnownByTheirNodesAreEvaluatedBitForBit)
{
	Random random(12);
	std::size_t contacts = 0;
	for (const BodyPair& pair : pairs())
	{
		GapCache cache;
		Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, -0.01, 0.02));
		for (int i = 0; i < 200; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			pose.translation += 2e-4 * radius * randomDirection(random);
			Settings settings = exactSettings(0.005 * radius);
			settings.contactsOnly = i % 4 != 0;
			if (i % 2) settings.sweep = {0.01 * radius * randomDirection(random), 0.01 * randomDirection(random)};
			if (i % 3) settings.metric.exact = false;
			if (i % 3 == 1) settings.metric.maxError = 0.005 * radius;
			if (i % 3 == 2) settings.metric.weightedDeviation = 0.03 * radius;
			GapResult result;
			query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
			std::vector<Contact> known;
			for (const Contact& contact : result.contacts) known.push_back({contact.nodeA, contact.nodeB, 0, 0, {}, {}, {}});
			evaluate(*pair.a.hierarchy, *pair.b.hierarchy, pose, known);
			for (std::size_t k = 0; k < known.size(); ++k)
				EXPECT_TRUE(sameBits(known[k], result.contacts[k])) << pair.a.name << " " << i << " " << k;
			contacts += known.size();
		}
	}
	EXPECT_GT(contacts, 1000u);
}

// The same question asked of the bodies in the other order: all of it is seen from the other frame.
ContactSettings seenFromB(const ContactSettings& settings, const Transform& aFromB, const OwnThreshold& ownInB)
{
	ContactSettings other = settings;
	const Transform bFromA = inverse(aFromB);
	const auto inB = [&](const Vec3& direction) { return bFromA.rotation * direction; };
	const Vec3 originOfB = aFromB.translation;  // moves with B: how, as A's frame has it
	const Vec3 ofB = settings.sweep.linear + cross(settings.sweep.angular, originOfB);
	other.sweep = {-inB(ofB), -inB(settings.sweep.angular)};
	const VelocityThreshold& velocity = settings.metric.velocity;
	other.metric.velocity.linear = -inB(velocity.linear + cross(velocity.angular, originOfB));
	other.metric.velocity.angular = -inB(velocity.angular);
	other.metric.view.eye = bFromA * settings.metric.view.eye;
	if (settings.metric.own) other.metric.own = &ownInB;
	return other;
}

// A piece larger than the other body is looked at from its own frame. Nothing of that is seen from outside: not in
// thresholds that depend on the place, nor in the order of bodies, nor in what is cached.
TEST(Query, ALargePieceIsAskedAsTheOtherBodyWouldBe)
{
	Random random(13);
	const Hierarchy& a = *body("torus", 900).hierarchy;
	const double radius = double(a.asset().radius);
	std::vector<Vec3> corners;
	for (int i = 0; i < 8; ++i)
		corners.push_back(4 * radius * Vec3{(i & 1) ? 1.0 : -1.0, (i & 2) ? 0.2 : -0.2, (i & 4) ? 1.0 : -1.0});
	const auto piece = convexPiece(convexPolyhedron(corners, 8), 0).value();
	PairCache cache;
	std::size_t contactsFound = 0;
	Transform pose{randomRotation(random), {0, 0, 0}};
	for (int i = 0; i < 300; ++i)
	{
		if (i % 20 == 0) pose.rotation = randomRotation(random);
		pose.translation = -radius * (pose.rotation * Vec3{2, 1.7 - 0.02 * (i % 20), 1});
		ContactSettings settings;
		settings.tolerance = 0.01 * radius;
		settings.sweep = {0.02 * radius * randomDirection(random), 0.05 * randomDirection(random)};
		const Vec3 eye = radius * randomDirection(random);
		const OwnThreshold own = [&](const Place& place) { return 0.1 * std::max(0.0, length(place.center - eye) - place.radius); };
		const OwnThreshold ownInB = [&](const Place& place) { return own({pose * place.center, place.radius}); };
		if (i % 5 == 0) settings.metric.exact = true;
		if (i % 5 == 1) settings.metric.maxError = 0.02 * radius;
		if (i % 5 == 2) settings.metric.own = &own;
		if (i % 5 == 3) settings.metric.velocity = {0.05, 0.001 * radius, radius * randomDirection(random), randomDirection(random)};
		if (i % 5 == 4) settings.metric.view = {2, eye, 0.005, 0.001 * radius};
		const ContactSettings other = seenFromB(settings, pose, ownInB);
		ContactResult result, cached, reverse;
		PairCache none, noneReverse;
		contacts(a, *piece, pose, settings, none, result);
		contacts(a, *piece, pose, settings, cache, cached);
		contacts(*piece, a, inverse(pose), other, noneReverse, reverse);
		ASSERT_EQ(result.contacts.size(), cached.contacts.size()) << i;
		ASSERT_EQ(result.contacts.size(), reverse.contacts.size()) << i;
		std::vector<Contact> known = result.contacts;
		for (Contact& contact : known) contact = {contact.nodeA, contact.nodeB, 0, 0, {}, {}, {}};
		evaluate(a, *piece, pose, known);
		for (std::size_t k = 0; k < known.size(); ++k)
		{
			const Contact &ours = result.contacts[k], &theirs = reverse.contacts[k];
			EXPECT_TRUE(sameBits(ours, cached.contacts[k])) << i << " " << k;
			EXPECT_TRUE(sameBits(ours, known[k])) << i << " " << k;
			EXPECT_TRUE(ours.nodeA == theirs.nodeB && ours.nodeB == theirs.nodeA) << i << " " << k;
			EXPECT_LT(length(ours.pointOnA - pose * theirs.pointOnB), 1e-9 * radius) << i << " " << k;
			EXPECT_LT(length(ours.pointOnB - pose * theirs.pointOnA), 1e-9 * radius) << i << " " << k;
			EXPECT_LT(length(ours.normal + pose.rotation * theirs.normal), 1e-9) << i << " " << k;
		}
		contactsFound += known.size();
		// Listed before, the coarsest answer is not listed again.
		settings.budget.tests = 1e6;
		PairCache listed, notListed;
		const Outline coarsest = outlineCoarsest(a, *piece, pose, settings, listed);
		contacts(a, *piece, pose, settings, listed, result);
		contacts(a, *piece, pose, settings, notListed, reverse);
		EXPECT_EQ(result.stats.boxTests + result.stats.hullTests + coarsest.listing,
				  reverse.stats.boxTests + reverse.stats.hullTests) << i;
	}
	EXPECT_GT(contactsFound, 500u);
}

TEST(Query, PrunesNothingWithinTheTolerance)
{
	// Whatever is within the tolerance by brute force over the nodes of each single level is found there too.
	Random random(9);
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 6; ++i)
		{
			const Transform pose = poseWithGap(random, pair.a, pair.b, stratifiedGap(random, i));
			const double tolerance = 0.02 * smallerRadius(pair.a, pair.b);
			const QueryContext context(*pair.a.hierarchy, *pair.b.hierarchy, pose);
			double nearest = 1e300;
			for (const auto& s : pair.a.triangles)
				for (const auto& t : pair.b.triangles)
				{
					if (length(s[0] - pose * t[0]) > 3 * smallerRadius(pair.a, pair.b)) continue;
					nearest = std::min(nearest, triangleDistance(s, {pose * t[0], pose * t[1], pose * t[2]}));
				}
			for (const double s0 : {0.0, 0.01, 0.1})
			{
				Settings settings;
				settings.tolerance = tolerance;
				settings.metric.weightedDeviation = s0 * smallerRadius(pair.a, pair.b);
				const GapResult result = fresh(pair, pose, settings);
				double lowest = tolerance;
				for (const Contact& contact : result.contacts)
					lowest = std::min(lowest, contact.lower - double(pair.a.hierarchy->node(contact.nodeA).cover) -
												  double(pair.b.hierarchy->node(contact.nodeB).cover));
				if (result.contacts.empty() && result.minDistance > 0) lowest = tolerance - result.errorBound;
				EXPECT_LE(lowest, nearest + 1e-9) << pair.a.name << " s0 " << s0;
			}
		}
}

TEST(Query, LargerThresholdNeverOpensMoreNorLooksAtFinerLevels)
{
	Random random(10);
	std::uint32_t coarsest = 0;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 6; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			const Transform pose = poseWithGap(random, pair.a, pair.b, stratifiedGap(random, i));
			std::uint32_t opened = kNone, touched = 0;
			for (double s0 = 1e-5; s0 < 10; s0 *= 2)
			{
				Settings settings;
				settings.tolerance = 0.01 * radius;
				settings.metric.weightedDeviation = s0 * radius;
				const GapResult result = fresh(pair, pose, settings);
				EXPECT_LE(result.stats.frontInner, opened);
				opened = result.stats.frontInner;
				const std::uint32_t finest = result.stats.touchedFinestLevel;
				EXPECT_GE(finest, touched);
				for (const Contact& contact : result.contacts)
					EXPECT_LE(finest, std::min(pair.a.hierarchy->node(contact.nodeA).level, pair.b.hierarchy->node(contact.nodeB).level));
				touched = finest;
			}
			coarsest = std::max(coarsest, touched);
		}
	EXPECT_GT(coarsest, 0u);
}

TEST(Query, OneBodyInsideTheOtherIsNeverApart)
{
	const Body &small = body("number8", 600), &large = body("sphere-300-large");
	ASSERT_GT(large.hierarchy->asset().radius, 3 * small.hierarchy->asset().radius);
	const double radius = small.hierarchy->asset().radius;
	for (const bool distance : {false, true})
	{
		Settings settings = exactSettings(0.001 * radius);
		settings.distance = distance;
		const GapResult result = fresh({large, small}, Transform{}, settings);
		EXPECT_LT(result.minDistance, 0);
		EXPECT_TRUE(result.deep);
		EXPECT_EQ(std::isfinite(result.errorBound), distance);
	}
}

// Coarse levels may keep apart what overlaps a little: then a corner is inside, but not the whole body.
TEST(Query, WhatIsHardlyInsideIsNotWhollyInside)
{
	Random random(81);
	const Body &small = body("number8", 600), &large = body("cup", 3000);
	const double radius = smallerRadius(small, large);
	const Vec3 corner = small.triangles[0][0];  // by which it is looked whether the body is inside
	int hidden = 0;
	for (int i = 0; i < 1000; ++i)
	{
		const auto& [p, q, r] = large.triangles[std::size_t(uniform(random, 0, double(large.triangles.size())))];
		const Vec3 up = normalized(cross(q - p, r - p));
		const double depth = uniform(random, 0.0005, 0.02) * radius;
		Transform pose{randomRotation(random), {}};
		while (dot(pose.rotation * normalized(corner), up) > -0.95) pose.rotation = randomRotation(random);
		pose.translation = (1.0 / 3) * (p + q + r) - depth * up - pose.rotation * corner;
		Settings settings = exactSettings(0.001 * radius);
		settings.contactsOnly = true;
		const auto overlaps = [](const GapResult& result)
		{ return std::any_of(result.contacts.begin(), result.contacts.end(), [](const Contact& c) { return c.upper <= 0; }); };
		if (!overlaps(fresh({large, small}, pose, settings))) continue;  // else neither is wholly inside
		for (const double share : {0.0175, 0.035, 0.07})
		{
			settings.metric = Metric{};
			settings.metric.weightedDeviation = share * radius;
			const GapResult result = fresh({large, small}, pose, settings);
			EXPECT_FALSE(result.deep) << i << " " << share;
			if (overlaps(result)) continue;
			++hidden;
			Settings withGap = settings;
			withGap.contactsOnly = false;
			EXPECT_FALSE(fresh({large, small}, pose, withGap).deep) << i << " " << share;
		}
	}
	EXPECT_GT(hidden, 30);
}

// All ways from the pair of roots down, without pruning but for boxes beyond `limit`.
struct WaysToPairs
{
	double distance = std::numeric_limits<double>::infinity();
	std::uint64_t opened = 0, children = 0, metAgain = 0;
};
WaysToPairs waysToPairs(const QueryContext& context, const StopRule& rule, double limit)
{
	WaysToPairs ways;
	std::map<std::pair<std::uint32_t, std::uint32_t>, double> least;  // of the largest box separation on a way
	std::vector<std::pair<std::uint32_t, std::uint32_t>> pending;
	const auto meet = [&](std::uint32_t a, std::uint32_t b, double above)
	{
		const double own = boxSeparation(context.boxes, context.a.cullBox(a), context.b.cullBox(b));
		const double separation = std::max(own, above);
		if (separation > limit) return;
		const auto [entry, isNew] = least.emplace(std::make_pair(a, b), separation);
		if (!isNew) ++ways.metAgain;
		if (!isNew && entry->second <= separation) return;
		entry->second = separation;
		pending.push_back({a, b});
	};
	const auto answers = [&](std::uint32_t a, std::uint32_t b)
	{
		const Acceptance acceptance = rule.acceptance(a, b);
		return acceptance == Acceptance::kYes ||
			   (acceptance == Acceptance::kWhileApart && canonicallyApart(context, a, b));
	};
	meet(context.a.root(), context.b.root(), 0);
	while (!pending.empty())
	{
		const auto [a, b] = pending.back();
		pending.pop_back();
		if (answers(a, b)) continue;
		const double above = least[{a, b}];
		const bool opensA = rule.opensA(a, b);
		for (const std::uint32_t child : rule.childrenOf(opensA, opensA ? a : b))
			meet(opensA ? child : a, opensA ? b : child, above);
	}
	for (const auto& [pair, separation] : least)
	{
		const auto [a, b] = pair;
		if (answers(a, b))
		{
			const double upper = canonicalDistance(context, a, b, std::numeric_limits<double>::infinity()).upper;
			ways.distance = std::min(ways.distance, std::max(separation, upper));
			continue;
		}
		++ways.opened;
		const bool opensA = rule.opensA(a, b);
		ways.children += rule.childrenOf(opensA, opensA ? a : b).size;
	}
	return ways;
}

// Pairs met on many ways, through children that are shared: the distance is that of the way whose boxes are nearest, as
// SurfaceDistance.h defines it, and each pair is opened once.
TEST(Query, TheDistanceIsThatOfTheNearestWayToEachPair)
{
	Random random(19);
	std::uint64_t opened = 0, boxTests = 0, metAgain = 0;
	for (const BodyPair& pair : pairs())
		for (const double share : {0.03, 1e-3, 3e-5, 3e-7})
		{
			const double radius = smallerRadius(pair.a, pair.b);
			Settings settings;
			settings.tolerance = 1e-3 * radius;
			settings.metric.weightedDeviation = share * radius;
			settings.distance = true;
			const Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, 0.05, 0.5));
			const QueryContext context(*pair.a.hierarchy, *pair.b.hierarchy, pose);
			const StopRule rule(context, settings.metric);
			const WaysToPairs ways = waysToPairs(context, rule, 2 * radius);
			NearestPairScratch scratch;
			QueryStats stats;
			EXPECT_EQ(closestDistance(context, rule, scratch, stats), ways.distance) << pair.a.name << share;
			EXPECT_LE(stats.boxTests, ways.children + 1) << pair.a.name << share;
			opened += ways.opened, boxTests += stats.boxTests, metAgain += ways.metAgain;
			EXPECT_LT(fresh(pair, pose, settings).stats.boxTests, 4 * (ways.children + 1)) << pair.a.name << share;
		}
	std::printf("%llu pairs can be opened, %llu of them met again, %llu boxes compared\n", (unsigned long long)opened,
				(unsigned long long)metAgain, (unsigned long long)boxTests);
	EXPECT_GT(metAgain, opened / 10);
}

TEST(Query, RefusesBadSettings)
{
	Settings settings = exactSettings(0.1);
	EXPECT_EQ(settingsError(settings), "");
	settings.tolerance = -1;
	EXPECT_NE(settingsError(settings).find("tolerance"), std::string::npos);
	settings.tolerance = std::nan("");
	EXPECT_NE(settingsError(settings).find("tolerance"), std::string::npos);
	for (const double error : {-1.0, std::numeric_limits<double>::quiet_NaN()})
	{
		settings = Settings{};
		settings.gapError = error;
		EXPECT_NE(settingsError(settings).find("gapError"), std::string::npos);
	}
	settings = Settings{};
	settings.metric.maxError = -1;
	EXPECT_NE(settingsError(settings).find("maxError"), std::string::npos);
	settings = exactSettings(1e38);
	EXPECT_NE(settingsError(settings).find("tolerance"), std::string::npos);
	settings = exactSettings(0.1);
	settings.sweep.linear = {0, 1e200, 0};
	EXPECT_NE(settingsError(settings).find("sweep"), std::string::npos);
}

// Of bodies as far from each other as doubles reach the distance is that of their frames, and nothing is near.
TEST(Query, WhatIsFartherThanFloatsHoldIsAnsweredAllTheSame)
{
	Random random(12);
	const Body& small = body("number8", 600);
	for (const double far : {1e30, 1e36, 1e38, 1e100, 1e155, 1e300})
		for (const bool distance : {false, true})
		{
			Settings settings = exactSettings(0.1);
			settings.distance = distance;
			const GapResult result = fresh({small, small}, {randomRotation(random), {0.6 * far, -0.8 * far, 0}}, settings);
			EXPECT_TRUE(result.contacts.empty()) << far;
			EXPECT_LT(result.errorBound, 1e-6 * far) << far;
			if (distance) EXPECT_NEAR(result.minDistance / far, 1, 1e-6) << far;
			else EXPECT_TRUE(std::isinf(result.minDistance)) << far;
		}
}
}  // namespace
