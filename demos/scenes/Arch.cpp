// SPDX-License-Identifier: Zlib
// Half circles of dry stones, the lowest on either side held: they stand by friction and thrust alone, as wide as a
// Roman bridge. What a step falls by counts against the stones' thickness: a hundredth of the size wants many times the
// iterations, of Bullet's own hulls as well.
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
constexpr double archMass = 680e3, friction = 0.8;  // of all stones, granite; of each stone
constexpr int steps = 960, iterations = 50;
}  // namespace constant

// The middle of a joint as two neighbours have it.
struct Joint
{
	Vec3 before, after, thrust;
};

Joint jointOf(const SceneState& state, std::size_t stone, int stones)
{
	const double half = kPi / stones / 2, radius = (ARCH_INSIDE + ARCH_OUTSIDE) / 2;
	const Vec3 middle{radius * std::sin(half), radius * std::cos(half), 0};
	const Transform left = toTransform(state.bodies[stone].pose), right = toTransform(state.bodies[stone + 1].pose);
	return {left * middle, right * Vec3{-middle.x, middle.y, 0},
			left.rotation * Vec3{std::cos(half), -std::sin(half), 0}};
}

SceneDefinition archOf(int stones, const std::string& name)
{
	SceneDefinition scene =
		mechanism(name, std::to_string(stones) + " dry stones stand as an arch", constant::friction);
	SceneInfo& info = scene.info;
	info.models = {{"voussoir" + std::to_string(stones), ""}};
	for (int i = 0; i < stones; ++i)
	{
		info.bodies.push_back({"stone-" + std::to_string(i + 1), 0, false});
		const bool isHeld = i == 0 || i == stones - 1;
		const double angle = kPi / 2 - kPi * (i + 0.5) / stones;  // from the top, to the left
		scene.bodies.push_back({isHeld ? 0 : constant::archMass / stones, turnedAbout({0, 0, 1}, angle), {}});
	}
	info.tolerance = 0.01 * ARCH_DEPTH / 2;
	info.thinnerWall = ARCH_OUTSIDE * kPi / stones / 2;
	info.steps = constant::steps;
	info.worldScale = 1;
	info.overview = {{0, 4.5, 0}, 14, 20, 15, -1, ""};
	info.closeUp = {{0, (ARCH_INSIDE + ARCH_OUTSIDE) / 2, 0}, 3.5, 25, 20, -1, "close-up of the crown"};
	info.hasGround = true;
	info.outcome = {{"largest_sliding", "m"}, {"widest_joint", "m"}, {"narrowest_joint", "m"}, {"crown_drop", "m"}};
	scene.world.solverIterations = constant::iterations;
	scene.world.warmstartingFactor = 1;
	scene.inPlace = [](std::size_t, const Vec3& center) { return center.y > 0 && length(center) > 0.95 * ARCH_INSIDE; };
	scene.outcome = [stones](const SceneState& state) -> std::vector<double>
	{
		double sliding = 0, widest = -HUGE_VAL, narrowest = HUGE_VAL;
		for (std::size_t i = 0; i + 1 < std::size_t(stones); ++i)
		{
			const Joint joint = jointOf(state, i, stones);
			const Vec3 apart = joint.after - joint.before;
			const double gap = dot(apart, joint.thrust);
			sliding = std::max(sliding, length(apart - gap * joint.thrust));
			widest = std::max(widest, gap + ARCH_JOINT);
			narrowest = std::min(narrowest, gap + ARCH_JOINT);
		}
		return {sliding, widest, narrowest, -state.bodies[std::size_t(stones) / 2].pose.position.y};
	};
	scene.constants = {{"stones", double(stones), ""}, {"joint", ARCH_JOINT, "m"}};
	return scene;
}
}  // namespace

SceneDefinition arch()
{
	return archOf(25, "arch");
}

SceneDefinition arch101()
{
	return archOf(101, "arch-101");
}
}  // namespace clod::demo
