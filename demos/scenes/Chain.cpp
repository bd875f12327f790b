// SPDX-License-Identifier: Zlib
// Ten links of a chain, the first held, fall from a slant and swing: saddle against saddle in every joint.
#include <algorithm>
#include <cmath>

#include "demos/models/Mechanisms.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr int links = 10;
constexpr double mass = 0.01, friction = 0.3;
constexpr double slant = kPi / 4;  // of the chain at the start, below the horizontal
constexpr double slack = 0.00015;  // of a joint at the start
constexpr int steps = 1200, iterations = 200;  // of the solver: nine joints in a row
}  // namespace constant

// How far the middles of the wires of each joint's two ends are apart beyond the wire's thickness, at most: 0 where all
// joints are taut, without limit where links have come apart.
std::vector<double> outcomeOf(const SceneState& state)
{
	const Vec3 end{LINK_HALF_STRAIGHT + LINK_BEND, 0, 0};
	double largest = -HUGE_VAL, deepest = HUGE_VAL;
	for (std::size_t i = 0; i + 1 < state.bodies.size(); ++i)
	{
		const Vec3 last = toTransform(state.bodies[i].pose) * end, first = toTransform(state.bodies[i + 1].pose) * -end;
		const double gap = length(last - first) - 2 * LINK_WIRE;
		largest = std::max(largest, gap);
		deepest = std::min(deepest, gap);
	}
	return {largest, deepest};
}
}  // namespace

SceneDefinition chain()
{
	SceneDefinition scene =
		mechanism("chain", "ten links of a chain, the first held, swing and come to hang", constant::friction);
	SceneInfo& info = scene.info;
	info.models = {{"chain-link", ""}};
	const Vec3 ahead{std::cos(constant::slant), -std::sin(constant::slant), 0};
	for (int i = 0; i < constant::links; ++i)
	{
		info.bodies.push_back({"link-" + std::to_string(i + 1), 0, false});
		const Pose turned = turnedAbout({1, 0, 0}, i % 2 == 0 ? 0 : kPi / 2);
		const Vec3 place = i * (CHAIN_PITCH - constant::slack) * ahead;
		scene.bodies.push_back(
			{i == 0 ? 0 : constant::mass, turnedTwice(turned, turnedAbout({0, 0, 1}, -constant::slant, place)), {}});
	}
	info.tolerance = 0.01 * LINK_HALF_STRAIGHT;
	info.thinnerWall = 2 * LINK_WIRE;
	info.steps = constant::steps;
	scene.world.solverIterations = constant::iterations;
	info.overview = {{0.03, -0.10, 0}, 0.18, 10, 8, -1, ""};
	info.closeUp = {{0, 0, 0}, 0.035, 30, 20, 1, "close-up of the second link"};
	info.outcome = {{"widest_joint_gap", "m"}, {"narrowest_joint_gap", "m"}};
	scene.inPlace = [](std::size_t, const Vec3& center) { return length(center) < constant::links * CHAIN_PITCH; };
	scene.outcome = outcomeOf;
	scene.constants = {{"slant", constant::slant, "rad"}, {"slack", constant::slack, "m"}, {"pitch", CHAIN_PITCH, "m"}};
	return scene;
}
}  // namespace clod::demo
