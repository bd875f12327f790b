// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies with a cavity: what lies in it is apart or touches its wall, what lies in the wall is inside the solid, by a
// depth that brute force and a closed form know.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "clod/hierarchy/ScaledHierarchy.h"
#include "tests/distance/CavityBodies.h"
#include "tests/query/Questions.h"

namespace
{
using namespace clod;
using namespace clod::test;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

const Body& shell()
{
	return body("cavity-shell");
}
const Body& ball()
{
	return body("cavity-ball");
}
const Body& grain()
{
	return body("cavity-grain");
}

// Shares of the smaller radius but for the first.
std::vector<Settings> selections(double tolerance, double radius)
{
	std::vector<Settings> list(6);
	for (Settings& settings : list) settings.tolerance = tolerance;
	list[0].metric.exact = true;
	list[1].metric.maxError = 0.005 * radius;
	list[2].metric.maxError = 0.05 * radius;
	list[3].metric.weightedDeviation = 0.035 * radius;
	list[4].metric.weightedDeviation = 0.0035 * radius;
	list[5].metric.weightedDeviation = 0.035 * radius;
	list[5].gapError = 1e-3 * radius;
	return list;
}

struct Counts
{
	int apart = 0, near = 0, overlapping = 0, deep = 0;
};

// What an answer says wrongly of a gap that is known, or nothing.
std::string wrong(const GapResult& result, const Settings& settings, const GapInterval& truth, double radius)
{
	if (const std::string reason = broken(result, truth, settings.tolerance); !reason.empty()) return reason;
	const bool isProved = std::isfinite(result.errorBound), isApart = truth.low > 0;
	if (!isProved && !result.deep) return "no bound, and not deep";
	if (!isProved && (isApart || settings.distance)) return "no bound";
	if (result.deep && isApart) return "deep, but apart";
	if (!result.deep && result.errorBound > settings.metric.maxError) return "beyond the certified limit";
	// The sign, wherever the bound is smaller than the gap.
	const double bound = isProved ? result.errorBound : 0;
	if (truth.low > bound && !(result.minDistance > 0)) return "apart, but said to overlap";
	if (truth.high < -bound && !(result.minDistance < 0)) return "overlapping, but said to be apart";
	if (truth.low > settings.tolerance + bound && (result.minDistance == kInfinity) == settings.distance)
		return "far, but told as if near";
	const double accuracy = 0.01 * std::abs(result.minDistance) + 3e-4 * radius;
	if (settings.distance && settings.metric.exact && result.errorBound > accuracy) return "exact, but known badly";
	return {};
}

// Every selection, in contact mode and at any distance, from either side.
void checkAll(const BodyPair& pair, const Transform& pose, const GapInterval& truth, const std::string& where,
			  Counts& counts)
{
	const double radius = smallerRadius(pair.a, pair.b), tolerance = 0.02 * radius;
	++(truth.low > tolerance ? counts.apart : truth.high > 0 ? counts.near : counts.overlapping);
	for (const bool isSwapped : {false, true})
		for (const bool distance : {false, true})
			for (Settings& settings : selections(tolerance, radius))
			{
				settings.distance = distance;
				const BodyPair asked = isSwapped ? BodyPair{pair.b, pair.a} : pair;
				const GapResult result = fresh(asked, isSwapped ? inverse(pose) : pose, settings);
				EXPECT_EQ(wrong(result, settings, truth, radius), "")
					<< where << (isSwapped ? ", swapped" : "") << (distance ? ", distance" : "") << ", s0 "
					<< settings.metric.weightedDeviation / radius << ", limit " << settings.metric.maxError / radius
					<< ": " << result.minDistance / radius << " +- " << result.errorBound / radius << ", truth "
					<< truth.low / radius << " to " << truth.high / radius;
				counts.deep += result.deep;
			}
}

// Turned anyhow, on the way from the middle of the cavity to its wall, where `gap` is left.
Transform ballAtTheWall(Random& random, double gap)
{
	Transform pose{randomRotation(random), {}};
	const Vec3 way = randomDirection(random);
	Settings settings = exactSettings(0);
	settings.distance = true;
	double left = kInfinity;
	for (int i = 0; i < 50 && left > 1e-4 * kBall; ++i)
	{
		left = fresh({shell(), ball()}, pose, settings).minDistance;
		pose.translation += left * way;
	}
	pose.translation += -gap * way;
	return pose;
}

// From the middle of the cavity to its wall, and a little into it.
TEST(Cavity, ABallInsideIsApartOrTouchesTheWall)
{
	Random random(41);
	const BodyPair pair{shell(), ball()};
	Counts counts;
	for (int i = 0; i < 18; ++i)
	{
		const double share = i % 3 == 0 ? uniform(random, 0.1, 1) : uniform(random, -0.03, 0.02);
		const Transform pose = i == 0 ? Transform{} : ballAtTheWall(random, share * kBall);
		const GapInterval truth = triangleGap(shell().triangles, ball().triangles, pose, 1e-3 * kBall);
		checkAll(pair, pose, truth, "ball with a gap of " + std::to_string(share), counts);
	}
	std::printf("apart %d, near %d, overlapping %d, answers deep %d\n", counts.apart, counts.near, counts.overlapping,
				counts.deep);
	EXPECT_GT(std::min({counts.apart, counts.near, counts.overlapping}), 2);
}

TEST(Cavity, ABodyInTheWallIsInsideTheSolidAndItsDepthIsKnown)
{
	Random random(42);
	const BodyPair pair{shell(), grain()};
	Counts counts;
	for (int i = 0; i < 12; ++i)
	{
		// The wall is 16 mm, its facets leave some 14.
		const double distance = 0.5 * (kOuter + kCavity) + uniform(random, -0.7, 0.7) * kGrain;
		const Transform pose{randomRotation(random), distance * randomDirection(random)};
		const GapInterval truth = triangleGap(shell().triangles, grain().triangles, pose, 1e-4 * kGrain);
		ASSERT_LT(truth.high, -kGrain) << "wholly inside";
		checkAll(pair, pose, truth, "grain at " + std::to_string(distance), counts);
	}
	EXPECT_EQ(counts.overlapping, 12);
	EXPECT_GT(counts.deep, 12 * 12);  // contact mode, both orders, six selections
}

// Walls and body of flat faces: depths and gaps by hand.
TEST(Cavity, GapsAndDepthsInAHollowBoxAreThoseByHand)
{
	const Body &box = body("cavity-box"), &cube = body("cavity-box-cube");
	const struct
	{
		double x, gap;
	} cases[] = {{0, kBoxCavity - kSmallCube},  // in the middle of the cavity
				 {0.0155, 0.0005},     // before its wall
				 {0.01596, 0.00004},   // within the tolerance
				 {0.0165, -0.0005},    // in the wall by half a millimetre
				 {0.030, -0.010},      // the wall's middle plane crosses it
				 {0.0325, -0.010},     // the same
				 {0.0253, -0.0093},    // this side of that plane
				 {0.0355, -0.0085},    // beyond it
				 {0.0442, 0.0002},     // outside
				 {0.0, kBoxCavity - kSmallCube}};
	Counts counts;
	for (const auto& c : cases)
		for (int axis = 0; axis < 3; ++axis)
		{
			Transform pose;
			pose.translation[axis] = axis == 1 ? -c.x : c.x;
			const double rounding = 1e-8;  // of the corners
			checkAll({box, cube}, pose, {c.gap - rounding, c.gap + rounding}, "cube at " + std::to_string(c.x), counts);
		}
	EXPECT_GT(std::min({counts.apart, counts.near, counts.overlapping}), 2);
}

// A bubble under each face keeps the hulls of the faces thin: deep between them no hull is near, and only a point that
// is inside tells. Depth by hand: of the corner nearest to the middle, below the outer faces.
TEST(Cavity, WhatLiesDeepInTheSolidMeetsNoHullAndIsInsideAllTheSame)
{
	constexpr double at = 0.02, below = kBoxHalf - at + kTinyCube;
	const Body &box = body("cavity-bubbles"), &cube = body("cavity-bubbles-cube"),
			   &pairOfCubes = body("cavity-bubbles-two-cubes");
	Counts counts;
	for (int corner = 0; corner < 8; ++corner)
	{
		const Vec3 place{corner & 1 ? at : -at, corner & 2 ? at : -at, corner & 4 ? at : -at};
		const Transform pose{Transform{}.rotation, place};
		const Transform oneOfTwo{pose.rotation, place + Vec3{0, 0, 0.5 * (corner & 4 ? kCubesApart : -kCubesApart)}};
		ASSERT_TRUE(fresh({box, cube}, pose, exactSettings(0)).contacts.empty()) << "no hull meets it";
		const GapInterval truth{-below - 1e-8, -below + 1e-8};
		checkAll({box, cube}, pose, truth, "cube at corner " + std::to_string(corner), counts);
		checkAll({box, pairOfCubes}, oneOfTwo, truth, "one of two at corner " + std::to_string(corner), counts);
	}
	EXPECT_EQ(counts.overlapping, 16);
	EXPECT_EQ(counts.deep, 16 * 2 * 2 * 6);
}

// Outside, inside, a little farther with what was found before, through the surface, outside again.
TEST(Cavity, ContactsAloneTellOfWhatLiesDeepToo)
{
	const Body &box = body("cavity-bubbles"), &cube = body("cavity-bubbles-cube");
	Settings settings = exactSettings(1e-5);
	settings.contactsOnly = true;
	for (const BodyPair& pair : {BodyPair{box, cube}, BodyPair{cube, box}})
	{
		GapCache cache;
		for (const double x : {0.06, 0.02, 0.0201, kBoxHalf, 0.06})
		{
			const Transform boxFromCube{Mat3{}, {x, 0.02, -0.02}};
			GapResult result;
			query(*pair.a.hierarchy, *pair.b.hierarchy, &pair.a == &box ? boxFromCube : inverse(boxFromCube), settings,
				  cache, result);
			EXPECT_EQ(result.deep, x < 0.03) << pair.a.name << " first, at " << x;
			EXPECT_EQ(result.contacts.empty(), x != kBoxHalf) << pair.a.name << " first, at " << x;
		}
	}
}

// A cube in a bubble, then near its wall, then deep in the solid: that it was near keeps it outside no farther than it may.
TEST(Cavity, WhatWasNearAWallIsFoundInsideAtOnce)
{
	const std::shared_ptr<const Hierarchy> box = body("cavity-bubbles").hierarchy,
										   cube = scaledHierarchy(*body("cavity-bubbles-cube").hierarchy, {0.4, 0.4, 0.4}).value();
	Settings settings = exactSettings(1e-3);
	settings.contactsOnly = true;
	constexpr double kMiddle = kBoxHalf - 2 * kBubble;
	for (const bool boxIsFirst : {true, false})
	{
		GapCache cache;
		for (const Vec3& place : {Vec3{kMiddle, 0, 0}, Vec3{kMiddle + 5e-4, 0, 0}, Vec3{0.02, 0.02, -0.02}})
		{
			const Transform boxFromCube{Mat3{}, place};
			GapResult result;
			query(boxIsFirst ? *box : *cube, boxIsFirst ? *cube : *box, boxIsFirst ? boxFromCube : inverse(boxFromCube), settings,
				  cache, result);
			EXPECT_EQ(result.deep, place.x == 0.02) << boxIsFirst << " at " << place.x;
			EXPECT_EQ(result.contacts.empty(), place.x != kMiddle + 5e-4) << boxIsFirst << " at " << place.x;
		}
	}
}
}  // namespace
