// SPDX-License-Identifier: Zlib
// A convex body of Bullet's slides over a waved landscape of ours: how often, and where, bodies meet detailed static
// ground in most programs.
#include "demos/models/Models.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr double mass = 0.1, friction = 0.1;
constexpr double startGap = 0.001, startAcross = -0.5;  // from the landscape; from its middle
constexpr double aside = 0.3;                           // of the speed
constexpr int steps = 240;
}  // namespace constant
}  // namespace

SceneDefinition slideOnLandscape(const SceneModel& body, double half, double speed)
{
	SceneDefinition scene = mechanism("landscape", "a convex body slides over a landscape", constant::friction);
	SceneInfo& info = scene.info;
	info.models = {{"landscape", ""}, body};
	info.bodies = {{"landscape", 0, false}, {"body", 1, false}};
	info.tolerance = 0.01 * half;
	info.thinnerWall = LANDSCAPE_THICKNESS;
	info.steps = constant::steps;
	info.overview = {{0, 0, 0}, 1, 20, 30, -1, ""};
	info.closeUp = {{0, 0, 0}, 3 * half, 20, 30, 1, "close-up"};
	const double x = constant::startAcross;
	const Pose start{{x, landscapeHeight(x, 0) + half + constant::startGap, 0}, {0, 0, 0, 1}};
	scene.bodies = {{0, {}, {}}, {constant::mass, start, {}, {speed, 0, constant::aside * speed}}};
	scene.inPlace = [](std::size_t, const Vec3& center) { return center.y > landscapeHeight(center.x, center.z); };
	return scene;
}
}  // namespace clod::demo
