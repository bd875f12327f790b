// SPDX-License-Identifier: GPL-3.0-or-later
// What a query says of its answer besides contacts, reckoned once more by hand: the certified bound, and the levels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clod/distance/GapCertificate.h"
#include "clod/query/StopRule.h"
#include "tests/query/Questions.h"

namespace
{
using namespace clod;
using namespace clod::test;

// Equal, but for the last bits that are rounded up.
void expectBound(double bound, double byHand)
{
	EXPECT_GE(bound, byHand);
	EXPECT_LE(bound, (1 + 1e-11) * byHand);
}

TEST(Report, ABoundIsTheFartherEndOfItsInterval)
{
	const Gap between = gapBetween(-3, 1);
	EXPECT_EQ(between.value, -1);
	expectBound(between.errorBound, 2);
	const Gap below = gapOfSurfaces({1, 5, 4}), above = gapOfSurfaces({1, 5, 2});
	EXPECT_EQ(below.value, 4);
	expectBound(below.errorBound, 3);
	expectBound(above.errorBound, 3);
}

TEST(Report, TheErrorOfAPairIsThatOfItsNodesNumbers)
{
	Node a{}, b{};
	a.cover = 1, b.cover = 2;
	a.protrude = 0.5f, b.protrude = 4;
	EXPECT_EQ(certifiedErrorApart(a, b), 4.5);
	b.protrude = 0.25f;
	EXPECT_EQ(certifiedErrorApart(a, b), 3);
	// Below by 8 + 1, proven by 10 + 2: half of the two together exceeds what counts while they are apart.
	a.reach = 8, b.reach = 10;
	a.surf = 2, b.surf = 1;
	EXPECT_EQ(certifiedError(a, b), 0.5 * (12 + 12));
	EXPECT_EQ(certifiedError(b, a), certifiedError(a, b));
	a.reach = b.reach = 1;
	a.surf = b.surf = 0;
	EXPECT_EQ(certifiedError(a, b), 3);
}

struct Levels
{
	std::uint32_t finest = kNone, coarsest = 0;
};
Levels levelsOf(const Hierarchy& hierarchy, const GapResult& result, std::uint32_t Contact::*node)
{
	Levels levels;
	for (const Contact& contact : result.contacts)
	{
		levels.finest = std::min(levels.finest, hierarchy.node(contact.*node).level);
		levels.coarsest = std::max(levels.coarsest, hierarchy.node(contact.*node).level);
	}
	return levels;
}

// Of the two bodies either may have the finer contacts: a box has but one level.
TEST(Report, LevelsAreOfBothBodies)
{
	Random random(81);
	int decided[2][2] = {};  // the finest and the coarsest level by A alone, by B alone
	const Body &box = body("box", 12), &torus = body("torus", 900);
	for (const BodyPair& pair : {BodyPair{box, torus}, BodyPair{torus, box}, BodyPair{torus, torus}})
		for (int i = 0; i < 12; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			Settings settings;
			settings.tolerance = 0.05 * radius;
			settings.metric.weightedDeviation = std::pow(10, uniform(random, -3, 0)) * radius;
			const GapResult result = fresh(pair, poseWithGap(random, pair.a, pair.b, 0.005), settings);
			ASSERT_FALSE(result.contacts.empty());
			const Levels a = levelsOf(*pair.a.hierarchy, result, &Contact::nodeA),
						 b = levelsOf(*pair.b.hierarchy, result, &Contact::nodeB);
			EXPECT_EQ(result.stats.finestLevel, std::min(a.finest, b.finest)) << pair.a.name << " " << i;
			EXPECT_EQ(result.stats.coarsestLevel, std::max(a.coarsest, b.coarsest)) << pair.a.name << " " << i;
			++decided[0][b.finest < a.finest];
			++decided[1][b.coarsest > a.coarsest];
		}
	EXPECT_GT(std::min({decided[0][0], decided[0][1], decided[1][0], decided[1][1]}), 5);
}

// The gap as the nodes prove it: no wider than the contacts' own numbers say.
TEST(Report, TheBoundOfNodesIsTheOneTheyProve)
{
	Random random(82);
	int byNodes = 0;
	const Body &box = body("box", 12), &torus = body("torus", 900);
	for (const BodyPair& pair : {BodyPair{torus, torus}, BodyPair{box, torus}})
		for (int i = 0; i < 30; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			Settings settings;
			settings.tolerance = 0.3 * radius;  // far beyond what any pair covers
			settings.metric.weightedDeviation = std::pow(10, uniform(random, -3, -1)) * radius;
			const GapResult result =
				fresh(pair, poseWithGap(random, pair.a, pair.b, uniform(random, 0.02, 0.2)), settings);
			if (result.stats.gapSearches > 0 || result.contacts.empty() || result.minDistance <= 0) continue;
			double low = settings.tolerance, high = kOff, value = kOff;
			for (const Contact& contact : result.contacts)
			{
				const Node &a = pair.a.hierarchy->node(contact.nodeA), &b = pair.b.hierarchy->node(contact.nodeB);
				low = std::min(low, contact.lower - (double(a.cover) + double(b.cover)));
				high = std::min(high, contact.upper + double(a.protrude) + double(b.protrude));
				value = std::min(value, contact.upper);
			}
			if (!(low < 0.7 * settings.tolerance)) continue;
			EXPECT_EQ(result.minDistance, value);
			expectBound(result.errorBound, std::max(value - low, high - value));
			++byNodes;
		}
	EXPECT_GT(byNodes, 20);
}
}  // namespace
