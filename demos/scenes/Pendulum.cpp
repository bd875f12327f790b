// SPDX-License-Identifier: Zlib
// An arm swings on a flanged pin that goes through its hole, held by contact alone. Without friction a point body would
// swing for ever; what is lost is lost in contacts.
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
constexpr double startAngle = kPi / 2;  // from hanging
constexpr int steps = 1200;
}  // namespace constant

// With the centre of mass `reach` under the hole.
std::vector<double> outcomeOf(const SceneState& state, double reach)
{
	const Transform arm = toTransform(state.bodies[1].pose);
	const Vec3 down = arm.rotation * Vec3{0, -1, 0};
	const double most = constant::armMass * kGravity * reach;
	const double left = (state.energy() + most) / (most * (1 - std::cos(constant::startAngle)));
	return {left, std::atan2(down.x, -down.y), std::hypot(arm.translation.x, arm.translation.y),
			std::fabs(arm.translation.z)};
}

void knowReach(SceneDefinition& scene, const std::vector<std::shared_ptr<const Hierarchy>>& models)
{
	const double reach = -models[1]->asset().meshFromBody[1];
	scene.outcome = [reach](const SceneState& state) { return outcomeOf(state, reach); };
}
}  // namespace

SceneDefinition pendulum()
{
	SceneDefinition scene =
		mechanism("pendulum", "an arm swings on a flanged pin through its hole, without friction", 0);
	SceneInfo& info = scene.info;
	info.models = {{"pin", ""}, {"arm", ""}};
	info.bodies = {{"pin", 0, false}, {"arm", 1, true}};
	info.tolerance = 0.01 * FLANGE_RADIUS;
	info.thinnerWall = FLANGE_THICKNESS;
	info.steps = constant::steps;
	info.overview = {{0, -0.3, 0}, 1.35, 20, 15, -1, ""};
	info.closeUp = {{0, 0, 0}, 0.22, 30, 20, -1, "close-up of the pin, through the arm"};
	info.outcome = {{"swing_energy_left", ""},
					{"swing_angle", "rad", true},
					{"pin_off_axis", "m"},  // with PIN_PLAY it touches
					{"pin_along_axis", "m"}};
	scene.bodies = {{0, Pose{}, {}}, {constant::armMass, turnedAbout({0, 0, 1}, constant::startAngle), {}}};
	scene.inPlace = [](std::size_t, const Vec3& center) { return length(center) < ARM_LENGTH; };
	scene.prepare = knowReach;
	scene.constants = {{"start_angle", constant::startAngle, "rad"},
					   {"pin_radius", PIN_RADIUS, "m"},
					   {"pin_play", PIN_PLAY, "m, radial"},
					   {"pin_axial_play", PIN_AXIAL_PLAY, "m, either side"}};
	return scene;
}
}  // namespace clod::demo
