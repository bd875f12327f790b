// SPDX-License-Identifier: GPL-3.0-or-later
// The levels that answer a certified limit: against all pairs of levels, what queries find of them against all pairs of
// their nodes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "clod/hierarchy/ConvexPiece.h"
#include "clod/query/QueryContext.h"
#include "clod/query/StopRule.h"
#include "tests/query/Questions.h"

namespace
{
using namespace clod;
using namespace clod::test;

struct Worst
{
	double cover = 0, protrude = 0, nodes = 0;
};
Worst worstOf(const Hierarchy& hierarchy, std::uint32_t level)
{
	Worst worst;
	for (const Node& node : hierarchy.nodes())
	{
		if (node.level != level) continue;
		worst.cover = std::max(worst.cover, double(node.cover));
		worst.protrude = std::max(worst.protrude, double(node.protrude));
		++worst.nodes;
	}
	return worst;
}
// The mean of the boxes' Minkowski sums over all directions of one of them, pair by pair: V + V' + (S M' + M S') / (4
// pi). A box has M = pi (x + y + z).
double meetingByPairs(const Hierarchy& a, std::uint32_t levelA, const Hierarchy& b, std::uint32_t levelB)
{
	const auto edges = [](const OrientedBox& box) {
		return 2 * Vec3{double(box.half[0]), double(box.half[1]), double(box.half[2])};
	};
	const auto surface = [](const Vec3& e) { return 2 * (e.x * e.y + e.y * e.z + e.z * e.x); };
	const double pi = std::acos(-1.0);
	double sum = 0;
	for (std::uint32_t i = 0; i < a.levels()[levelA].nodeCount; ++i)
		for (std::uint32_t j = 0; j < b.levels()[levelB].nodeCount; ++j)
		{
			const Vec3 e = edges(a.cullBox(a.levels()[levelA].firstNode + i)),
					   f = edges(b.cullBox(b.levels()[levelB].firstNode + j));
			sum += e.x * e.y * e.z + f.x * f.y * f.z +
				   (surface(e) * pi * (f.x + f.y + f.z) + pi * (e.x + e.y + e.z) * surface(f)) / (4 * pi);
		}
	return sum;
}

// Of all pairs of contact levels: the fewest pairs of nodes, the leaves unless those are a quarter of theirs, or the
// fewest boxes that meet, if those are three quarters.
BaseLevels bestThatKeep(double limit, const Hierarchy& a, const Hierarchy& b)
{
	const auto pairsOf = [&](const BaseLevels& l) { return worstOf(a, l.a).nodes * worstOf(b, l.b).nodes; };
	const auto meeting = [&](const BaseLevels& l) { return meetingByPairs(a, l.a, b, l.b); };
	const BaseLevels leaves{0, 0};
	BaseLevels best = leaves, slim = leaves;
	for (std::uint32_t i = 0; i <= a.coarsestClodLevel(); ++i)
	{
		std::uint32_t keeps = kNone;  // the coarsest
		const Worst ofA = worstOf(a, i);
		for (std::uint32_t j = 0; j <= b.coarsestClodLevel(); ++j)
		{
			const Worst ofB = worstOf(b, j);
			if (ofA.cover + ofB.cover <= limit && ofA.protrude + ofB.protrude <= limit) keeps = j;
		}
		if (keeps == kNone) continue;
		const BaseLevels next{i, keeps};
		if (pairsOf(next) < pairsOf(best)) best = next;
		if (meeting(next) < meeting(slim)) slim = next;
	}
	if (pairsOf(best) > 0.25 * pairsOf(leaves)) best = leaves;
	return meeting(slim) < 0.75 * meeting(best) ? slim : best;
}

TEST(BaseLevels, MeetingBoxesAreThoseOfAllPairs)
{
	for (const BodyPair& pair : pairs())
	{
		const Hierarchy &a = *pair.a.hierarchy, &b = *pair.b.hierarchy;
		for (std::uint32_t i = 0; i <= a.coarsestClodLevel(); ++i)
			for (std::uint32_t j = 0; j <= b.coarsestClodLevel(); ++j)
			{
				const double expected = meetingByPairs(a, i, b, j);
				EXPECT_NEAR(meetingBoxes(a.derived<TraversalTables>().bounds(i), b.derived<TraversalTables>().bounds(j)), expected, 1e-9 * expected);
			}
	}
}

TEST(BaseLevels, ACertifiedLimitIsAnsweredByTheLevelsThatKeepIt)
{
	int used = 0, leaves = 0;
	for (const BodyPair& pair : pairs())
	{
		const Hierarchy &a = *pair.a.hierarchy, &b = *pair.b.hierarchy;
		const QueryContext context(a, b, Transform{});
		for (double share = 1e-7; share < 10; share *= 1.3)
		{
			Metric metric;
			metric.maxError = share * smallerRadius(pair.a, pair.b);
			const BaseLevels expected = bestThatKeep(metric.maxError, a, b);
			EXPECT_EQ(StopRule(context, metric).base(), expected) << pair.a.name << " " << share;
			++(expected.isOfLeaves() ? leaves : used);
			metric.weightedDeviation = 0.1 * metric.maxError;  // may ask for finer nodes
			EXPECT_EQ(StopRule(context, metric).base().isUsed(), expected.isOfLeaves());
		}
	}
	std::printf("%d limits answered by simplified levels, %d by the input surfaces\n", used, leaves);
	EXPECT_GT(used, 50);
	EXPECT_GT(leaves, 20);
}

// A ball's core is a point, whose box meets the more boxes the more of a body's volume they hold, which is most on coarse
// levels. Grown by its radius it meets the fewest of the coarsest level that keeps the limit.
TEST(BaseLevels, OfABallCountHowFarItReaches)
{
	const Body cup = body("cup-3000");
	const double radius = 0.3 * double(cup.hierarchy->asset().radius);
	const std::shared_ptr<const Hierarchy> ball = convexPiece(convexPolyhedron({{0, 0, 0}}, 1), radius).value();
	const QueryContext context(*cup.hierarchy, *ball, Transform{});
	for (const double share : {0.05, 0.1, 0.3})
	{
		Metric metric;
		metric.maxError = share * radius;
		std::uint32_t coarsest = 0;
		for (std::uint32_t level = 1; level <= cup.hierarchy->coarsestClodLevel(); ++level)
		{
			const Worst worst = worstOf(*cup.hierarchy, level);
			if (std::max(worst.cover, worst.protrude) <= metric.maxError) coarsest = level;
		}
		EXPECT_GT(coarsest, 0u) << share;
		EXPECT_EQ(StopRule(context, metric).base().a, coarsest) << share;
	}
}

// All pairs of nodes of the base levels, and what stands for those that overlap where their error would then be too
// large.
TEST(BaseLevels, ACertifiedLimitFindsEveryPairOfTheBaseLevels)
{
	Random random(29);
	std::size_t contacts = 0, opened = 0;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 200; ++i)
		{
			const Hierarchy &a = *pair.a.hierarchy, &b = *pair.b.hierarchy;
			const double radius = smallerRadius(pair.a, pair.b);
			Settings settings;
			settings.tolerance = uniform(random, 0, 0.05) * radius;
			settings.metric.maxError = std::pow(10, uniform(random, -3, -0.5)) * radius;
			const Transform pose = poseWithGap(random, pair.a, pair.b, stratifiedGap(random, i));
			const QueryContext context(a, b, pose);
			const StopRule rule(context, settings.metric);
			if (!rule.base().isUsed()) continue;
			const Level levelA = a.levels()[rule.base().a], levelB = b.levels()[rule.base().b];
			if (double(levelA.nodeCount) * double(levelB.nodeCount) > 3e5) continue;
			const GapResult result = fresh(pair, pose, settings);
			std::size_t ofBase = 0, expected = 0;
			for (const Contact& contact : result.contacts)
				ofBase += a.node(contact.nodeA).level == rule.base().a && b.node(contact.nodeB).level == rule.base().b;
			for (std::uint32_t nodeA = levelA.firstNode; nodeA < levelA.firstNode + levelA.nodeCount; ++nodeA)
				for (std::uint32_t nodeB = levelB.firstNode; nodeB < levelB.firstNode + levelB.nodeCount; ++nodeB)
				{
					const HullDistance distance = canonicalDistance(context, nodeA, nodeB, settings.tolerance);
					if (distance.lower > settings.tolerance) continue;
					const bool isOpened = !rule.isOfLeaves() && distance.lower <= 0 &&
										  certifiedError(a.node(nodeA), b.node(nodeB)) > settings.metric.maxError;
					opened += isOpened;
					if (isOpened) continue;
					++expected;
					const auto found = std::find_if(result.contacts.begin(), result.contacts.end(),
													[&](const Contact& contact)
													{ return contact.nodeA == nodeA && contact.nodeB == nodeB; });
					ASSERT_NE(found, result.contacts.end()) << pair.a.name << " pose " << i;
					EXPECT_EQ(found->upper, distance.upper);
				}
			EXPECT_EQ(ofBase, expected) << pair.a.name << " pose " << i;
			contacts += expected;
		}
	std::printf("%zu contacts, %zu pairs opened further\n", contacts, opened);
	EXPECT_GT(contacts, 500u);
	EXPECT_GT(opened, 50u);
}

