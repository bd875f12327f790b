// SPDX-License-Identifier: GPL-3.0-or-later
// Fronts as pairs keep them: what is exact comes back as it was, bounds are rounded outward, and neither wanders.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "clod/query/PackedFront.h"
#include "tests/query/Bodies.h"

namespace
{
using namespace clod;
using namespace clod::test;
using Kind = CachedSeparation::Kind;

float someBound(Random& random)
{
	const double size = std::exp(uniform(random, -20, 5));
	const std::uint64_t kind = random() % 20;
	return kind == 0 ? 0.0F : kind == 1 ? std::numeric_limits<float>::infinity() : float(kind % 2 == 0 ? size : -size);
}

// Of small hulls, most of them.
NearCorners someCorners(Random& random)
{
	NearCorners corners;
	const std::uint64_t most = random() % 8 == 0 ? NearCorners::kMost + 1 : 256, count = 1 + random() % 4;
	for (std::uint64_t i = 0; i < count; ++i) corners.add(random() % most, random() % most, unsigned(random() % 8));
	return corners;
}

struct Front
{
	std::vector<FrontEntry> entries;
	std::vector<CachedSeparation> hulls;
};

// Breadth first, of entries of every state, with what a walk remembers of them; most nodes have few children.
Front someFront(Random& random, std::size_t most)
{
	Front front;
	front.entries.push_back({0, 0});
	if (most > 1) front.entries[0].state = NodePairState::kOpenA;
	for (std::size_t i = 0; i < front.entries.size(); ++i)
	{
		FrontEntry entry = front.entries[i];
		entry.high = someBound(random);
		const bool isOpened = isOpen(entry.state), isAnswer = entry.state == NodePairState::kAnswer;
		CachedSeparation hull;
		if (entry.state == NodePairState::kHullsApart || (isAnswer && random() % 2 == 0))
			hull.setApart(std::min(1e9, double(someBound(random))),
						  random() % 8 == 0 ? Vec3{} : randomDirection(random));
		else if ((isOpened || isAnswer) && random() % 4 != 0)
			hull.setNear(someCorners(random), randomDirection(random));
		if (entry.state != NodePairState::kElsewhere && random() % 8 != 0)
		{
			entry.hull = std::uint32_t(front.hulls.size());
			front.hulls.push_back(hull);
		}
		if (isOpened)
		{
			const std::size_t among = random() % 30 == 0 ? 1 + random() % 900 : 1 + random() % 20;
			entry.link = std::uint32_t(front.entries.size());
			for (std::size_t slot = 0; slot < among; ++slot)
			{
				if (random() % 3 == 0 || front.entries.size() >= most) continue;
				FrontEntry child{0, 0};
				child.slot = std::uint16_t(slot);
				child.state = NodePairState(1 + random() % 5);
				front.entries.push_back(child);
			}
			entry.childCount = std::uint16_t(front.entries.size() - entry.link);
		}
		if (isOpened || most == 1) entry.apart = someBound(random);
		front.entries[i] = entry;
	}
	return front;
}

// Is it no more than a bound, or no less, and hardly so?
void expectRounded(float kept, float bound, bool isUp)
{
	EXPECT_TRUE(isUp ? kept >= bound : kept <= bound) << kept << " for " << bound;
	EXPECT_TRUE(kept == bound || std::abs(double(kept) - double(bound)) <= 0x1p-15 * std::abs(double(bound)))
		<< kept << " for " << bound;
}
}  // namespace

TEST(PackedFront, GivesBackWhatItWasGivenWithBoundsRoundedOutward)
{
	Random random(27);
	PackedFront packed;
	std::vector<KeptEntry> kept;
	int longOnes = 0, near = 0, apart = 0;
	for (int i = 0; i < 300; ++i)
	{
		Front front = someFront(random, i % 10 == 0 ? 1 : 2 + random() % 2000);
		packed.pack(front.entries, front.hulls);
		ASSERT_EQ(packed.unpack(kept), front.entries.size());
		for (std::size_t k = 0; k < front.entries.size(); ++k)
		{
			const FrontEntry& entry = front.entries[k];
			ASSERT_EQ(kept[k].code.state, entry.state);
			ASSERT_EQ(kept[k].slot, entry.slot);
			expectRounded(kept[k].high, entry.high, true);
			if (isOpen(entry.state))
			{
				ASSERT_EQ(kept[k].link, entry.link);
				ASSERT_EQ(kept[k].childCount, entry.childCount);
			}
			if (isOpen(entry.state) || entry.state == NodePairState::kSeparated)
				expectRounded(kept[k].apart, entry.apart, false);
			longOnes += entry.slot > 15 || entry.childCount > 255;
			const CachedSeparation given = entry.hull == kNone ? CachedSeparation{} : front.hulls[entry.hull];
			CachedSeparation hull;
			packed.recall(kept[k], hull);
			ASSERT_EQ(hull.kind, given.kind);
			if (hull.kind == Kind::kUnknown) continue;
			if (!isOpen(entry.state))
			{
				ASSERT_EQ(hull.axis.packed(), given.axis.packed());
			}
			++(hull.isApart() ? apart : near);
			if (hull.isApart())
				expectRounded(hull.lower, given.lower, false);
			else
			{
				ASSERT_EQ(hull.corners.head, given.corners.head);
				for (int corner = 0; corner < given.corners.count(); ++corner)
				{
					ASSERT_EQ(hull.corners.ofA(corner), given.corners.ofA(corner));
					ASSERT_EQ(hull.corners.ofB(corner), given.corners.ofB(corner));
				}
			}
		}
	}
	EXPECT_GT(std::min({longOnes, near, apart}), 1000);
}

// What is kept from step to step and does not change.
TEST(PackedFront, BoundsThatAreKeptDoNotWander)
{
	Random random(28);
	PackedFront packed;
	std::vector<KeptEntry> first, again;
	Front front = someFront(random, 2000);
	packed.pack(front.entries, front.hulls);
	const std::uint32_t count = packed.unpack(first);
	for (std::size_t k = 0; k < count; ++k)
	{
		front.entries[k].high = first[k].high;
		if (isOpen(front.entries[k].state)) front.entries[k].apart = first[k].apart;
	}
	packed.pack(front.entries, front.hulls);
	ASSERT_EQ(packed.unpack(again), count);
	for (std::size_t k = 0; k < count; ++k)
	{
		EXPECT_EQ(again[k].high, first[k].high);
		if (isOpen(front.entries[k].state))
		{
			EXPECT_EQ(again[k].apart, first[k].apart);
		}
	}
}

TEST(ShortAxis, IsNoLongerThanAUnitAndHardlyAnotherDirection)
{
	Random random(29);
	for (int i = 0; i < 10000; ++i)
	{
		Vec3 axis = randomDirection(random);
		if (i < 6) axis = Vec3{}, axis[i / 2] = i % 2 == 0 ? 1 : -1;
		const ShortAxis packed(axis);
		const Vec3 kept = packed.get();
		for (int k = 0; k < 3; ++k)
		{
			EXPECT_LE(std::abs(kept[k]), std::abs(axis[k]));
			EXPECT_LE(std::abs(kept[k] - axis[k]), ShortAxis::kStep);
		}
		EXPECT_EQ(ShortAxis(kept).packed(), packed.packed());
		EXPECT_EQ(ShortAxis(packed.packed()).get()[i % 3], kept[i % 3]);
	}
	EXPECT_EQ(length(ShortAxis(Vec3{}).get()), 0);
}
