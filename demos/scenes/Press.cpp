// SPDX-License-Identifier: Zlib
// A block slides by its weight into a socket that is a twentieth of a millimetre wider on either side: a loose press
// fit, in contact with up to five walls.
#include <cmath>

#include "demos/models/Mechanisms.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr double mass = 0.1, friction = 0.3;
constexpr double startHeight = 0.002, offset = 0.00003;  // over the opening; aside, of the play
constexpr int steps = 480;
}  // namespace constant
}  // namespace

SceneDefinition press()
{
	SceneDefinition scene = mechanism("press", "a block slides into a socket with little play", constant::friction);
	SceneInfo& info = scene.info;
	info.models = {{"socket", ""}, {"block", ""}};
	info.bodies = {{"socket", 0, true}, {"block", 1, false}};
	info.tolerance = 0.01 * BLOCK_WIDTH / 2;
	info.thinnerWall = SOCKET_BOTTOM;
	info.steps = constant::steps;
	info.overview = {{0, 0.0, 0}, 0.045, 25, 25, -1, ""};
	info.closeUp = {{0, -0.010, 0}, 0.020, 25, 15, -1, "close-up, through the socket"};
	info.outcome = {{"depth", "m"}, {"lean", "degrees"}};
	const Pose upright = turnedAbout({1, 0, 0}, -kPi / 2);
	Pose block = upright;
	block.position = {constant::offset, constant::startHeight, constant::offset};
	scene.bodies = {{0, upright, {}}, {constant::mass, block, {}}};
	scene.inPlace = [](std::size_t, const Vec3& center)
	{
		return center.y > -SOCKET_DEPTH + BLOCK_HEIGHT / 2 - SOCKET_PLAY &&
			   std::hypot(center.x, center.z) < BLOCK_WIDTH / 2;
	};
	scene.outcome = [](const SceneState& state) -> std::vector<double>
	{
		const Transform moved = toTransform(state.bodies[1].pose);
		return {-moved.translation.y, std::acos(std::min(1.0, moved.rotation.column(2).y)) * 180 / kPi};
	};
	scene.constants = {{"start_height", constant::startHeight, "m"},
					   {"offset", constant::offset, "m"},
					   {"play", SOCKET_PLAY, "m, either side"}};
	return scene;
}
}  // namespace clod::demo
