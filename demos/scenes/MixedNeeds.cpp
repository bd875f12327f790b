// SPDX-License-Identifier: Zlib
// Two cups with a spoon each: one near the camera and swung fast, the other far away and swung slowly. Thresholds that
// follow speed or view should spend detail on one of them only.
#include <cmath>

#include "demos/models/Models.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr double spoonMass = 0.040;
constexpr double distance = 0.6;                            // between the cups
constexpr double swingBegins = 0.4, ramp = 0.5;             // seconds
constexpr double swingTilt = 0.35;                          // radians
constexpr double fastFrequency = 1.0, slowFrequency = 0.1;  // Hz
constexpr double cupBottom = 0.003, dropHeight = 0.012, tipOffset = -0.012, lean = 0.38;
}  // namespace constant

// A cup whose axis goes round a cone, without turning about itself.
Pose swung(const Vec3& place, double frequency, double time)
{
	const double tilt = constant::swingTilt * smoothStep((time - constant::swingBegins) / constant::ramp);
	const double turn = 2 * kPi * frequency * (time - constant::swingBegins);
	return {place, {std::sin(tilt / 2) * std::sin(turn), 0, -std::sin(tilt / 2) * std::cos(turn), std::cos(tilt / 2)}};
}

Pose spoonStart(const Vec3& place)
{
	const double half = (kPi / 2 - constant::lean) / 2;  // about z: the handle, along x in the mesh, turns up
	return {place + Vec3{constant::tipOffset, constant::cupBottom + constant::dropHeight, 0},
			{0, 0, std::sin(half), std::cos(half)}};
}

SceneInfo describe()
{
	SceneInfo info;
	info.name = "mixed-needs";
	info.summary = "one spoon is stirred fast and near, another slowly and far away";
	info.models = {{"cup", ""}, {"spoon", ""}};
	info.bodies = {{"near-cup", 0, true}, {"near-spoon", 1, false}, {"far-cup", 0, true}, {"far-spoon", 1, false}};
	info.tolerance = 0.01 * CUP_OPENING_RADIUS;
	info.thinnerWall = SPOON_BOWL_THICKNESS;
	info.dt = 1.0 / 240;
	info.steps = 480;
	info.worldScale = 100;
	info.overview = {{0.03, 0.112, 0.0}, 0.172, -8, 20, -1, ""};
	info.closeUp = {{0.020, -0.004, 0}, 0.03, 25, -30, 1, "close-up of the near spoon from below, through the cup"};
	return info;
}
}  // namespace

SceneDefinition mixedNeeds()
{
	const Vec3 nearPlace{0, 0, 0}, farPlace{0, 0, -constant::distance};
	SceneDefinition scene;
	scene.info = describe();
	scene.bodies = {{0, Pose{}, [=](double time) { return swung(nearPlace, constant::fastFrequency, time); }},
					{constant::spoonMass, spoonStart(nearPlace), {}},
					{0, Pose{}, [=](double time) { return swung(farPlace, constant::slowFrequency, time); }},
					{constant::spoonMass, spoonStart(farPlace), {}}};
	scene.gravity = steadyGravity;
	scene.inPlace = [=](std::size_t body, const Vec3& center)
	{
		const Vec3 fromCup = center - (body == 1 ? nearPlace : farPlace);
		return length(fromCup - Vec3{0, CUP_HEIGHT / 2, 0}) < CUP_HEIGHT;
	};
	using namespace constant;
	scene.constants = {{"distance", distance, "m"},
					   {"swing_begins", swingBegins, "s"},
					   {"swing_ramp", ramp, "s"},
					   {"swing_tilt", swingTilt, "rad"},
					   {"fast_frequency", fastFrequency, "Hz"},
					   {"slow_frequency", slowFrequency, "Hz"}};
	return scene;
}
}  // namespace clod::demo
