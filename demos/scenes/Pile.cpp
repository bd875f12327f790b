// SPDX-License-Identifier: Zlib
// A hundred digits on a floor: lying flat in ten stacks of ten (pile-stacks), and poured onto a heap (pile-heap).
#include <algorithm>
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
constexpr int digits = 10, copies = 10, stacksInRow = 5, inLayer = 7;
constexpr double digitMass = 0.002, digitRadius = 0.0122, digitThickness = 0.005, stroke = 0.0032, friction = 0.5;
constexpr double stackGap = 0.0001, stackAcross = 0.020, stackAlong = 0.028;
constexpr double floorHalf = 0.010;  // half its thickness
constexpr double layer = 0.0255, spacing = 0.0255, lowestLayer = 0.020;
constexpr double reach = 0.100;  // a digit farther from the middle has left the floor
constexpr std::uint64_t seed = 1;
constexpr int steps = 1440, iterations = 50;  // of the solver: stacks of ten
}  // namespace constant

SceneDefinition digitsOnFloor(const std::string& name, const std::string& summary)
{
	SceneDefinition scene = mechanism(name, summary, constant::friction);
	SceneInfo& info = scene.info;
	info.models = {{"floor", ""}};
	info.bodies = {{"floor", 0, true}};
	scene.bodies = {{0, {{0, -constant::floorHalf, 0}}, {}}};
	for (int digit = 0; digit < constant::digits; ++digit)
		info.models.push_back({"number" + std::to_string(digit), ""});
	info.tolerance = 0.01 * constant::digitRadius;
	info.thinnerWall = constant::stroke;
	info.steps = constant::steps;
	scene.world.solverIterations = constant::iterations;
	info.overview = {{0, 0.03, 0}, 0.11, 20, 30, -1, ""};
	info.closeUp = {{0, 0.02, 0}, 0.045, 20, 30, -1, "close-up"};
	scene.inPlace = [](std::size_t, const Vec3& center)
	{ return center.y > 0 && std::max(std::fabs(center.x), std::fabs(center.z)) < constant::reach; };
	return scene;
}

void addDigit(SceneDefinition& scene, int digit, int copy, const Pose& pose)
{
	scene.info.bodies.push_back(
		{"number" + std::to_string(digit) + "-" + std::to_string(copy + 1), std::size_t(digit) + 1, false});
	scene.bodies.push_back({constant::digitMass, pose, {}});
}

double uniform(std::mt19937_64& random)
{
	return double(random() >> 11) / double(std::uint64_t(1) << 53);
}
}  // namespace

SceneDefinition pileStacks()
{
	SceneDefinition scene = digitsOnFloor("pile-stacks", "a hundred digits lie flat in ten stacks");
	for (int digit = 0; digit < constant::digits; ++digit)
		for (int copy = 0; copy < constant::copies; ++copy)
		{
			const double height = (copy + 0.5) * constant::digitThickness + (copy + 1) * constant::stackGap;
			const Vec3 place{(digit % constant::stacksInRow - (constant::stacksInRow - 1) / 2) * constant::stackAcross,
							 height, (digit / constant::stacksInRow - 0.5) * constant::stackAlong};
			addDigit(scene, digit, copy, turnedAbout({1, 0, 0}, -kPi / 2, place));
		}
	scene.constants = {{"stack_gap", constant::stackGap, "m"}};
	return scene;
}

SceneDefinition pileHeap()
{
	SceneDefinition scene = digitsOnFloor("pile-heap", "a hundred digits fall onto a heap");
	std::mt19937_64 random(constant::seed);
	for (int i = 0; i < constant::digits * constant::copies; ++i)
	{
		const int layer = i / constant::inLayer, place = i % constant::inLayer;
		const double angle = 2 * kPi / (constant::inLayer - 1) * (place + 0.5 * (layer % 2));
		const double out = place == 0 ? 0 : constant::spacing;
		// Uniform over all orientations (Shoemake 1992).
		const double u = uniform(random), v = 2 * kPi * uniform(random), w = 2 * kPi * uniform(random);
		addDigit(scene, i % constant::digits, i / constant::digits,
				 {{out * std::cos(angle), constant::lowestLayer + layer * constant::layer, out * std::sin(angle)},
				  {std::sqrt(1 - u) * std::sin(v), std::sqrt(1 - u) * std::cos(v), std::sqrt(u) * std::sin(w),
				   std::sqrt(u) * std::cos(w)}});
	}
	scene.constants = {{"lowest_layer", constant::lowestLayer, "m"}, {"seed", double(constant::seed), ""}};
	return scene;
}
}  // namespace clod::demo
