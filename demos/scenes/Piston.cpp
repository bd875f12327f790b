// SPDX-License-Identifier: Zlib
// A crank in an ideal bearing drives a piston in its bore through a rod with a hole over either pin. Gravity brakes and
// drives; friction brings all to rest.
#include <cmath>

#include "demos/models/Mechanisms.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr double crankMass = 50, rodMass = 5, pistonMass = 20, friction = 0.3;
constexpr double startTurning = 4;   // rad/s
constexpr double boreLow = 1.20;    // above the crank's axis
constexpr int steps = 1200;
}  // namespace constant

// How far the holes' axes are from the pins', and the pistons' from the middle of the bore.
std::vector<double> outcomeOf(const SceneState& state)
{
	const Transform crank = toTransform(state.bodies[0].pose), rod = toTransform(state.bodies[1].pose),
					piston = toTransform(state.bodies[2].pose);
	const auto offAxis = [&](const Vec3& hole, const Vec3& pin)
	{
		const Vec3 apart = transposed(rod.rotation) * (pin - rod * hole);
		return std::hypot(apart.x, apart.y);
	};
	return {offAxis({}, crank * Vec3{0, CRANK_THROW, CRANK_TO_ROD}),
			offAxis({0, ROD_LENGTH, 0}, piston * Vec3{0, 0, PISTON_TO_ROD}),
			std::hypot(piston.translation.x, piston.translation.z), piston.translation.y};
}
}  // namespace

SceneDefinition piston()
{
	SceneDefinition scene =
		mechanism("piston", "a crank set turning drives a piston through a rod, until friction stops it", constant::friction);
	SceneInfo& info = scene.info;
	info.models = {{"crank", ""}, {"rod", ""}, {"piston", ""}, {"bore", ""}};
	info.bodies = {{"crank", 0, false}, {"rod", 1, false}, {"piston", 2, false}, {"bore", 3, true}};
	info.tolerance = 0.01 * FLANGE_RADIUS;
	info.thinnerWall = FLANGE_THICKNESS;
	info.steps = constant::steps;
	info.overview = {{0, 0.95, 0}, 1.75, 25, 12, -1, ""};
	info.closeUp = {{0, CRANK_THROW, 0}, 0.45, 30, 15, 0, "close-up of the crank's pin"};
	info.outcome = {
		{"crank_pin_off_axis", "m"}, {"piston_pin_off_axis", "m"}, {"piston_aside", "m"}, {"piston_height", "m"}};
	// The crank's pin is level with its axis, to the left.
	const Pose crank = turnedAbout({0, 0, 1}, kPi / 2, {0, 0, PISTON_TO_ROD - CRANK_TO_ROD});
	const double rise = std::sqrt(ROD_LENGTH * ROD_LENGTH - CRANK_THROW * CRANK_THROW);
	const double lean = -std::asin(CRANK_THROW / ROD_LENGTH);
	// Turning about z; the rod's foot goes down, its head leans over.
	const double down = constant::startTurning * CRANK_THROW;
	scene.bodies = {
		{constant::crankMass, crank, {}, {}, {0, 0, constant::startTurning}, {0, 0, 0}, {0, 0, 1}},
		{constant::rodMass, turnedAbout({0, 0, 1}, lean, {-CRANK_THROW, 0, PISTON_TO_ROD}), {}, {0, -down, 0}},
		{constant::pistonMass, {{0, rise, 0}}, {}, {0, -down, 0}},
		{0, turnedAbout({1, 0, 0}, -kPi / 2, {0, constant::boreLow, 0}), {}}};
	scene.inPlace = [](std::size_t, const Vec3& center) { return center.y > -CRANK_THROW && center.y < 2; };
	scene.outcome = outcomeOf;
	scene.constants = {{"start_turning", constant::startTurning, "rad/s"},
					   {"pin_play", PIN_PLAY, "m, radial"},
					   {"bore_play", BORE_PLAY, "m, either side"}};
	return scene;
}
}  // namespace clod::demo
