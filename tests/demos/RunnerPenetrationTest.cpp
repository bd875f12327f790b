// SPDX-License-Identifier: GPL-3.0-or-later
// The independent measure of interpenetration against closed forms, and shown to see a planted overlap.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>

#include "demos/runner/PenetrationCheck.h"

namespace
{
using namespace clod;
using namespace clod::demo;

Surface cube(double half)
{
	Surface s;
	for (int i = 0; i < 8; ++i)
		s.vertices.push_back({i & 1 ? half : -half, i & 2 ? half : -half, i & 4 ? half : -half});
	s.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
				   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
	return s;
}

double cubeDistance(const Vec3& p, double half)
{
	const Vec3 q{std::abs(p.x) - half, std::abs(p.y) - half, std::abs(p.z) - half};
	const double inside = std::max({q.x, q.y, q.z});
	return inside <= 0 ? inside : length({std::max(0.0, q.x), std::max(0.0, q.y), std::max(0.0, q.z)});
}

TEST(RunnerPenetration, SignedDistanceOfACubeIsTheClosedForm)
{
	const SignedDistance distance(cube(1));
	std::mt19937_64 random(3);
	std::uniform_real_distribution<double> uniform(-2, 2);
	int inside = 0;
	for (int i = 0; i < 5000; ++i)
	{
		const Vec3 p{uniform(random), uniform(random), uniform(random)};
		inside += cubeDistance(p, 1) < 0;
		ASSERT_NEAR(distance(p), cubeDistance(p, 1), 1e-12) << p.x << " " << p.y << " " << p.z;
		const double exact = std::abs(cubeDistance(p, 1)), clear = distance.clearance(p);
		ASSERT_TRUE(clear <= exact + 1e-12 && clear >= exact / 2 - 1e-12) << clear << " of " << exact;
	}
	EXPECT_GT(inside, 500);
}

// A pit in a cube's top ends in the middle: what lies under its tip is nearest to a vertex, and inside.
TEST(RunnerPenetration, UnderTheTipOfAPitIsInside)
{
	Surface pitted = cube(1);
	pitted.vertices.push_back({});
	pitted.triangles.resize(10);
	for (const auto& rim : {std::array<std::uint32_t, 2>{1, 3}, {3, 7}, {7, 5}, {5, 1}}) pitted.triangles.push_back({rim[0], rim[1], 8});
	const SignedDistance distance(pitted);
	EXPECT_NEAR(distance({-0.1, 0, 0}), -0.1, 1e-12);
	EXPECT_NEAR(distance({-0.1, 0.02, 0.01}), -length({0.1, 0.02, 0.01}), 1e-12);
	EXPECT_GT(distance({0.1, 0, 0}), 0.05);
}

TEST(RunnerPenetration, FollowsAMovingCubeThroughAWall)
{
	// A small cube passes through a large one's side; its leading corners' depth is known in every step.
	PenetrationMeter meter(std::make_shared<SignedDistance>(cube(10)), std::make_shared<SignedDistance>(cube(1)));
	for (double x = 20; x > 8; x -= 0.01)
	{
		const double depth = meter.depth({{}, {x, 0, 0}});
		ASSERT_NEAR(depth, std::max(0.0, 10 - (x - 1)), 1e-9) << x;
	}
	// Through the wall at one go, so far outside before that balls of clearance only just fail to meet.
	for (const double x : {11.6, 12.5, 13.5, 15.0})
	{
		EXPECT_EQ(meter.depth({{}, {50, 0, 0}}), 0);
		EXPECT_EQ(meter.depth({{}, {x, 0, 0}}), 0);
		EXPECT_NEAR(meter.depth({{}, {9.5, 0, 0}}), 1.5, 1e-9) << x;
	}
	// A teleport out and back in: skipped vertices must be looked at again.
	EXPECT_EQ(meter.depth({{}, {50, 0, 0}}), 0);
	EXPECT_NEAR(meter.depth({rotationFromQuaternion(0, 0, 1, 0), {0, 10.5, 0}}), 0.5, 1e-9);
}

// Each in turn is the body whose vertices are inside: the other has none there.
TEST(RunnerPenetration, SeesEitherBodysVerticesInTheOther)
{
	const auto large = std::make_shared<SignedDistance>(cube(10)), small = std::make_shared<SignedDistance>(cube(1));
	for (double x = 20; x > 8; x -= 0.01)
	{
		const Vec3 away{x, 3, -2};
		const double depth = std::max(0.0, 10 - (x - 1));
		EXPECT_NEAR(PenetrationMeter(large, small).depth({{}, away}), depth, 1e-9) << x;
		EXPECT_NEAR(PenetrationMeter(small, large).depth({{}, -away}), depth, 1e-9) << x;
	}
	PenetrationMeter meter(small, large);
	for (double x = 20; x > 8; x -= 0.01)
		ASSERT_NEAR(meter.depth({{}, {-x, 0, 0}}), std::max(0.0, 10 - (x - 1)), 1e-9) << x;
}

// Two bodies at scripted poses: the deepest row is named, and the limit is a hundredth of the wall and the bound.
TEST(RunnerPenetration, TheCheckOfARunNamesDepthPlaceAndLimit)
{
	SceneRunOptions run;
	run.info.bodies = {{"wall", 0, false}, {"dice", 1, false}};
	run.info.thinnerWall = 2;
	std::vector<SceneRow> rows(4);
	const double depths[] = {0, 0.01, 0.3, 0.2};
	const double bounds[] = {0.1, 0.25, 0.05, std::numeric_limits<double>::infinity()};
	for (const bool isDiceFirst : {false, true})
	{
		if (isDiceFirst) std::swap(run.info.bodies[0], run.info.bodies[1]);
		for (std::size_t i = 0; i < rows.size(); ++i)
		{
			SceneState& state = rows[i].state;
			state.step = std::int64_t(i) + 1;
			state.bodies.assign(2, {});
			state.bodies[isDiceFirst ? 0 : 1].pose.position = {11 - depths[i], 0, 0};
			state.pairs = {{0, 1}};
			rows[i].pairs.assign(1, {});
			rows[i].pairs[0].errorBound = bounds[i];
		}
		for (const bool isExact : {false, true})
		{
			run.scene.metric.exact = isExact;
			const PenetrationCheck check = checkPenetration(run, {cube(10), cube(1)}, rows, [](double) {});
			EXPECT_NEAR(check.deepest, 0.3, 1e-9);
			EXPECT_EQ(check.where.step, 3);
			EXPECT_EQ(check.bound, 0.25);
			EXPECT_DOUBLE_EQ(check.limit, isExact ? 0.02 : 0.27);
			EXPECT_FALSE(check.holds());
			const auto json = toJson(check, run.info);
			EXPECT_EQ(json["deepest"], check.deepest);
			EXPECT_EQ(json["limit"], check.limit);
			EXPECT_EQ(json["step"], 3);
			EXPECT_EQ(json["within_limit"], false);
			EXPECT_DOUBLE_EQ(json["share_of_thinner_wall"], check.deepest / 2);
		}
	}
	// Just within, and just beyond.
	rows.resize(2);
	run.scene.metric.exact = true;
	EXPECT_TRUE(checkPenetration(run, {cube(10), cube(1)}, rows, [](double) {}).holds());
	run.info.thinnerWall = 0.99;
	EXPECT_FALSE(checkPenetration(run, {cube(10), cube(1)}, rows, [](double) {}).holds());
}
}  // namespace
