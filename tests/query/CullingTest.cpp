// SPDX-License-Identifier: GPL-3.0-or-later
// Separations of culling boxes: a lower bound, Lipschitz in the motion, the same on any machine; the jumps over levels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "clod/query/HullCull.h"
#include "clod/collide/MotionBound.h"
#include "clod/query/QueryContext.h"
#include "tests/query/Questions.h"

namespace
{
using namespace clod;
using namespace clod::test;

TEST(BoxSeparation, IsALowerBoundAndLipschitz)
{
	Random random(8);
	for (const BodyPair& pair : pairs())
	{
		const Hierarchy &a = *pair.a.hierarchy, &b = *pair.b.hierarchy;
		const double radius = smallerRadius(pair.a, pair.b);
		for (int i = 0; i < 600; ++i)
		{
			Transform pose{randomRotation(random), randomVector(random, 0, 2 * radius)};
			const std::uint32_t n = std::uint32_t(random() % a.nodes().size),
								m = std::uint32_t(random() % b.nodes().size);
			Sweep sweep = i % 2 ? randomSweep(random, radius) : Sweep{};
			const auto separation = [&](const QueryContext& context)
			{ return boxSeparation(context.boxes, a.cullBox(n), b.cullBox(m)); };
			const QueryContext here(a, b, pose, sweep);
			const double before = separation(here);
			for (const double share : {0.0, 0.3, 0.7, 1.0})
			{
				const QueryContext onTheWay(a, b, sweptPose(pose, sweep, share));
				EXPECT_LE(before, canonicalDistance(onTheWay, n, m, 1e300).upper) << share;
			}
			EXPECT_LE(separation(here), separation(QueryContext(a, b, pose)));
			pose.rotation = randomRotation(random, 0.05) * pose.rotation;
			pose.translation += 0.02 * radius * randomDirection(random);
			const Sweep old = sweep;
			if (i % 2) sweep.linear += 0.1 * length(sweep.linear) * randomDirection(random);
			if (i % 4 == 3) sweep.angular += 0.1 * length(sweep.angular) * randomDirection(random);
			const QueryContext there(a, b, pose, sweep);
			const double motion = motionBound(here.pose, there.pose, here.radiusA, here.radiusB);
			const double change = sweepChange(here.pose, old, there.pose, sweep, motion, here.radiusB);
			EXPECT_LE(std::abs(separation(there) - before), motion + change + here.boxes.roundingOfTwo());
		}
	}
}

// Two cubes of edge 2 whose centres are 5 apart, one of which comes nearer, goes, or passes by.
TEST(BoxSeparation, IsThatOfTheNearestTimeOfTheStep)
{
	const float root = std::sqrt(3.0f);
	const OrientedBox cube{{0, 0, 0}, root, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {1, 1, 1}};
	for (int axis = 0; axis < 3; ++axis)
		for (const double side : {-1.0, 1.0})
			for (const double way : {0.0, 0.5, 2.9})
				for (const bool isNearing : {true, false})
				{
					Transform pose;
					pose.translation[axis] = 5 * side;
					Sweep sweep;
					sweep.linear[axis] = (isNearing ? -side : side) * way;
					sweep.linear[(axis + 1) % 3] = 0.3 * way;
					const BoxFrame frame(RelativePose(pose, root), sweep, 10);
					const double truth = 3 - (isNearing ? way : 0);
					EXPECT_LE(boxSeparation(frame, cube, cube), truth);
					EXPECT_GT(boxSeparation(frame, cube, cube), truth - 1e-4) << axis << ' ' << side << ' ' << way;
				}
}

// Limits within rounding of the distance: GJK may stop beyond what it was told, and the pair not be apart all the same.
// Such a pair has no points that are near.
TEST(HullCull, RemembersOnlyPointsThatWereFound)
{
	Random random(44);
	int stopped = 0, remembered = 0;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 1000; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			const Transform pose{randomRotation(random), 2.5 * radius * randomDirection(random)};
			const QueryContext context(*pair.a.hierarchy, *pair.b.hierarchy, pose, randomSweep(random, radius));
			const std::uint32_t a = std::uint32_t(random() % context.a.nodes().size),
								b = std::uint32_t(random() % context.b.nodes().size);
			double limit = canonicalSweptBound(context, a, b, std::numeric_limits<double>::infinity()).lower;
			if (!(limit > 0)) continue;
			for (int k = 0; k < 4; ++k) limit = std::nextafter(limit, 0.0);
			for (int k = 0; k < 9; ++k, limit = std::nextafter(limit, 1e300))
			{
				CachedSeparation memory;
				QueryStats stats;
				HullCull cull(context, stats);
				const bool isApart = cull.isApart(a, b, limit, memory);
				const SweptBound bound = canonicalSweptBound(context, a, b, limit, limit);
				EXPECT_EQ(isApart, bound.lower > limit);
				stopped += !isApart && !bound.hasPoints;
				if (memory.kind != CachedSeparation::Kind::kNear) continue;
				++remembered;
				EXPECT_TRUE(bound.hasPoints);
				EXPECT_LT(sweptCornerDistance(context, a, b, memory.corners), limit + 1e-6 * context.size);
			}
		}
	std::printf("%d stopped beyond the limit, not apart; %d with points\n", stopped, remembered);
	EXPECT_GT(stopped, 0);
	EXPECT_GT(remembered, 0);
}

