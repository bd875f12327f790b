// SPDX-License-Identifier: Zlib
// A spoon drops into a cup, is stirred by a gravity vector that tilts and turns, and comes to rest.
#include <algorithm>
#include <cmath>

#include "demos/models/Models.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
// The scene's constants: SI units, lengths and speeds before worldScale is applied.
namespace constant
{
constexpr double spoonMass = 0.040;
// Time course, in seconds: drop and settle, stir, rest.
constexpr double stirBegins = 0.35, stirEnds = 4.5, ramp = 0.25;
constexpr double stirTilt = 0.5;       // radians between gravity and down
constexpr double stirFrequency = 0.8;  // turns a second
// How the spoon starts: bowl down, its tip `dropHeight` over the cup's bottom, leaning by `lean` radians.
constexpr double cupBottom = 0.003, dropHeight = 0.012, tipOffset = -0.012, lean = 0.38;
}  // namespace constant

// 0 before the stirring, 1 within it, smooth between.
double stirring(double time)
{
	const double in = (time - constant::stirBegins) / constant::ramp,
				 out = (constant::stirEnds - time) / constant::ramp;
	return smoothStep(std::min(in, out));
}

Vec3 gravityAt(double time)
{
	const double tilt = constant::stirTilt * stirring(time);
	const double turn = 2 * kPi * constant::stirFrequency * (time - constant::stirBegins);
	return kGravity * Vec3{std::sin(tilt) * std::cos(turn), -std::cos(tilt), std::sin(tilt) * std::sin(turn)};
}

Pose spoonStart()
{
	const double half = (kPi / 2 - constant::lean) / 2;  // about z: the handle, along x in the mesh, turns up
	return {{constant::tipOffset, constant::cupBottom + constant::dropHeight, 0},
			{0, 0, std::sin(half), std::cos(half)}};
}

SceneInfo describe()
{
	SceneInfo info;
	info.name = "spoon-cup";
	info.summary = "a spoon drops into a cup, is stirred by tilting gravity, comes to rest";
	info.models = {{"cup", ""}, {"spoon", ""}};
	info.bodies = {{"cup", 0, true}, {"spoon", 1, false}};
	info.tolerance = 0.01 * CUP_OPENING_RADIUS;
	info.thinnerWall = SPOON_BOWL_THICKNESS;
	info.dt = 1.0 / 240;
	info.steps = 1200;
	info.worldScale = 100;
	info.overview = {{0.005, 0.071, 0}, 0.098, 20, 28, -1, ""};
	info.closeUp = {{0.020, -0.004, 0}, 0.03, 25, -30, 1, "close-up from below, through the cup"};
	return info;
}
}  // namespace

SceneDefinition spoonCup()
{
	SceneDefinition scene;
	scene.info = describe();
	scene.bodies = {{0, Pose{}, {}}, {constant::spoonMass, spoonStart(), {}}};
	scene.gravity = gravityAt;
	scene.inPlace = [](std::size_t, const Vec3& center)
	{ return center.y > 0 && center.y < CUP_HEIGHT && std::hypot(center.x, center.z) < CUP_OPENING_RADIUS; };
	using namespace constant;
	scene.constants = {{"cup_opening_radius", CUP_OPENING_RADIUS, "m"},
					   {"stir_begins", stirBegins, "s"},
					   {"stir_ends", stirEnds, "s"},
					   {"stir_ramp", ramp, "s"},
					   {"stir_tilt", stirTilt, "rad"},
					   {"stir_frequency", stirFrequency, "Hz"},
					   {"spoon_drop_height", dropHeight, "m"},
					   {"spoon_tip_offset", tipOffset, "m"},
					   {"spoon_lean", lean, "rad"}};
	return scene;
}
}  // namespace clod::demo
