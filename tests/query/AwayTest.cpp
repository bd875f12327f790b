// SPDX-License-Identifier: GPL-3.0-or-later
// Away from contact no selection is to cost more than exact mode does (the paper's limitation, 6.3): the tests that
// queries make, counted.
#include <gtest/gtest.h>

#include <cstdio>
#include <functional>
#include <vector>

#include "tests/query/Questions.h"

namespace
{
using namespace clod;
using namespace clod::test;

std::uint64_t testsOf(const QueryStats& stats)
{
	return std::uint64_t(stats.boxTests) + stats.hullTests + stats.pointBoxes + stats.pointQueries;
}

// Two bodies whose surfaces are apart by more than the tolerance.
struct Away
{
	const char* name;
	double least, most;  // of the gap, shares of the smaller radius
	double step;         // of the motion from query to query, the same
};
constexpr double kTolerance = 0.01;  // of the radius
constexpr Away kAways[] = {{"far", 0.3, 2, 1e-3},
						   {"near", 0.06, 0.15, 1e-3},
						   {"just beyond the tolerance", 1.5 * kTolerance, 2 * kTolerance, 1e-4}};

// What is compared with exact mode, and the largest share of its tests at any of those places: of single queries
// without a cache, and of walks with one that move far each step, so that searches are not spread over many queries.
// More than 1: the claim is not kept there, by so much as was measured (levels per contact follow shared children).
struct AwayCase
{
	const char* name;
	std::function<void(Settings&, double radius)> select;
	bool contactsOnly;
	double cold, warm;
};
std::vector<AwayCase> awayCases()
{
	const auto certified = [](double share)
	{ return [share](Settings& s, double radius) { s.metric.maxError = share * radius; }; };
	const auto size = [](double share)
	{ return [share](Settings& s, double radius) { s.metric.weightedDeviation = share * radius; }; };
	const auto velocity = [](Settings& s, double radius) {
		s.metric.velocity = {0.3, 1e-3 * radius, {0.02 * radius, 0, 0}, {0, 0.01, 0}};
	};
	const auto view = [](Settings& s, double radius) { s.metric.view = {1, {0, 0, 10 * radius}, 5e-4, 0.1 * radius}; };
	return {{"certified 0.5 %", certified(0.005), true, 1, 1},
			{"certified 5 %", certified(0.05), true, 1, 1},
			{"s0 3.5 %", size(0.035), true, 1, 1.45},
			{"s0 0.35 %", size(0.0035), true, 1.95, 2.2},
			{"velocity", velocity, true, 2.05, 4.6},
			{"view", view, true, 2.1, 2.95},
			{"certified 0.5 %, gap", certified(0.005), false, 1, 1},
			{"certified 5 %, gap", certified(0.05), false, 1, 1},
			{"s0 3.5 %, gap", size(0.035), false, 1, 1.16},
			{"s0 0.35 %, gap", size(0.0035), false, 1.85, 3.4},
			{"velocity, gap", velocity, false, 1.8, 2.35},
			{"view, gap", view, false, 1.85, 2.36}};
}

Settings settingsOf(const AwayCase& c, double radius, bool isExact)
{
	Settings settings;
	settings.tolerance = kTolerance * radius;
	settings.contactsOnly = c.contactsOnly;
	if (isExact)
		settings.metric.exact = true;
	else
		c.select(settings, radius);
	return settings;
}

// Tests of all queries at the poses of a place, each from a fresh cache or with one for each walk.
std::uint64_t testsOf(const AwayCase& c, const Away& away, bool isExact, bool isWarm)
{
	Random random(51);
	std::uint64_t tests = 0;
	int near = 0;
	for (const BodyPair& pair : pairs())
		for (int walk = 0; walk < 4; ++walk)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			const Settings settings = settingsOf(c, radius, isExact);
			Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, away.least, away.most));
			GapCache cache;
			GapResult result;
			for (int i = 0; i < 40; ++i)
			{
				// Anyhow, and slowly off: 40 steps do not bring it near.
				pose.translation +=
					away.step * radius * (0.5 * randomDirection(random) + 0.6 * normalized(pose.translation));
				if (!isWarm) cache.clear();
				query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
				tests += testsOf(result.stats);
				near += isExact && !result.contacts.empty();  // coarse hulls may be nearer
			}
		}
	EXPECT_EQ(near, 0) << away.name;
	return tests;
}

void compare(bool isWarm)
{
	for (const AwayCase& c : awayCases())
		for (const Away& away : kAways)
		{
			const std::uint64_t exact = testsOf(c, away, true, isWarm), tests = testsOf(c, away, false, isWarm);
			std::printf("%s, %s: %.2f of exact mode's %llu tests\n", c.name, away.name, double(tests) / double(exact),
						(unsigned long long)exact);
			EXPECT_LE(double(tests), (isWarm ? c.warm : c.cold) * double(exact)) << c.name << ", " << away.name;
		}
}

TEST(Away, SelectionsTestNoMoreThanExactModeWithoutCaches)
{
	compare(false);
}
TEST(Away, SelectionsTestNoMoreThanExactModeWithCaches)
{
	compare(true);
}
}  // namespace
