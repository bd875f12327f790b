// SPDX-License-Identifier: Zlib
// Wedges of 20 to 90 degrees in pairs, edge on edge and crossed: the upper one falls, kept upright, and is held by the
// one point where the edges cross.

#include "demos/models/Mechanisms.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr int sharpest = 20, bluntest = 90, step = 10;  // degrees
constexpr double mass = 0.05, dropHeight = 0.005, spacing = 0.055;
constexpr int steps = 240;
}  // namespace constant

std::vector<double> outcomeOf(const SceneState& state)
{
	std::vector<double> heights;
	for (std::size_t upper = 1; upper < state.bodies.size(); upper += 2)
		heights.push_back(state.bodies[upper].pose.position.y - WEDGE_HEIGHT);
	return heights;
}
}  // namespace

SceneDefinition wedges()
{
	SceneDefinition scene = mechanism("wedges", "wedges of 20 to 90 degrees fall edge on edge, crossed", 0.3);
	SceneInfo& info = scene.info;
	const Pose crossed = turnedTwice(turnedAbout({1, 0, 0}, kPi), turnedAbout({0, 1, 0}, kPi / 2));
	const double middle = (constant::bluntest - constant::sharpest) / constant::step / 2.0;
	for (int degrees = constant::sharpest; degrees <= constant::bluntest; degrees += constant::step)
	{
		const std::string angle = std::to_string(degrees);
		const std::size_t model = info.models.size();
		info.models.push_back({"wedge" + angle, ""});
		info.bodies.push_back({"lower-" + angle, model, false});
		info.bodies.push_back({"upper-" + angle, model, false});
		info.outcome.push_back({"edge_gap_" + angle, "m"});
		const double x = constant::spacing * (double(model) - middle);
		Pose upper = crossed;
		upper.position = {x, WEDGE_HEIGHT + constant::dropHeight, 0};
		scene.bodies.push_back({0, {{x, WEDGE_HEIGHT, 0}}, {}});
		scene.bodies.push_back({constant::mass, upper, {}, {}, {}, {0, 1, 0}, {0, 0, 0}});
	}
	info.tolerance = 0.01 * WEDGE_HEIGHT;
	info.thinnerWall = 0.1 * WEDGE_HEIGHT;
	info.steps = constant::steps;
	info.overview = {{0, 0.02, 0}, 0.235, 10, 20, -1, ""};
	info.hasGround = true;
	info.closeUp = {{-0.1375, 0.02, 0}, 0.055, 30, 20, -1, "close-up of the sharpest three"};
	scene.inPlace = [](std::size_t, const Vec3& center) { return center.y > WEDGE_HEIGHT; };
	scene.outcome = outcomeOf;
	scene.constants = {{"drop_height", constant::dropHeight, "m"}, {"wedge_height", WEDGE_HEIGHT, "m"}};
	return scene;
}
}  // namespace clod::demo
