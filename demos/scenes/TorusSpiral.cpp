// SPDX-License-Identifier: Zlib
// The wrinkled torus falls round the spiral peg and comes to rest on its foot: fast, with few and short contacts. The
// second benchmark of Otaduy & Lin 2003, sec. 6.
#include <cmath>

#include "demos/models/Models.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr double torusMass = 0.011;
constexpr double startHeight = 0.205;  // of the torus's centre, on the peg's axis
constexpr double tilt = 0.12;          // radians between the torus's axis and the peg's there
constexpr double footThickness = 0.004;
constexpr double reach = 0.03;  // from the vertical: farther out the torus has left the peg
}  // namespace constant

// The shortest turn that takes up (y) to a direction.
Pose torusStart()
{
	const Vec3 tangent = spiralTangent(constant::startHeight);
	const Vec3 direction = normalized(tangent + std::tan(constant::tilt) * normalized(cross(tangent, {0, 0, 1})));
	const Vec3 axis = cross({0, 1, 0}, direction);
	const double w = std::sqrt((1 + direction.y) / 2), s = 1 / (2 * w);
	return {spiralAxis(constant::startHeight), {s * axis.x, s * axis.y, s * axis.z, w}};
}

SceneInfo describe()
{
	SceneInfo info;
	info.name = "torus-spiral";
	info.summary = "a wrinkled torus falls round a spiral peg";
	info.models = {{"spiral", ""}, {"torus", ""}};
	info.bodies = {{"spiral", 0, false}, {"torus", 1, true}};
	info.tolerance = 0.01 * (TORUS_RING_RADIUS + TORUS_TUBE_RADIUS);
	info.thinnerWall = constant::footThickness;
	info.dt = 1.0 / 960;  // it reaches 1 m/s: 4 mm a 240th of a second, half its tube
	info.steps = 1440;
	info.worldScale = 100;
	info.overview = {{0, 0.126, 0}, 0.175, 20, 12, -1, ""};
	info.closeUp = {{0, 0, 0}, 0.030, 20, 25, 1, "close-up, through the torus"};
	return info;
}
}  // namespace

SceneDefinition torusSpiral()
{
	SceneDefinition scene;
	scene.info = describe();
	scene.bodies = {{0, Pose{}, {}}, {constant::torusMass, torusStart(), {}}};
	scene.gravity = steadyGravity;
	scene.inPlace = [](std::size_t, const Vec3& center)
	{ return center.y > 0 && center.y < SPIRAL_HEIGHT && std::hypot(center.x, center.z) < constant::reach; };
	scene.constants = {{"torus_start_height", constant::startHeight, "m"}, {"torus_tilt", constant::tilt, "rad"}};
	return scene;
}
}  // namespace clod::demo