TEST(BoxSeparation, IsTheSameInEveryLaneFromEitherSideOnAnyMachine)
{
	Random random(9);
	for (const BodyPair& pair : pairs())
	{
		const Hierarchy &a = *pair.a.hierarchy, &b = *pair.b.hierarchy;
		const double radius = smallerRadius(pair.a, pair.b);
		for (int i = 0; i < 400; ++i)
		{
			const Transform pose{randomRotation(random), randomVector(random, 0, 2 * radius)};
			const QueryContext context(a, b, pose, i % 2 ? randomSweep(random, radius) : Sweep{});
			const OrientedBox& one = a.cullBox(std::uint32_t(random() % a.nodes().size));
			const OrientedBox* others[kBoxLanes];
			for (const OrientedBox*& other : others) other = &b.cullBox(std::uint32_t(random() % b.nodes().size));
			const std::uint32_t count = 1 + std::uint32_t(random() % kBoxLanes);
			float row[kBoxLanes], plain[kBoxLanes], single[kBoxLanes];
			boxSeparations(context.boxes, one, true, others, count, row);
			const float limit = row[random() % count];  // one of them is just within
			const std::uint32_t within = boxSeparations(context.boxes, one, true, others, count, row, limit);
			ASSERT_EQ(within, boxSeparationsPlain(context.boxes, one, true, others, count, plain, limit));
			ASSERT_EQ(within >> count, 0U);
			for (std::uint32_t k = 0; k < count; ++k)
			{
				ASSERT_EQ((within >> k & 1) != 0, row[k] <= limit);
				const OrientedBox* const ofA[] = {&one};
				boxSeparations(context.boxes, *others[k], false, ofA, 1, single);
				ASSERT_EQ(row[k], plain[k]);
				ASSERT_EQ(row[k], single[0]);
			}
		}
	}
}

TEST(TraversalTables, WideChildrenReachEveryNodeOfTheBaseOnce)
{
	for (const BodyPair& pair : pairs())
		for (const Hierarchy* h : {pair.a.hierarchy.get(), pair.b.hierarchy.get()})
			for (std::uint32_t base = 0; base <= h->coarsestClodLevel(); ++base)
			{
				const TraversalTables& tables = h->derived<TraversalTables>();
				ASSERT_TRUE(tables.bounds(base).isWhole);
				std::vector<std::uint32_t> open{h->root()};
				std::vector<int> reached(h->nodes().size, 0);
				while (!open.empty())
				{
					const std::uint32_t node = open.back();
					open.pop_back();
					++reached[node];
					if (h->node(node).level <= base) continue;
					const Span<std::uint32_t> children = tables.collapsedChildren(node, base);
					EXPECT_FALSE(children.empty());
					EXPECT_LE(children.size, std::max<std::size_t>(kCollapsedChildren, h->node(node).primaryChildCount));
					for (const std::uint32_t child : children) open.push_back(child);
				}
				for (std::uint32_t node = 0; node < h->nodes().size; ++node)
				{
					const std::uint32_t level = h->node(node).level;
					EXPECT_TRUE(level > base || reached[node] == int(level == base)) << node << " base " << base;
				}
			}
}
}  // namespace
