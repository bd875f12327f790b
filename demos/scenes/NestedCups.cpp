// SPDX-License-Identifier: Zlib
// Ten tumblers fall into one another and come to rest as a stack: cone on cone, in contact all round.
#include <cmath>

#include "demos/models/Mechanisms.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr int cups = 10;
constexpr double mass = 0.05, friction = 0.3;
constexpr double gap = 0.002;   // in height, of every cup over the one below
constexpr double twist = 0.02;  // against the one below: facets are not parallel
constexpr int steps = 720, iterations = 100;  // of the solver: ten cups, each in all those above
}  // namespace constant

// How much higher the cups stand over each other than where cones would touch: least and most of all.
std::vector<double> outcomeOf(const SceneState& state)
{
	double least = HUGE_VAL, most = -HUGE_VAL;
	for (std::size_t i = 0; i + 1 < state.bodies.size(); ++i)
	{
		const Pose &below = state.bodies[i].pose, &above = state.bodies[i + 1].pose;
		const double over = above.position.y - below.position.y - TUMBLER_PITCH;
		least = std::min(least, over);
		most = std::max(most, over);
	}
	return {least, most};
}
}  // namespace

SceneDefinition nestedCups()
{
	SceneDefinition scene =
		mechanism("nested-cups", "ten tumblers fall into one another and come to rest", constant::friction);
	SceneInfo& info = scene.info;
	info.models = {{"tumbler", ""}};
	for (int i = 0; i < constant::cups; ++i)
	{
		info.bodies.push_back({"cup-" + std::to_string(i + 1), 0, true});
		const Vec3 place{0, i * (TUMBLER_PITCH + constant::gap), 0};
		scene.bodies.push_back({i == 0 ? 0 : constant::mass, turnedAboutY(place, constant::twist * i), {}});
	}
	info.tolerance = 0.01 * TUMBLER_TOP;
	info.thinnerWall = TUMBLER_WALL;
	info.steps = constant::steps;
	info.overview = {{0, 0.072, 0}, 0.10, 20, 15, -1, ""};
	info.closeUp = {{0, 0.03, 0}, 0.045, 20, 10, 1, "close-up of the second cup, through them all"};
	info.hasGround = true;
	info.outcome = {{"least_over_seat", "m"}, {"most_over_seat", "m"}};
	scene.world.solverIterations = constant::iterations;
	scene.inPlace = [](std::size_t, const Vec3& center) { return std::hypot(center.x, center.z) < TUMBLER_FOOT; };
	scene.outcome = outcomeOf;
	scene.constants = {{"cups", constant::cups, ""}, {"gap", constant::gap, "m"}, {"pitch", TUMBLER_PITCH, "m"}};
	return scene;
}
}  // namespace clod::demo
