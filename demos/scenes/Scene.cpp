// SPDX-License-Identifier: Zlib
// The list of scenes.
#include <algorithm>
#include <cmath>

#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
const std::vector<SceneDefinition>& sceneDefinitions()
{
	static const std::vector<SceneDefinition> all = {
		spoonCup(),       torusSpiral(), numbersBowl(),  spoonsNested(),
		boltNut(),        mixedNeeds(),  contactArea(),  pendulum(),
		doublePendulum(), chain(),       rack(),         piston(),
		arch(),           arch101(),     boltGravity(),  wedges(),
		nestedCups(),     pileStacks(),  pileHeap(),     press(),
		spinningPlate(),  ringOnPeg(),   rockingTorus(), drop({{"torus", ""}, {"number8", ""}, {"nut", ""}})};
	return all;
}

Vec3 steadyGravity(double)
{
	return {0, -kGravity, 0};
}

WorldConstants undamped(const WorldConstants& world)
{
	WorldConstants free = world;
	free.rollingFriction = free.spinningFriction = 0;
	free.linearDamping = free.angularDamping = 0;
	return free;
}

SceneDefinition mechanism(const std::string& name, const std::string& summary, double friction)
{
	SceneDefinition scene;
	scene.info.name = name;
	scene.info.summary = summary;
	scene.info.dt = 1.0 / 240;
	scene.info.worldScale = 100;
	scene.info.hasGround = false;
	scene.world.friction = friction;
	scene.world = undamped(scene.world);
	scene.gravity = steadyGravity;
	return scene;
}

double smoothStep(double t)
{
	t = std::clamp(t, 0.0, 1.0);
	return t * t * (3 - 2 * t);
}

Pose turnedAbout(const Vec3& axis, double angle, const Vec3& place)
{
	const double s = std::sin(angle / 2);
	return {place, {s * axis.x, s * axis.y, s * axis.z, std::cos(angle / 2)}};
}

Pose turnedTwice(const Pose& first, const Pose& second)
{
	const double (&p)[4] = second.quaternion;
	const double (&q)[4] = first.quaternion;
	const Vec3 u{p[0], p[1], p[2]}, v{q[0], q[1], q[2]}, w = p[3] * v + q[3] * u + cross(u, v);
	return {toTransform(second) * first.position, {w.x, w.y, w.z, p[3] * q[3] - dot(u, v)}};
}

Pose turnedAboutY(const Vec3& place, double angle)
{
	return turnedAbout({0, 1, 0}, angle, place);
}

const std::vector<SceneInfo>& scenes()
{
	static const std::vector<SceneInfo> infos = []
	{
		std::vector<SceneInfo> list;
		for (const SceneDefinition& scene : sceneDefinitions()) list.push_back(scene.info);
		return list;
	}();
	return infos;
}

const SceneDefinition* findDefinition(const std::string& name)
{
	for (const SceneDefinition& scene : sceneDefinitions())
		if (scene.info.name == name) return &scene;
	return nullptr;
}

const SceneInfo* findScene(const std::string& name)
{
	const SceneDefinition* const known = findDefinition(name);
	return known ? &known->info : nullptr;
}

}  // namespace clod::demo
