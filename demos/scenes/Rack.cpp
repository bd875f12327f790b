// SPDX-License-Identifier: Zlib
// A rack between two pinions in ideal bearings, without friction: thrown up, it comes to a stop and falls, and its
// energy is that of a rail on two rolling wheels all the way.
#include <cmath>

#include "demos/models/Mechanisms.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr double rackMass = 0.1, pinionMass = 1, startSpeed = 0.32;  // upward
constexpr int steps = 200;
}  // namespace constant

// How far the teeth of either pinion are from where those of the rack are; at most half the backlash if they mesh.
std::vector<double> outcomeOf(const SceneState& state)
{
	const double height = state.bodies[0].pose.position.y, round = 2 * kPi * PINION_PITCH_RADIUS;
	const auto rolled = [&](std::size_t pinion)
	{
		const double (&q)[4] = state.bodies[pinion].pose.quaternion;
		return 2 * std::atan2(q[2], q[3]) * PINION_PITCH_RADIUS;
	};
	return {std::remainder(height - rolled(1), round), std::remainder(height + rolled(2), round), height};
}
}  // namespace

SceneDefinition rack()
{
	SceneDefinition scene = mechanism("rack", "a rack rises and falls between two pinions, without friction", 0);
	SceneInfo& info = scene.info;
	info.models = {{"rack", ""}, {"pinion", ""}};
	info.bodies = {{"rack", 0, false}, {"left-pinion", 1, false}, {"right-pinion", 1, false}};
	info.tolerance = 0.01 * PINION_PITCH_RADIUS;
	info.thinnerWall = TOOTH_MODULE;
	info.steps = constant::steps;
	info.overview = {{0, 0.018, 0}, 0.155, 15, 15, -1, ""};
	info.closeUp = {{0.010, 0, 0}, 0.019, 5, 10, -1, "close-up of the right pinion's teeth"};
	info.outcome = {{"left_slip", "m"}, {"right_slip", "m"}, {"rack_height", "m"}};
	const double middle = RACK_PITCH_LINE + PINION_PITCH_RADIUS, turning = constant::startSpeed / PINION_PITCH_RADIUS;
	scene.bodies = {{constant::rackMass, Pose{}, {}, {0, constant::startSpeed, 0}, {}, {0, 1, 0}, {0, 0, 0}},
					{constant::pinionMass, {{-middle, 0, 0}}, {}, {}, {0, 0, turning}, {0, 0, 0}, {0, 0, 1}},
					{constant::pinionMass, {{middle, 0, 0}}, {}, {}, {0, 0, -turning}, {0, 0, 0}, {0, 0, 1}}};
	scene.inPlace = [](std::size_t, const Vec3& center)
	{ return std::fabs(center.y) < kPi * TOOTH_MODULE * RACK_TEETH / 2; };
	scene.outcome = outcomeOf;
	scene.constants = {{"start_speed", constant::startSpeed, "m/s"},
					   {"backlash", BACKLASH, "m"},
					   {"pinion_pitch_radius", PINION_PITCH_RADIUS, "m"}};
	return scene;
}
}  // namespace clod::demo