// Surfaces just within the tolerance whose levels' hulls are beyond it: the bound says so.
TEST(BaseLevels, ABoundOfBaseLevelsHoldsJustBelowTheTolerance)
{
	Random random(37);
	int onlyByCover = 0;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 120; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			Settings settings;
			settings.tolerance = 0.02 * radius;
			settings.metric.maxError = std::pow(10, uniform(random, -3, -1)) * radius;
			const Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, 0.017, 0.023));
			const QueryContext context(*pair.a.hierarchy, *pair.b.hierarchy, pose);
			const StopRule rule(context, settings.metric);
			if (!rule.base().isUsed()) continue;
			const double truth = fresh(pair, pose, exactSettings(0.04 * radius)).minDistance;
			const GapResult result = fresh(pair, pose, settings);
			const bool isFar = result.contacts.empty();
			EXPECT_LE((isFar ? settings.tolerance : result.minDistance) - result.errorBound, truth)
				<< pair.a.name << " pose " << i;
			const double covers =
				worstOf(*pair.a.hierarchy, rule.base().a).cover + worstOf(*pair.b.hierarchy, rule.base().b).cover;
			EXPECT_EQ(isFar ? result.errorBound : covers, covers);  // pairs culled above the base levels count, too
			onlyByCover += isFar && truth < settings.tolerance;
		}
	std::printf("%d surfaces within the tolerance, their levels not\n", onlyByCover);
	EXPECT_GT(onlyByCover, 10);
}

// What no simplified level keeps is answered as in exact mode.
TEST(BaseLevels, ALimitOutOfReachCostsWhatExactDoes)
{
	Random random(29);
	int withContacts = 0;
	for (const BodyPair& pair : pairs())
	{
		const Worst ofA = worstOf(*pair.a.hierarchy, 1), ofB = worstOf(*pair.b.hierarchy, 1);
		const double radius = smallerRadius(pair.a, pair.b);
		const double least = std::min(std::max(ofA.cover, ofA.protrude), std::max(ofB.cover, ofB.protrude));
		for (int i = 0; i < 20; ++i)
		{
			const Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, 0, 0.01));
			const Settings exact = exactSettings(0.02 * radius);
			const GapResult expected = fresh(pair, pose, exact);
			Settings limited = exact;
			limited.metric.exact = false;
			limited.metric.maxError = 0.99 * least;
			const GapResult result = fresh(pair, pose, limited);
			EXPECT_EQ(difference(result, expected), "") << pair.a.name << " pose " << i;
			EXPECT_EQ(result.stats.boxTests, expected.stats.boxTests);
			withContacts += !expected.contacts.empty();
		}
	}
	EXPECT_GT(withContacts, 40);
}
}  // namespace
