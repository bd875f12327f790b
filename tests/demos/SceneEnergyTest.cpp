// SPDX-License-Identifier: GPL-3.0-or-later
// The energy that scenes report is that of closed forms, and joints leave free what their kind says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "tests/demos/MechanismScenes.h"

namespace
{
using namespace clod;
using namespace clod::demo;

// One block of 20 x 20 x 30 mm, alone; its centre of mass is 15 mm over the mesh's origin along z.
SceneDefinition loneBlock()
{
	SceneDefinition scene = mechanism("block", "", 0);
	scene.info.models = {{"block", ""}};
	scene.info.bodies = {{"block", 0, false}};
	scene.info.tolerance = 1e-4;
	scene.bodies = {{0.25, Pose{}, {}}};
	scene.inPlace = [](std::size_t, const Vec3&) { return true; };
	return scene;
}
constexpr double kMass = 0.25, kSide = 0.020, kHeight = 0.030;
// About x and y, and about the long axis z.
constexpr double kAcross = kMass * (kSide * kSide + kHeight * kHeight) / 12, kAlong = kMass * kSide * kSide / 6;

TEST(MechanismEnergy, IsThatOfAFreeFall)
{
	SceneDefinition definition = loneBlock();
	definition.bodies[0].velocity = {0.4, 1.5, -0.3};
	definition.bodies[0].turning = {0, 0, 25};
	const SceneSettings settings = settingsOf(definition.info);
	const auto scene = makeScene(definition, settings);
	const double start = scene->state().energy();
	const double expected = kMass * (0.4 * 0.4 + 1.5 * 1.5 + 0.3 * 0.3) / 2 + kAlong * 25 * 25 / 2;
	EXPECT_NEAR(start, expected, 1e-6 * expected);
	for (int step = 0; step < 240; ++step) scene->step();
	// The velocity is changed before the place: a step of dt loses m g^2 dt^2 / 2 of the sum. Every step rounds a
	// height of at most 5 m, that is 512 of Bullet's units, to a float.
	const double rounding = 240 * 0.5 * (512 * std::numeric_limits<float>::epsilon()) / definition.info.worldScale;
	const double lost = 240 * kMass * kGravity * kGravity * definition.info.dt * definition.info.dt / 2;
	EXPECT_NEAR(scene->state().energy(), expected - lost, kMass * kGravity * rounding);
}

// Placed along a swing about an edge of the block, at the speeds of the closed form, the sum stays.
TEST(MechanismEnergy, IsTheSameAllAlongAFreeSwing)
{
	const SceneDefinition definition = loneBlock();
	const SceneSettings settings = settingsOf(definition.info);
	const auto scene = makeScene(definition, settings);
	const double reach = kHeight / 2, first = 2.5, whole = kAcross + kMass * reach * reach;
	const double expected = -kMass * kGravity * reach * std::cos(first);
	double kinetic = 0;
	for (const double angle : {2.5, 1.7, 0.9, 0.0, -0.6, -2.5})
	{
		const double rate = std::sqrt(2 * kMass * kGravity * reach * (std::cos(angle) - std::cos(first)) / whole);
		// The block hangs with its long axis down, turned about z.
		const Pose pose = turnedTwice(turnedAbout({1, 0, 0}, kPi / 2), turnedAbout({0, 0, 1}, angle));
		const Vec3 center = toTransform(pose) * Vec3{0, 0, reach};
		SceneState state = scene->state();
		state.bodies[0] = {pose, cross({0, 0, rate}, center), {0, 0, rate}};
		scene->place(state);
		const SceneState placed = scene->state();
		EXPECT_NEAR(placed.energy(), expected, 2e-6 * std::fabs(kMass * kGravity * reach)) << angle;
		kinetic = std::max(kinetic, placed.kinetic);
	}
	EXPECT_GT(kinetic, 0.5 * kMass * kGravity * reach);
}

// Two blocks in free flight, the second thrown and turning: joined to the world or to the first, beside both.
TEST(Joints, LeaveFreeOnlyWhatTheirKindSays)
{
	const Vec3 point{0.02, 0, 0}, axis{0, 0, 1};
	for (const bool isToBody : {false, true})
		for (const auto kind :
			 {BodyJoint::Kind::fixed, BodyJoint::Kind::ball, BodyJoint::Kind::hinge, BodyJoint::Kind::slider})
		{
			SceneDefinition definition = loneBlock();
			definition.gravity = [](double) { return Vec3{}; };
			definition.info.bodies.push_back({"other", 0, false});
			definition.bodies.push_back({0.25, {{0.05, 0, 0}}, {}, {0.1, 0.2, 0.3}, {1, 2, 3}});
			definition.bodies[1].joints = {{kind, point, axis, {}}};
			if (isToBody) definition.bodies[1].joints[0].partner = 0;
			const auto scene = makeScene(definition, settingsOf(definition.info));
			const std::vector<BodyState> before = scene->state().bodies;
			for (int step = 0; step < 240; ++step) scene->step();
			const std::vector<BodyState> after = scene->state().bodies;
			const auto moved = [&](std::size_t body)
			{ return toTransform(after[body].pose) * inverse(toTransform(before[body].pose)); };
			const Transform frame = isToBody ? moved(0) : Transform{}, motion = inverse(frame) * moved(1);
			const Vec3 shift = motion * point - point, turnedAxis = motion.rotation * axis;
			const bool turns = length(motion.rotation * Vec3{1, 0, 0} - Vec3{1, 0, 0}) > 0.05;
			const bool leans = length(turnedAxis - axis) > 0.05, slides = length(shift) > 0.001;
			const std::string what = std::to_string(int(kind)) + (isToBody ? " to a body" : " to the world");
			EXPECT_EQ(turns, kind == BodyJoint::Kind::ball || kind == BodyJoint::Kind::hinge) << what;
			EXPECT_EQ(leans, kind == BodyJoint::Kind::ball) << what;
			EXPECT_EQ(slides, kind == BodyJoint::Kind::slider) << what << " " << length(shift);
		}
}
}  // namespace
