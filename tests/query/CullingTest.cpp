// SPDX-License-Identifier: GPL-3.0-or-later
// Separations of culling boxes: a lower bound, Lipschitz in the motion, the same on any machine; the jumps over levels.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "clod/query/MotionBound.h"
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
			Transform pose{randomRotation(random), uniform(random, 0, 2) * radius * randomDirection(random)};
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
			const double motion = motionBound(here.pose, there.pose, here.reachA, here.reachB);
			const double change = sweepChange(here.pose, old, there.pose, sweep, motion, here.reachB);
			EXPECT_LE(std::abs(separation(there) - before), motion + change + here.boxes.roundingOfTwo());
		}
	}
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
			const Transform pose{randomRotation(random), uniform(random, 0, 2) * radius * randomDirection(random)};
			const QueryContext context(a, b, pose, i % 2 ? randomSweep(random, radius) : Sweep{});
			const CullBox& one = a.cullBox(std::uint32_t(random() % a.nodes().size));
			const CullBox* others[kBoxLanes];
			for (const CullBox*& other : others) other = &b.cullBox(std::uint32_t(random() % b.nodes().size));
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
				const CullBox* const ofA[] = {&one};
				boxSeparations(context.boxes, *others[k], false, ofA, 1, single);
				ASSERT_EQ(row[k], plain[k]);
				ASSERT_EQ(row[k], single[0]);
			}
		}
	}
}

TEST(Hierarchy, WideChildrenReachEveryLeafOnce)
{
	for (const BodyPair& pair : pairs())
		for (const Hierarchy* h : {pair.a.hierarchy.get(), pair.b.hierarchy.get()})
		{
			std::vector<std::uint32_t> open{h->root()};
			std::vector<int> reached(h->nodes().size, 0);
			while (!open.empty())
			{
				const std::uint32_t node = open.back();
				open.pop_back();
				++reached[node];
				EXPECT_EQ(h->wideChildren(node).empty(), h->node(node).childCount == 0);
				EXPECT_LE(h->wideChildren(node).size,
						  std::max<std::size_t>(kWideChildren, h->node(node).primaryChildCount));
				for (const std::uint32_t child : h->wideChildren(node)) open.push_back(child);
			}
			for (std::uint32_t node = 0; node < h->levels()[0].nodeCount; ++node) EXPECT_EQ(reached[node], 1) << node;
		}
}
}  // namespace
