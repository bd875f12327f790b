// SPDX-License-Identifier: Zlib
// A nut on a bolt, twice, on courses: it is screwed down the thread (bolt-nut), and it is screwed on from above so that
// contact area grows at fixed resolution (contact-area; Otaduy & Lin 2003, sec. 3.1, Fig. 1). A thread is fine detail
// that uniform decimation destroys.
#include <cmath>

#include "demos/models/Models.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr double startHeight = 0.032, endHeight = 0.012;  // of the nut's middle
constexpr int runSteps = 480;
constexpr double lean = 0.00005, leanFrequency = 1.3;  // radial, a fifth of the play; turns a second
constexpr double wall = 0.0020;                        // of the nut over its thread
constexpr double highest = 0.047, lowest = 0.034;      // of the nut's middle while it is screwed on
constexpr int screwSteps = 240;
}  // namespace constant

Pose onThread(double height)
{
	return turnedAboutY({0, height, 0}, -2 * kPi * height / THREAD_LEAD);
}

SceneInfo describe()
{
	SceneInfo info;
	info.models = {{"bolt", ""}, {"nut", ""}};
	info.bodies = {{"bolt", 0, false}, {"nut", 1, true}};
	info.thinnerWall = constant::wall;
	info.dt = 1.0 / 240;
	info.worldScale = 100;
	info.overview = {{0, 0.022, 0}, 0.030, 20, 22, -1, ""};
	info.closeUp = {{0, 0, 0}, 0.012, 20, 15, 1, "close-up, through the nut"};
	return info;
}
}  // namespace

SceneDefinition boltNut()
{
	SceneDefinition scene;
	scene.info = describe();
	scene.info.name = "bolt-nut";
	scene.info.summary = "a nut is screwed down the thread of a bolt";
	scene.info.tolerance = 0.01 * NUT_RADIUS;
	scene.info.steps = constant::runSteps;
	const double rate = (constant::startHeight - constant::endHeight) / (scene.info.steps * scene.info.dt);
	scene.bodies.resize(2);
	scene.bodies[1].course = [rate](double time)
	{
		Pose pose = onThread(constant::startHeight - rate * time);
		// The side of the bolt that the nut leans on goes round.
		const double turn = 2 * kPi * constant::leanFrequency * time;
		pose.position += constant::lean * Vec3{std::cos(turn), 0, std::sin(turn)};
		return pose;
	};
	scene.gravity = steadyGravity;
	scene.inPlace = [](std::size_t, const Vec3&) { return true; };
	scene.constants = {{"nut_start_height", constant::startHeight, "m"},
					   {"nut_end_height", constant::endHeight, "m"},
					   {"thread_lead", THREAD_LEAD, "m"},
					   {"lean", constant::lean, "m"},
					   {"lean_frequency", constant::leanFrequency, "Hz"}};
	return scene;
}

SceneDefinition contactArea()
{
	SceneDefinition scene;
	scene.info = describe();
	scene.info.name = "contact-area";
	scene.info.summary = "a nut is screwed onto a bolt: the contact area grows";
	scene.info.tolerance = THREAD_PLAY;
	scene.info.steps = constant::screwSteps;
	scene.info.overview = {{0, 0.028, 0}, 0.036, 20, 22, -1, ""};  // the nut begins above the bolt
	const double rate = (constant::highest - constant::lowest) / (scene.info.steps * scene.info.dt);
	scene.bodies.resize(2);
	scene.bodies[1].course = [rate](double time) { return onThread(constant::highest - rate * time); };
	scene.gravity = steadyGravity;
	scene.inPlace = [](std::size_t, const Vec3&) { return true; };
	scene.constants = {{"nut_highest", constant::highest, "m"}, {"nut_lowest", constant::lowest, "m"}};
	return scene;
}
}  // namespace clod::demo
