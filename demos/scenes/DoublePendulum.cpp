// SPDX-License-Identifier: Zlib
// Two arms on flanged pins, one hung on the other: chaotic, undamped, held by contact alone.
#include <cmath>

#include "demos/models/Mechanisms.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr double armMass = 10;
constexpr double firstAngle = kPi / 2, secondAngle = kPi / 2 + 0.3;  // from hanging
constexpr int steps = 1200;
}  // namespace constant

std::vector<double> outcomeOf(const SceneState& state)
{
	const Transform upper = toTransform(state.bodies[1].pose), lower = toTransform(state.bodies[2].pose);
	const Vec3 pin = upper * Vec3{0, -ARM_LENGTH, ARM_TO_ARM};
	const auto offAxis = [](const Transform& hole, const Vec3& place)
	{
		const Vec3 apart = transposed(hole.rotation) * (place - hole.translation);
		return std::hypot(apart.x, apart.y);
	};
	return {offAxis(upper, {}), offAxis(lower, pin)};
}
}  // namespace

SceneDefinition doublePendulum()
{
	SceneDefinition scene =
		mechanism("double-pendulum", "an arm swings on a pin, another on that arm's pin, without friction", 0);
	SceneInfo& info = scene.info;
	info.models = {{"pin", ""}, {"arm-with-pin", ""}, {"arm", ""}};
	info.bodies = {{"pin", 0, false}, {"upper-arm", 1, true}, {"lower-arm", 2, true}};
	info.tolerance = 0.01 * FLANGE_RADIUS;
	info.thinnerWall = FLANGE_THICKNESS;
	info.steps = constant::steps;
	info.overview = {{0, -0.2, 0}, 2.4, 20, 15, -1, ""};
	info.closeUp = {{0, -ARM_LENGTH, 0}, 0.5, 30, 20, 1, "close-up of the second pin"};
	info.outcome = {{"first_pin_off_axis", "m"}, {"second_pin_off_axis", "m"}};
	const Pose upper = turnedAbout({0, 0, 1}, constant::firstAngle);
	const Vec3 pin = toTransform(upper) * Vec3{0, -ARM_LENGTH, ARM_TO_ARM};
	scene.bodies = {{0, Pose{}, {}},
					{constant::armMass, upper, {}},
					{constant::armMass, turnedAbout({0, 0, 1}, constant::secondAngle, pin), {}}};
	scene.inPlace = [](std::size_t, const Vec3& center) { return length(center) < 2 * ARM_LENGTH; };
	scene.outcome = outcomeOf;
	scene.constants = {{"first_angle", constant::firstAngle, "rad"},
					   {"second_angle", constant::secondAngle, "rad"},
					   {"pin_play", PIN_PLAY, "m, radial"}};
	return scene;
}
}  // namespace clod::demo
