// SPDX-License-Identifier: GPL-3.0-or-later
// Points and segments against boxes: never farther than they are, and hardly nearer.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clod/collide/BoxSeparation.h"
#include "tests/query/Bodies.h"

namespace
{
using namespace clod;
using namespace clod::test;

// The ball may be the smaller, so that the box's corners are cut off, or hold the box.
OrientedBox randomBox(Random& random)
{
	OrientedBox box;
	const Mat3 axes = randomRotation(random);
	const Vec3 center = randomVector(random, 0, 2);
	double corner = 0;
	for (int i = 0; i < 3; ++i)
	{
		box.center[i] = float(center[i]);
		for (int k = 0; k < 3; ++k) box.axis[i][k] = float(axes.row[i][k]);
		box.half[i] = float(std::pow(10, uniform(random, -2, 0)));
		corner += double(box.half[i]) * double(box.half[i]);
	}
	box.radius = float(uniform(random, 0.5, 1.2) * std::sqrt(corner));
	return box;
}
// In the box's own axes.
Vec3 into(const OrientedBox& box, const Vec3& p)
{
	const Vec3 offset = p - centerOf(box);
	return {dot(toVec3(box.axis[0]), offset), dot(toVec3(box.axis[1]), offset), dot(toVec3(box.axis[2]), offset)};
}

TEST(BoxDistance, IsThatOfTheBoxOrOfTheBallWhicheverIsFarther)
{
	Random random(71);
	int byBall = 0, inside = 0;
	constexpr int kPoints = 20000;
	for (int i = 0; i < kPoints; ++i)
	{
		const OrientedBox box = randomBox(random);
		const Vec3 point = centerOf(box) + randomVector(random, 0, 4);
		const Vec3 in = into(box, point);
		Vec3 beyond;
		for (int k = 0; k < 3; ++k) beyond[k] = std::max(0.0, std::abs(in[k]) - double(box.half[k]));
		const double toBall = std::max(0.0, length(in) - double(box.radius)), truth = std::max(length(beyond), toBall);
		const double bound = boxDistance(box, point);
		ASSERT_LE(bound, truth) << i;
		ASSERT_GE(bound, truth - 1e-5 * (1 + length(in))) << i;
		byBall += toBall > length(beyond);
		inside += truth == 0;
	}
	EXPECT_GT(byBall, kPoints / 10);
	EXPECT_GT(inside, kPoints / 100);
}

TEST(BoxMisses, NoSegmentThatPassesThroughAndMostOthers)
{
	Random random(72);
	int met = 0, missed = 0;
	constexpr int kSegments = 20000;
	for (int i = 0; i < kSegments; ++i)
	{
		const OrientedBox box = randomBox(random);
		const Vec3 grown = i % 2 ? Vec3{} : 0.1 * Vec3{uniform(random, 0, 1), uniform(random, 0, 1), uniform(random, 0, 1)};
		const Vec3 from = centerOf(box) + randomVector(random, 0, 2), to = centerOf(box) + randomVector(random, 0, 2);
		// Of 65 points of the segment: the least excess over the grown box's faces.
		double least = 1e30;
		for (int k = 0; k <= 64; ++k)
		{
			const Vec3 in = into(box, from + (k / 64.0) * (to - from));
			double excess = -1e30;
			for (int axis = 0; axis < 3; ++axis)
			{
				const Vec3 a = toVec3(box.axis[axis]);
				const double reach = std::abs(a.x) * grown.x + std::abs(a.y) * grown.y + std::abs(a.z) * grown.z;
				excess = std::max(excess, std::abs(in[axis]) - double(box.half[axis]) - reach);
			}
			least = std::min(least, excess);
		}
		const bool isMiss = misses(box, grown, from, to);
		met += least <= 0;
		missed += isMiss;
		if (least <= 0) { ASSERT_FALSE(isMiss) << i; }
		if (least > length(to - from) / 64 + 1e-4) { ASSERT_TRUE(isMiss) << i; }
	}
	EXPECT_GT(met, kSegments / 20);
	EXPECT_GT(missed, kSegments / 4);
}
}  // namespace
