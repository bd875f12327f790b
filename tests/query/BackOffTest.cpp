// SPDX-License-Identifier: GPL-3.0-or-later
// How long what was tried in vain is left be, counted.
#include <gtest/gtest.h>

#include <vector>

#include "clod/query/BackOff.h"
#include "tests/query/Questions.h"

namespace
{
using namespace clod;
using namespace clod::test;

// Turns until it is over.
int waits(BackOff& backOff)
{
	int turns = 0;
	for (; !backOff.isOver(); ++turns) EXPECT_LT(turns, 1000);
	return turns;
}

TEST(BackOff, WaitsTwiceAsLongEachTimeUpToALimitAndNotAfterASuccess)
{
	for (const int most : {15, 63, 20})
	{
		BackOff backOff{std::uint32_t(most)};
		EXPECT_EQ(waits(backOff), 0);
		for (const int expected : {1, 3, 7, 15, 31, 63, 127})
		{
			backOff.fail();
			EXPECT_EQ(waits(backOff), std::min(expected, most)) << most;
			EXPECT_EQ(waits(backOff), 0) << most;  // over till it fails again
		}
		backOff.succeed();
		EXPECT_EQ(waits(backOff), 0);
		backOff.fail();
		EXPECT_EQ(waits(backOff), 1);
	}
}

// Bodies far apart that leap between two places: the search of how far they may go is used `uses` times, by steps that
// are no leap. Returns the leaps after which it was made.
std::vector<int> searches(int leaps, int uses)
{
	const Body& cube = body("cube");
	Settings settings = exactSettings(0.01);
	settings.contactsOnly = true;
	GapCache cache;
	GapResult result;
	std::vector<int> found;
	double side = 0;
	for (int leap = 0; leap < leaps; ++leap)
	{
		for (int step = 0; step <= uses; ++step)
		{
			const Transform pose{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
								 {10.0, leap % 2 == 0 ? 30.0 : -30.0, side += 1e-9}};
			query(*cube.hierarchy, *cube.hierarchy, pose, settings, cache, result);
			// A traversal compares the two roots' boxes alone.
			const bool isSearched = result.stats.boxTests + result.stats.hullTests > 1;
			if (isSearched) found.push_back(leap);
			EXPECT_TRUE(step == 0 || result.stats.stillApart || found.empty() || found.back() != leap) << leap;
		}
	}
	return found;
}

TEST(BackOff, ASearchThatIsNotUsedIsMadeAgainLaterAndLater)
{
	EXPECT_EQ(searches(330, 0), (std::vector<int>{0, 2, 6, 14, 30, 62, 126, 190, 254, 318}));
}
TEST(BackOff, ASearchIsWorthItsCostForFourQueries)
{
	EXPECT_EQ(searches(6, 4), (std::vector<int>{0, 1, 2, 3, 4, 5}));
	EXPECT_LT(searches(6, 3).size(), 6u);
}
}  // namespace
