// SPDX-License-Identifier: Zlib
// Bodies fall on each other on a floor and come to rest: any models, so the scenes where meshes of other people are
// tried (`clod-bench run drop --model FILE ...`, scripts/real-meshes; `clod-bench try`, where the floor then tilts).
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
// Of the trial, whose lengths are shares of the largest radius.
constexpr double played = 0.1;     // metres that radius is taken for: how fast things look
constexpr double floorHalf = 0.1;  // metres, of the model `floor`
constexpr double trialFloor = 10;  // half its width
constexpr double tilt = 0.35;      // radians, of gravity: more than friction holds
constexpr double tiltStart = 2.6, tiltEnd = 3.1, ease = 0.2, trialSeconds = 5;
constexpr double bulletRadius = 5;  // of the largest body in Bullet's lengths
}  // namespace constant

Vec3 centerOf(const Hierarchy& hierarchy)
{
	const Asset& a = hierarchy.asset();
	return Vec3{a.meshFromBody[0], a.meshFromBody[1], a.meshFromBody[2]} +
		   Vec3{double(a.sphereCenter[0]), double(a.sphereCenter[1]), double(a.sphereCenter[2])};
}

// One above the other, each turned by a third of a circle and a little off the middle.
void stack(SceneDefinition& scene, const std::vector<std::shared_ptr<const Hierarchy>>& models, double room)
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
		const Vec3 place{off * std::cos(angle), height + room + radius, off * std::sin(angle)};
		scene.bodies[i].start = turnedAboutY(place - center, angle);
		height += room + 2 * radius;
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
	scene.prepare = [](SceneDefinition& made, const std::vector<std::shared_ptr<const Hierarchy>>& built)
	{ stack(made, built, constant::room); };
	return scene;
}

SceneDefinition trial(const std::vector<SceneModel>& models, double largest, double smallest)
{
	SceneDefinition scene;
	SceneInfo& info = scene.info;
	info.name = "trial";
	info.summary = "bodies fall on each other on a floor, come to rest, and slide as it tilts";
	info.models = {{"floor", "", constant::trialFloor * largest / constant::floorHalf}};
	info.bodies = {{"floor", 0, true}};
	scene.bodies = {{0, Pose{}, {}}};
	// One or two meshes are met by copies of the first.
	const std::size_t bodies = std::max<std::size_t>(3, models.size());
	info.models.insert(info.models.end(), models.begin(), models.end());
	for (std::size_t i = 0; i < bodies; ++i)
	{
		const std::size_t model = i % models.size();
		info.bodies.push_back({models[model].name + "-" + std::to_string(i + 1), model + 1, false});
		scene.bodies.push_back({constant::mass, Pose{}, {}});
	}
	info.tolerance = 0.01 * smallest;
	info.thinnerWall = 0.05 * smallest;
	info.dt = 1.0 / 240;
	info.steps = int(constant::trialSeconds * 240);
	info.worldScale = constant::bulletRadius / largest;
	info.hasGround = false;
	scene.world.friction = constant::friction;
	scene.world.rollingFriction = scene.world.spinningFriction = constant::rollingArm / constant::typical * smallest;
	scene.gravity = [largest](double time)
	{
		const double angle = constant::tilt * (smoothStep((time - constant::tiltStart) / constant::ease) -
											   smoothStep((time - constant::tiltEnd) / constant::ease));
		const double size = kGravity / constant::played * largest;
		return Vec3{size * std::sin(angle), -size * std::cos(angle), 0};
	};
	scene.inPlace = [largest](std::size_t, const Vec3& center)
	{
		const double half = constant::trialFloor * largest;
		return center.y > 0 && std::fabs(center.x) < half && std::fabs(center.z) < half;
	};
	const double room = constant::room / constant::typical * largest;
	scene.prepare = [room](SceneDefinition& made, const std::vector<std::shared_ptr<const Hierarchy>>& built)
	{ stack(made, built, room); };
	return scene;
}
}  // namespace clod::demo
