// SPDX-License-Identifier: Zlib
// Bodies that swing, rock or wobble for long: a plate that rolls on its rim as a coin does, a ring on a peg, and a
// torus in a dish. Their amplitudes must not grow.
#include <cmath>

#include "demos/models/Mechanisms.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr double plateMass = 0.1, plateTilt = 0.4, plateFriction = 0.9;  // kg, rad
constexpr double floorHalf = 0.010, dropHeight = 0.0001;
constexpr double ringMass = 0.02, ringAngle = 0.6, ringFriction = 0.7;
constexpr double torusMass = 0.02, torusAngle = 0.35;
constexpr int plateSteps = 960, ringSteps = 1200, torusSteps = 1200;
}  // namespace constant

// Angle in the plane z = 0 between down and where a body's middle is seen from a point.
double swingAngle(const SceneState& state)
{
	const Vec3& place = state.bodies[1].pose.position;
	return std::atan2(place.x, -place.y);
}
}  // namespace

// Set going so that its middle stays where it is: the point of contact goes round at rate^2 = 4 g / (r sin tilt).
SceneDefinition spinningPlate()
{
	SceneDefinition scene =
		mechanism("spinning-plate", "a plate is set rolling on its rim as a coin; facets brake it, less in smaller steps",
				  constant::plateFriction);
	SceneInfo& info = scene.info;
	info.models = {{"floor", ""}, {"plate", ""}};
	info.bodies = {{"floor", 0, true}, {"plate", 1, false}};
	info.tolerance = 0.01 * PLATE_RADIUS;
	info.thinnerWall = PLATE_THICKNESS;
	info.steps = constant::plateSteps;
	info.overview = {{0, 0.01, 0}, 0.055, 20, 25, -1, ""};
	info.closeUp = {{0, 0, 0}, 0.036, 20, 10, 1, "close-up"};
	info.outcome = {{"tilt", "rad"}};
	const double tilt = constant::plateTilt, s = std::sin(tilt), c = std::cos(tilt);
	// The axis leans towards +x, so that the rim's lowest point is at +x too.
	const Pose plate = turnedTwice(turnedAbout({1, 0, 0}, -kPi / 2), turnedAbout({0, 0, 1}, -tilt));
	const double height = PLATE_RADIUS * s + PLATE_THICKNESS / 2 * c + constant::dropHeight;
	const double rate = std::sqrt(4 * kGravity / (PLATE_RADIUS * s));
	scene.bodies = {
		{0, {{0, -constant::floorHalf, 0}}, {}},
		{constant::plateMass,
		 {{0, height, 0}, {plate.quaternion[0], plate.quaternion[1], plate.quaternion[2], plate.quaternion[3]}},
		 {},
		 {},
		 rate * s * Vec3{-c, s, 0}}};
	scene.inPlace = [](std::size_t, const Vec3& center)
	{ return center.y > 0 && std::hypot(center.x, center.z) < PLATE_RADIUS; };
	scene.outcome = [](const SceneState& state) -> std::vector<double>
	{ return {std::acos(std::min(1.0, std::fabs(toTransform(state.bodies[1].pose).rotation.column(2).y)))}; };
	scene.constants = {{"start_tilt", tilt, "rad"}, {"start_rate", rate, "rad/s"}};
	return scene;
}

SceneDefinition ringOnPeg()
{
	SceneDefinition scene = mechanism("ring-on-peg", "a ring hung on a peg swings", constant::ringFriction);
	SceneInfo& info = scene.info;
	info.models = {{"peg", ""}, {"smooth-torus", ""}};
	info.bodies = {{"peg", 0, false}, {"ring", 1, false}};
	info.tolerance = 0.01 * (TORUS_RING_RADIUS + TORUS_TUBE_RADIUS);
	info.thinnerWall = PEG_FLANGE_THICKNESS;
	info.steps = constant::ringSteps;
	info.overview = {{0, -0.008, 0}, 0.036, 25, 15, -1, ""};
	info.closeUp = {{0, 0, 0}, 0.015, 30, 20, -1, "close-up of the peg"};
	info.outcome = {{"swing_angle", "rad", true}};
	const double reach = TORUS_RING_RADIUS - TORUS_TUBE_RADIUS - PEG_RADIUS - constant::dropHeight;
	Pose ring = turnedAbout({1, 0, 0}, kPi / 2);
	ring.position = {reach * std::sin(constant::ringAngle), -reach * std::cos(constant::ringAngle), 0};
	scene.bodies = {{0, Pose{}, {}}, {constant::ringMass, ring, {}}};
	scene.inPlace = [](std::size_t, const Vec3& center) { return length(center) < TORUS_RING_RADIUS; };
	scene.outcome = [](const SceneState& state) -> std::vector<double> { return {swingAngle(state)}; };
	scene.constants = {{"start_angle", constant::ringAngle, "rad"}};
	return scene;
}

// Without friction the torus swings about the dish's middle as a rigid pendulum.
SceneDefinition rockingTorus()
{
	SceneDefinition scene = mechanism("rocking-torus", "a torus rocks in a round dish, without friction", 0);
	SceneInfo& info = scene.info;
	info.models = {{"dish", ""}, {"smooth-torus", ""}};
	info.bodies = {{"dish", 0, true}, {"torus", 1, false}};
	info.tolerance = 0.01 * (TORUS_RING_RADIUS + TORUS_TUBE_RADIUS);
	info.thinnerWall = DISH_WALL;
	info.steps = constant::torusSteps;
	info.overview = {{0, -0.045, 0}, 0.058, 20, 30, -1, ""};
	info.closeUp = {{0, 0, 0}, 0.026, 20, 20, 1, "close-up, through the dish"};
	info.outcome = {{"swing_angle", "rad", true}};
	const double touching = DISH_RADIUS - TORUS_TUBE_RADIUS - constant::dropHeight;
	const double reach = std::sqrt(touching * touching - TORUS_RING_RADIUS * TORUS_RING_RADIUS);
	Pose torus = turnedAbout({0, 0, 1}, constant::torusAngle);
	torus.position = toTransform(torus) * Vec3{0, -reach, 0};
	scene.bodies = {{0, Pose{}, {}}, {constant::torusMass, torus, {}}};
	scene.inPlace = [](std::size_t, const Vec3& center) { return length(center) < DISH_RADIUS; };
	scene.outcome = [](const SceneState& state) -> std::vector<double> { return {swingAngle(state)}; };
	scene.constants = {{"start_angle", constant::torusAngle, "rad"}, {"dish_radius", DISH_RADIUS, "m"}};
	return scene;
}
}  // namespace clod::demo
