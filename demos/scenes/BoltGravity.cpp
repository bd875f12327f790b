// SPDX-License-Identifier: Zlib
// A nut runs down the thread of a bolt by its weight, without friction, until it sits on the head. Ideally it falls
// evenly accelerated, the slower the more its turning weighs: a = g / (1 + (2 pi k / lead)^2), k its radius of
// gyration.
#include <algorithm>
#include <cmath>

#include "demos/models/Models.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr double nutMass = 0.02, startHeight = 0.032;  // of the nut's middle
constexpr double seat = BOLT_HEAD_HEIGHT + NUT_HEIGHT / 2;
constexpr double wall = 0.0020;  // of the nut over its thread
constexpr int steps = 360;
}  // namespace constant

std::vector<double> outcomeOf(const SceneState& state, double acceleration)
{
	const Pose& nut = state.bodies[1].pose;
	const double (&q)[4] = nut.quaternion;
	const double turned = 2 * std::atan2(q[1], q[3]), onThread = -2 * kPi * nut.position.y / THREAD_LEAD;
	const double ideal = std::max(constant::seat, constant::startHeight - acceleration * state.time * state.time / 2);
	return {nut.position.y, ideal, std::remainder(turned - onThread, 2 * kPi) * 180 / kPi,
			std::hypot(nut.position.x, nut.position.z)};
}

void knowInertia(SceneDefinition& scene, const std::vector<std::shared_ptr<const Hierarchy>>& models)
{
	const Asset& nut = models[1]->asset();
	const double ratio = 4 * kPi * kPi * nut.inertia[1] / nut.volume / (THREAD_LEAD * THREAD_LEAD);
	const double acceleration = kGravity / (1 + ratio);
	scene.constants.push_back({"ideal_acceleration", acceleration, "m/s^2"});
	scene.outcome = [acceleration](const SceneState& state) { return outcomeOf(state, acceleration); };
}
}  // namespace

SceneDefinition boltGravity()
{
	SceneDefinition scene =
		mechanism("bolt-gravity", "a nut runs down the thread of a bolt by its weight, without friction", 0);
	SceneInfo& info = scene.info;
	info.models = {{"bolt", ""}, {"nut", ""}};
	info.bodies = {{"bolt", 0, false}, {"nut", 1, true}};
	info.tolerance = 0.01 * NUT_RADIUS;
	info.thinnerWall = constant::wall;
	info.steps = constant::steps;
	info.overview = {{0, 0.022, 0}, 0.030, 20, 22, -1, ""};
	info.closeUp = {{0, 0, 0}, 0.012, 20, 15, 1, "close-up, through the nut"};
	info.hasGround = true;
	info.outcome = {{"height", "m"}, {"ideal_height", "m"}, {"off_thread", "degrees"}, {"off_axis", "m"}};
	const double turn = std::remainder(-2 * kPi * constant::startHeight / THREAD_LEAD, 2 * kPi);
	scene.bodies = {{0, Pose{}, {}}, {constant::nutMass, turnedAboutY({0, constant::startHeight, 0}, turn), {}}};
	scene.inPlace = [](std::size_t, const Vec3& center)
	{ return center.y > constant::seat - constant::wall && center.y < constant::startHeight + constant::wall; };
	scene.prepare = knowInertia;
	scene.constants = {{"nut_start_height", constant::startHeight, "m"},
					   {"nut_seat_height", constant::seat, "m"},
					   {"thread_lead", THREAD_LEAD, "m"}};
	return scene;
}
}  // namespace clod::demo
