// SPDX-License-Identifier: Zlib
// Forty digits, four of each, fall into a bowl and settle: many pairs of small, coarse bodies. The third benchmark of
// Otaduy & Lin 2003, sec. 6.
#include <cmath>
#include <cstdint>
#include <random>

#include "demos/models/Models.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr int digits = 10, copies = 4;
constexpr double digitMass = 0.002;
constexpr double digitRadius = 0.0122;  // of its bounding sphere
// The digits start in layers: one in the middle, six round it, far enough apart to be turned any way.
constexpr int inLayer = 7;
constexpr double spacing = 0.0255, lowestLayer = 0.030;
constexpr std::uint64_t seed = 1;
constexpr double wall = 0.003;        // of the bowl; a digit's strokes are 3.2 mm
constexpr double rimRadius = 0.0625;  // outside
}  // namespace constant

double uniform(std::mt19937_64& random)
{
	return double(random() >> 11) / double(std::uint64_t(1) << 53);
}

// Uniform over all orientations (Shoemake 1992).
void turnAnyWay(std::mt19937_64& random, double (&q)[4])
{
	const double u = uniform(random), v = 2 * kPi * uniform(random), w = 2 * kPi * uniform(random);
	q[0] = std::sqrt(1 - u) * std::sin(v);
	q[1] = std::sqrt(1 - u) * std::cos(v);
	q[2] = std::sqrt(u) * std::sin(w);
	q[3] = std::sqrt(u) * std::cos(w);
}

Pose digitStart(int index, std::mt19937_64& random)
{
	const int layer = index / constant::inLayer, place = index % constant::inLayer;
	// Every other layer is turned by half a place, so that digits do not fall exactly onto each other.
	const double angle = 2 * kPi / (constant::inLayer - 1) * (place + 0.5 * (layer % 2));
	const double reach = place == 0 ? 0 : constant::spacing;
	Pose pose{{reach * std::cos(angle), constant::lowestLayer + layer * constant::spacing, reach * std::sin(angle)},
			  {}};
	turnAnyWay(random, pose.quaternion);
	return pose;
}

SceneInfo describe()
{
	SceneInfo info;
	info.name = "numbers-bowl";
	info.summary = "forty digits fall into a bowl and settle";
	info.models = {{"bowl", ""}};
	info.bodies = {{"bowl", 0, true}};
	for (int copy = 1; copy <= constant::copies; ++copy)
		for (int digit = 0; digit < constant::digits; ++digit)
		{
			const std::string name = "number" + std::to_string(digit);
			if (copy == 1) info.models.push_back({name, ""});
			info.bodies.push_back({name + "-" + std::to_string(copy), std::size_t(digit) + 1, false});
		}
	info.tolerance = 0.01 * constant::digitRadius;
	info.thinnerWall = constant::wall;
	info.dt = 1.0 / 960;  // digits fall at 1.5 m/s and are 3 mm thin
	info.steps = 1440;
	info.worldScale = 100;
	info.overview = {{0, 0.065, 0}, 0.115, 20, 35, -1, ""};
	info.closeUp = {{0, 0.025, 0}, 0.045, 20, 50, -1, "close-up of the pile"};
	return info;
}
}  // namespace

SceneDefinition numbersBowl()
{
	SceneDefinition scene;
	scene.info = describe();
	scene.bodies = {{0, Pose{}, {}}};
	std::mt19937_64 random(constant::seed);
	for (int i = 0; i < constant::digits * constant::copies; ++i)
		scene.bodies.push_back({constant::digitMass, digitStart(i, random), {}});
	scene.gravity = steadyGravity;
	scene.world.warmstartingFactor = kWarmstartingOfPiles;
	scene.inPlace = [](std::size_t, const Vec3& center)
	{ return center.y > constant::wall && std::hypot(center.x, center.z) < constant::rimRadius; };
	scene.constants = {{"digits", constant::digits * constant::copies, ""},
					   {"digit_spacing", constant::spacing, "m"},
					   {"lowest_layer", constant::lowestLayer, "m"},
					   {"seed", double(constant::seed), ""}};
	return scene;
}
}  // namespace clod::demo
