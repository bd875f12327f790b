// SPDX-License-Identifier: Zlib
// Three bodies fall on each other on a floor and come to rest: any models, so the scene where meshes of other people
// are tried (`clod-bench run drop --model FILE ...`, scripts/real-meshes).
#include <algorithm>
#include <cmath>

#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr double mass = 0.02;
constexpr double room = 0.002;         // between the bounding spheres at the start, and under the lowest
constexpr double aside = 0.25;         // a body starts so much of its radius off the middle, so that it rolls off
constexpr double typical = 0.025;      // radius that tolerance and wall are given for
constexpr double friction = 0.5;       // of each body
constexpr double rollingArm = 0.0005;  // round bodies come to rest
constexpr double reach = 0.1;          // farther from the middle a body is lost
}  // namespace constant

Vec3 centerOf(const Hierarchy& hierarchy)
{
	const Asset& a = hierarchy.asset();
	return Vec3{a.meshFromBody[0], a.meshFromBody[1], a.meshFromBody[2]} +
		   Vec3{double(a.sphereCenter[0]), double(a.sphereCenter[1]), double(a.sphereCenter[2])};
}

// One above the other, each turned by a third of a circle and a little off the middle.
void stack(SceneDefinition& scene, const std::vector<std::shared_ptr<const Hierarchy>>& models)
{
	const double floor = double(models[0]->asset().boxMax[1]) + models[0]->asset().meshFromBody[1];
	double height = 0;
	scene.bodies[0].start.position = {0, -floor, 0};
	for (std::size_t i = 1; i < scene.bodies.size(); ++i)
	{
		const Hierarchy& model = *models[scene.info.bodies[i].model];
		const double radius = double(model.asset().radius), angle = 2 * kPi / 3 * double(i);
		const Pose turned = turnedAboutY({}, angle);
		const double* const q = turned.quaternion;
		const Vec3 center = rotationFromQuaternion(q[0], q[1], q[2], q[3]) * centerOf(model);
		const double off = constant::aside * radius;
		const Vec3 place{off * std::cos(angle), height + constant::room + radius, off * std::sin(angle)};
		scene.bodies[i].start = turnedAboutY(place - center, angle);
		height += constant::room + 2 * radius;
	}
}
}  // namespace

SceneDefinition drop(const std::vector<SceneModel>& models)
{
	SceneDefinition scene;
	SceneInfo& info = scene.info;
	info.name = "drop";
	info.summary = "three bodies fall on each other on a floor; --model FILE puts others in their place";
	info.models = {{"floor", ""}};
	info.bodies = {{"floor", 0, true}};
	scene.bodies = {{0, Pose{}, {}}};
	for (std::size_t i = 0; i < models.size(); ++i)
	{
		info.models.push_back(models[i]);
		info.bodies.push_back({models[i].name + "-" + std::to_string(i + 1), i + 1, false});
		scene.bodies.push_back({constant::mass, Pose{}, {}});
	}
	info.tolerance = 0.01 * constant::typical;
	info.thinnerWall = 0.05 * constant::typical;
	info.dt = 1.0 / 1920;  // bodies meet at 1 m/s and have limbs of a millimetre
	info.steps = 2880;
	info.worldScale = 100;
	info.overview = {{0, 0.045, 0}, 0.10, 20, 20, -1, ""};
	info.closeUp = {{0, 0.02, 0}, 0.05, 65, 25, -1, "close-up"};
	info.hasGround = false;
	scene.world.friction = constant::friction;
	scene.world.rollingFriction = scene.world.spinningFriction = constant::rollingArm;
	scene.gravity = steadyGravity;
	scene.inPlace = [](std::size_t, const Vec3& center)
	{ return center.y > 0 && std::hypot(center.x, center.z) < constant::reach; };
	scene.constants = {{"start_room", constant::room, "m"}, {"start_aside", constant::aside, "radii"}};
	scene.prepare = stack;
	return scene;
}
}  // namespace clod::demo
