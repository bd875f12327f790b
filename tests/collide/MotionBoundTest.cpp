// SPDX-License-Identifier: GPL-3.0-or-later
// What a cached answer may be wrong by, against points that are moved: as seen from either body, along axes of either,
// and what a look-ahead changes by.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clod/collide/MotionBound.h"
#include "tests/query/Bodies.h"

namespace
{
using namespace clod;
using namespace clod::test;

// Reaches of A and B: either may be the larger by far.
constexpr double kRadii[][2] = {{1, 1}, {10, 0.1}, {0.1, 10}};

struct Motion
{
	RelativePose from, to;
};
Motion randomMotion(Random& random, double radiusA, double radiusB, double turn, double shift)
{
	const double radius = std::max(radiusA, radiusB);
	const Transform first{randomRotation(random), randomVector(random, 0, 2 * radius)};
	const Transform second{randomRotation(random, turn) * first.rotation,
						   first.translation + shift * randomDirection(random)};
	return {RelativePose(first, radius), RelativePose(second, radius)};
}
Vec3 toA(const RelativePose& pose, const Vec3& ofB)
{
	return pose.rotation * ofB + pose.translation;
}
Vec3 toB(const RelativePose& pose, const Vec3& ofA)
{
	return transposed(pose.rotation) * (ofA - pose.translation);
}

// Floats that are kept from step to step: their own rounding never makes a bound better than it is.
TEST(MotionBound, KeptBoundsLoseByRounding)
{
	Random random(11);
	for (int i = 0; i < 20000; ++i)
	{
		// A motion larger than the bound leaves nothing of it that could decide.
		const float bound = float(uniform(random, -1, 1)), moved = std::abs(bound) * float(std::pow(10, uniform(random, -9, 0)));
		ASSERT_LE(double(lowerAfter(bound, moved)), double(bound) - double(moved)) << bound << " " << moved;
		ASSERT_GE(double(upperAfter(bound, moved)), double(bound) + double(moved)) << bound << " " << moved;
		ASSERT_NEAR(double(lowerAfter(bound, moved)), double(bound) - double(moved), 1e-6);
		ASSERT_NEAR(double(upperAfter(bound, moved)), double(bound) + double(moved), 1e-6);
	}
}

TEST(MotionBound, NoPointOfEitherBodyMovesFartherAsSeenFromTheOther)
{
	Random random(61);
	for (const auto& [radiusA, radiusB] : kRadii)
		for (const double turn : {0.0, 1e-3, 0.5})
		{
			double tightest = 0;
			bool decidedByA = false;  // no point of B moves so far
			for (int i = 0; i < 200; ++i)
			{
				// About A's middle, as if A turned alone; or anyhow.
				const double shift = i % 2 == 0 && turn > 0 ? 0 : uniform(random, 0, 0.1);
				const Motion motion = randomMotion(random, radiusA, radiusB, turn, shift);
				const double bound = motionBound(motion.from, motion.to, radiusA, radiusB);
				double farthestOfA = 0, farthestOfB = 0;
				for (int k = 0; k < 50; ++k)
				{
					const Vec3 a = radiusA * randomDirection(random), b = radiusB * randomDirection(random);
					farthestOfA = std::max(farthestOfA, length(toB(motion.to, a) - toB(motion.from, a)));
					farthestOfB = std::max(farthestOfB, length(toA(motion.to, b) - toA(motion.from, b)));
				}
				ASSERT_LE(std::max(farthestOfA, farthestOfB), bound) << radiusA << " " << radiusB << " " << turn;
				if (bound > 1e-6) tightest = std::max(tightest, std::max(farthestOfA, farthestOfB) / bound);
				decidedByA = decidedByA || farthestOfA > 1.01 * farthestOfB;
			}
			EXPECT_GT(tightest, 0.9) << radiusA << " " << radiusB << " " << turn;
			EXPECT_TRUE(decidedByA || turn == 0 || radiusA < radiusB) << radiusA << " " << radiusB << " " << turn;
		}
}

TEST(MotionBound, NoPointOfAPartMovesFartherAlongADirection)
{
	Random random(62);
	double least = 1e300;  // of what is left, of the radius
	for (int i = 0; i < 300; ++i)
	{
		const Motion motion = randomMotion(random, 1, 1, 0.3, uniform(random, 0, 0.2));
		const PartMotion parts(motion.from, motion.to);
		const Vec3 center = randomVector(random, 0, 0.7), along = randomDirection(random);
		const double radius = uniform(random, 0, 0.3), bound = parts.of(center, radius).along(along);
		for (int k = 0; k < 50; ++k)
		{
			const Vec3 point = center + radius * randomDirection(random);
			const double moved = dot(along, toA(motion.to, point) - toA(motion.from, point));
			ASSERT_LE(moved, bound);
			least = std::min(least, (bound - moved) / radius);
		}
	}
	EXPECT_LT(least, 0.05);
}

// Which parts of a sweep change, and what else moves.
TEST(Sweep, ASegmentIsAsFarAsItsNearestPoint)
{
	Random random(9);
	for (int i = 0; i < 5000; ++i)
	{
		const Vec3 p = randomVector(random, 0, 2), move = i % 10 ? randomVector(random, 0, 2) : Vec3{};
		double sampled = length(p);
		for (int k = 1; k <= 200; ++k) sampled = std::min(sampled, length(p + (k / 200.0) * move));
		const double distance = distanceToSegment(p, move);
		ASSERT_LE(distance, sampled + 1e-12) << i;
		ASSERT_GE(distance, sampled - length(move) / 200) << i;
	}
}

struct SweepCase
{
	const char* name;
	bool linear, angular, turns;
	double tightest;  // share of the bound that is reached at least
};
constexpr SweepCase kSweepCases[] = {{"linear part", true, false, false, 0.9},
									 {"angular part", false, true, false, 0.3},
									 {"the bodies' poses", false, false, true, 0.2},
									 {"all of it", true, true, true, 0.2}};

TEST(MotionBound, NoSweepOfAPointChangesByMore)
{
	Random random(63);
	for (const auto& [radiusA, radiusB] : kRadii)
		for (const SweepCase& c : kSweepCases)
		{
			double tightest = 0;
			for (int i = 0; i < 200; ++i)
			{
				const double size = std::max(radiusA, radiusB);
				const Motion motion = randomMotion(random, radiusA, radiusB, c.turns ? 0.3 : 0, c.turns ? 0.1 * size : 0);
				const Sweep before{size * randomDirection(random), randomVector(random, 0, 1)};
				Sweep now = before;
				if (c.linear) now.linear += 0.3 * size * randomDirection(random);
				// About the middle of B, whose origin goes the same way as before.
				if (c.angular) now.angular += 0.3 * randomDirection(random);
				if (c.angular && !c.linear)
					now.linear += cross(before.angular - now.angular, motion.from.translation);
				const double bound = sweepChange(motion.from, before, motion.to, now,
												 motionBound(motion.from, motion.to, radiusA, radiusB), radiusB);
				for (int k = 0; k < 50; ++k)
				{
					const Vec3 point = radiusB * randomDirection(random), axis = randomDirection(random);
					const Vec3 was = before.of(toA(motion.from, point)), is = now.of(toA(motion.to, point));
					const double alongB = std::abs(dot(is, motion.to.rotation * axis) -
												   dot(was, motion.from.rotation * axis));
					const double changed = std::max(length(is - was), alongB);
					ASSERT_LE(changed, bound + 1e-12 * size) << c.name << ", radius of B " << radiusB;
					tightest = std::max(tightest, changed / bound);
				}
			}
			EXPECT_GT(tightest, c.tightest) << c.name << ", radius of B " << radiusB;
		}
}
}  // namespace
