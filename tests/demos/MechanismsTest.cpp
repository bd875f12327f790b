// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes of mechanisms: they run, their bodies start apart (all triangles of one against all of the other, and no
// vertex of one inside the other), hold and rest; each check shown failing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "demos/models/Mechanisms.h"
#include "demos/runner/Penetration.h"
#include "tests/demos/MechanismScenes.h"
#include "tests/query/Bodies.h"
#include "tests/query/TriangleGap.h"
#include "tests/support/NamedTests.h"

namespace
{
using namespace clod;
using namespace clod::demo;

const std::vector<std::string> kScenes = {"pendulum",     "double-pendulum", "chain",  "rack",           "piston",
										  "arch",         "arch-101",        "wedges", "nested-cups",    "bolt-gravity",
										  "pile-stacks",  "pile-heap",       "press",  "spinning-plate", "ring-on-peg",
										  "rocking-torus"};

const SceneDefinition& definitionOf(const std::string& name)
{
	if (const SceneDefinition* const scene = findDefinition(name)) return *scene;
	throw std::runtime_error("no scene " + name);
}

// The chain in btClodDynamicsWorld, whose steps are solved in passes and divided.
std::unique_ptr<Scene> chainInPasses(double resolution, const ContactMetric& metric, int rate)
{
	const SceneDefinition& definition = definitionOf("chain");
	SceneSettings settings = settingsOf(definition.info, resolution);
	settings.metric = metric;
	settings.dt = 1.0 / rate;
	settings.passes = 3;
	settings.parts = 8;
	return makeScene(definition, settings);
}

// Radii a second.
double speedOf(const BodyState& body, double radius)
{
	return length(body.velocity) / radius + length(body.turning);
}

test::TriangleSoup placedTriangles(const ModelMesh& mesh, const Pose& pose)
{
	const Transform worldFromMesh = toTransform(pose);
	test::TriangleSoup triangles;
	for (const auto& t : mesh.triangles)
		triangles.push_back({worldFromMesh * mesh.vertices[t[0]], worldFromMesh * mesh.vertices[t[1]],
							 worldFromMesh * mesh.vertices[t[2]]});
	return triangles;
}

struct Box
{
	Vec3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
	void add(const std::array<Vec3, 3>& triangle)
	{
		for (const Vec3& p : triangle)
			for (int k = 0; k < 3; ++k)
			{
				low[k] = std::min(low[k], p[k]);
				high[k] = std::max(high[k], p[k]);
			}
	}
	bool meets(const Box& other) const
	{
		for (int k = 0; k < 3; ++k)
			if (low[k] > other.high[k] || other.low[k] > high[k]) return false;
		return true;
	}
};

Box boxOf(const test::TriangleSoup& triangles)
{
	Box box;
	for (const auto& triangle : triangles) box.add(triangle);
	return box;
}

// No triangle meets one of the other, and neither body lies within the other.
bool areApart(const test::TriangleSoup& a, const test::TriangleSoup& b)
{
	const Box boxA = boxOf(a), boxB = boxOf(b);
	if (!boxA.meets(boxB)) return true;
	std::vector<std::pair<std::size_t, Box>> near;  // of B's triangles
	for (std::size_t i = 0; i < b.size(); ++i)
		if (const Box box = boxOf({b[i]}); box.meets(boxA)) near.push_back({i, box});
	for (const auto& s : a)
	{
		const Box box = boxOf({s});
		if (!box.meets(boxB)) continue;
		for (const auto& [i, boxOfOther] : near)
			if (box.meets(boxOfOther) && !(test::triangleDistance(s, b[i]) > 0)) return false;
	}
	return std::fabs(test::windingNumber(a, b[0][0])) < 0.5 && std::fabs(test::windingNumber(b, a[0][0])) < 0.5;
}

// The first two bodies that are not apart, in words, or nothing.
std::string overlapOf(const SceneInfo& scene, const std::vector<ModelMesh>& meshes, const std::vector<Pose>& poses)
{
	std::vector<test::TriangleSoup> bodies;
	for (std::size_t i = 0; i < poses.size(); ++i)
		bodies.push_back(placedTriangles(meshes[scene.bodies[i].model], poses[i]));
	std::vector<Box> boxes;
	for (const test::TriangleSoup& body : bodies) boxes.push_back(boxOf(body));
	for (std::size_t a = 0; a < poses.size(); ++a)
		for (std::size_t b = a + 1; b < poses.size(); ++b)
			if (boxes[a].meets(boxes[b]) && !areApart(bodies[a], bodies[b]))
				return scene.bodies[a].name + " and " + scene.bodies[b].name;
	return "";
}

class Mechanisms : public testing::TestWithParam<std::string>
{
};

TEST_P(Mechanisms, StartApartRunAndTellEveryOutcome)
{
	const SceneDefinition& definition = definitionOf(GetParam());
	const SceneInfo& info = definition.info;
	const SceneSettings settings = settingsOf(info);
	const auto scene = makeScene(definition, settings);
	const SceneState start = scene->state();
	EXPECT_EQ(start.outcome.size(), info.outcome.size());
	std::vector<ModelMesh> meshes;
	for (std::size_t i = 0; i < info.models.size(); ++i)
		meshes.push_back(meshOf(info.models[i], settings.models[i], {kResolution, false}));
	std::vector<Pose> poses;
	for (const BodyState& body : start.bodies) poses.push_back(body.pose);
	EXPECT_EQ(overlapOf(info, meshes, poses), "");
	EXPECT_TRUE(start.inPlace);

	for (int step = 0; step < 10; ++step) scene->step();
	const SceneState end = scene->state();
	for (const BodyState& body : end.bodies) EXPECT_TRUE(isFinite(body.pose.position) && isFinite(body.velocity));
	for (const double value : end.outcome) EXPECT_TRUE(std::isfinite(value));
	EXPECT_TRUE(std::isfinite(end.energy()));
	const std::vector<std::string> brakes = {"linear_damping", "angular_damping", "rolling_friction",
											 "spinning_friction"};
	for (const SceneConstant& constant : scene->constants())
	{
		const bool isBrake = std::find(brakes.begin(), brakes.end(), constant.name) != brakes.end();
		EXPECT_TRUE(!isBrake || constant.value == 0) << constant.name;
	}
}

INSTANTIATE_TEST_SUITE_P(Scenes, Mechanisms, testing::ValuesIn(kScenes), clod::test::nameOfTest);

// A level that keeps the metric, but deviates by more than the play, would jam the joint.
TEST(MechanismLevels, AThresholdAboveThePlayLeavesAPendulumItsSwing)
{
	const SceneDefinition& definition = definitionOf("pendulum");
	SceneSettings settings = settingsOf(definition.info);
	settings.metric = ContactMetric::deviationShare(0.035);
	const auto scene = makeScene(definition, settings);
	for (int step = 0; step < 720; ++step) scene->step();
	EXPECT_GT(scene->state().outcome[0], 0.9);  // of its energy
}

// Points of the levels that jammed went on beside those of the finer ones, and held the pin from both sides: within ten
// steps the energy was four times what it began with.
TEST(MechanismLevels, WhatJammedHoldsNothingOnceLevelsAreFiner)
{
	const SceneDefinition& definition = definitionOf("double-pendulum");
	SceneSettings settings = settingsOf(definition.info, 0.5);
	settings.metric = ContactMetric::deviationShare(0.035);
	const auto scene = makeScene(definition, settings);
	const double start = scene->state().energy();
	for (int step = 0; step < 80; ++step)
	{
		scene->step();
		ASSERT_LT(scene->state().energy(), 1.001 * start) << step;
	}
}

// Between patches of two levels there are cracks. A corner in one is beneath faces, but over none: as nothing held it once it
// was a little above them, a spoon trembled for ever.
TEST(MechanismLevels, WhatLiesInACrackBetweenTwoLevelsRests)
{
	SceneDefinition definition = definitionOf("spoon-cup");
	definition.world = undamped(definition.world);
	const Vec3 place = definition.bodies[1].start.position;
	SceneSettings settings = settingsOf(definition.info, 0.05);
	settings.metric = ContactMetric::deviationShare(0.035);
	const double radius = double(settings.models[1]->asset().radius);
	test::Random random(4);
	for (int i = 0; i < 8; ++i)
	{
		definition.bodies[1].start.position = place + test::randomVector(random, 1e-5, 5e-5);
		const auto scene = makeScene(definition, settings);
		double fastest = 0;  // radii a second
		for (int step = 0; step < 40 * 240; ++step)
		{
			scene->step();
			if (step < 38 * 240) continue;
			fastest = std::max(fastest, speedOf(scene->state().bodies[1], radius));
		}
		EXPECT_LT(fastest, 0.01) << i;
	}
}

// Flat sides that are not quite flat on a coarse level: stacks of ten swayed for ever, at several radii a second.
TEST(MechanismLevels, StacksRestOnLevelsThatAreNotFlat)
{
	const SceneDefinition& definition = definitionOf("pile-stacks");
	SceneSettings settings = settingsOf(definition.info, 1);
	for (const ContactMetric& metric : {ContactMetric::deviationShare(0.02), ContactMetric::errorShare(0.02)})
	{
		settings.metric = metric;
		const auto scene = makeScene(definition, settings);
		double fastest = 0;  // radii a second
		for (int step = 0; step < 480; ++step)
		{
			scene->step();
			if (step < 420) continue;
			const SceneState state = scene->state();
			for (std::size_t i = 1; i < state.bodies.size(); ++i)
			{
				const double radius = double(settings.models[definition.info.bodies[i].model]->asset().radius);
				fastest = std::max(fastest, speedOf(state.bodies[i], radius));
			}
		}
		EXPECT_LT(fastest, 0.5);
	}
}

// With the settings for all worlds. Where the solver meets what a pair has one after the other they sway or fall.
TEST(MechanismLevels, TowersStandWithTheSettingsOfAllWorlds)
{
	const SceneDefinition& stacks = definitionOf("pile-stacks");
	const SceneSettings all = settingsOf(stacks.info, 1);
	for (const std::size_t by : {1, 3, 7})
	{
		SceneDefinition tower = stacks;
		const std::size_t model = 9, first = 81, height = 10;  // the stack of eights
		tower.info.models = {stacks.info.models[0], stacks.info.models[model]};
		tower.info.bodies.resize(1);
		tower.bodies.resize(1);
		tower.world.solverIterations = WorldConstants().solverIterations;
		tower.world.warmstartingFactor.reset();
		for (std::size_t i = 0; i < height; ++i)
		{
			const std::size_t from = first + by * i % height;
			tower.info.bodies.push_back({stacks.info.bodies[from].name, 1, false});
			tower.bodies.push_back(stacks.bodies[from]);
			tower.bodies.back().start.position += 4e-6 * Vec3{std::sin(5.0 * double(i)), 0, std::sin(7.0 * double(i))};
		}
		SceneSettings settings = all;
		settings.models = {all.models[0], all.models[model]};
		const auto scene = makeScene(tower, settings);
		for (int step = 0; step < 960; ++step) scene->step();
		const SceneState state = scene->state();
		const double radius = double(settings.models[1]->asset().radius);
		for (std::size_t i = 1; i <= height; ++i)
		{
			EXPECT_LT(speedOf(state.bodies[i], radius), 0.1) << by << ", " << i;
			EXPECT_LT(length(state.bodies[i].pose.position - tower.bodies[i].start.position), 0.1 * radius) << by << ", " << i;
		}
	}
}

// A double pendulum on its way, in steps of 1/60 s; angles from hanging.
struct Swing
{
	double upper, lower, upperRate, lowerRate;
};

std::vector<SceneState> swingOn(const Swing& from, int steps)
{
	const SceneDefinition& definition = definitionOf("double-pendulum");
	static const SceneSettings settings = [&]
	{
		SceneSettings s = settingsOf(definition.info);
		s.dt = 1.0 / 60;
		s.passes = 3;
		s.parts = 8;
		return s;
	}();
	const auto scene = makeScene(definition, settings);
	SceneState state = scene->state();
	const Pose upper = turnedAbout({0, 0, 1}, from.upper);
	const Vec3 pin = toTransform(upper) * Vec3{0, -ARM_LENGTH, ARM_TO_ARM};
	const Pose lower = turnedAbout({0, 0, 1}, from.lower, pin);
	const auto centerOf = [&](const Pose& pose, std::size_t model)
	{
		const double(&c)[3] = settings.models[model]->asset().meshFromBody;
		return toTransform(pose) * Vec3{c[0], c[1], c[2]};
	};
	const Vec3 upperTurning{0, 0, from.upperRate}, lowerTurning{0, 0, from.lowerRate};
	state.bodies[1] = {upper, cross(upperTurning, centerOf(upper, 1)), upperTurning};
	state.bodies[2] = {lower, cross(upperTurning, pin) + cross(lowerTurning, centerOf(lower, 2) - pin), lowerTurning};
	scene->place(state);
	std::vector<SceneState> states = {scene->state()};
	for (int step = 0; step < steps; ++step)
	{
		scene->step();
		states.push_back(scene->state());
	}
	return states;
}

// Pins in their holes threw the arms on: a tenth more energy after a step, begun whole or divided. In the first steps the
// pins find their places.
TEST(MechanismSwings, ADoublePendulumGainsNoEnergyInAStep)
{
	for (const Swing& from : {Swing{-2.205, -0.363, -10.04, -18.66}, Swing{2.827, -1.641, 11.01, 9.69}})
	{
		const std::vector<SceneState> states = swingOn(from, 12), again = swingOn(from, 12);
		for (std::size_t step = 5; step < states.size(); ++step)
			EXPECT_LT(states[step].energy() - states[step - 1].energy(), 0.01 * states[step].kinetic) << step;
		EXPECT_EQ(states.back().energy(), again.back().energy());
	}
}

// A tooth's corner that comes round the ridge between two faces of a flank leaves the plane of the first: held above it, the
// rack was thrown half the backlash off its flank.
TEST(MechanismRack, MeshesFromToothToTooth)
{
	const SceneDefinition& definition = definitionOf("rack");
	const auto scene = makeScene(definition, settingsOf(definition.info, 1));
	scene->step();  // from the middle of its play to a flank
	double last = scene->state().outcome[0];
	for (int step = 0; step < 45; ++step)
	{
		scene->step();
		const SceneState state = scene->state();
		EXPECT_LT(std::fabs(state.outcome[0] - last), 0.1 * BACKLASH) << step;
		last = state.outcome[0];
		// Flanks face along y, lands of tips and roots along x.
		for (const ScenePoint& point : state.points)
		{
			EXPECT_TRUE(point.impulse <= 0 || std::fabs(point.normal.y) > 0.75) << step;
		}
	}
}

// Links of 160 triangles touch corner in corner, where four pairs of edges cross: each step the motion predicted met
// one of them, and by the thirtieth the links were through each other.
TEST(MechanismChain, OfFewTrianglesHolds)
{
	const SceneDefinition& definition = definitionOf("chain");
	const auto scene = makeScene(definition, settingsOf(definition.info, 0.1));
	for (int step = 0; step < 120; ++step)
	{
		scene->step();
		EXPECT_LT(scene->state().outcome[0], LINK_WIRE) << step;
		EXPECT_GT(scene->state().outcome[1], -0.1 * LINK_WIRE) << step;
	}
}

// Where contacts are found again for the motion as solved, too: they led to one another by turns, and where the corners
// overlap all four pairs of edges may cross just beyond their ends.
TEST(MechanismChain, OfFewTrianglesHoldsInPasses)
{
	for (const int rate : {52, 60, 70})
	{
		const auto scene = chainInPasses(0.1, ContactMetric::deviationShare(0.005), rate);
		for (int step = 0; step < 40; ++step)
		{
			scene->step();
			ASSERT_LT(scene->state().outcome[0], LINK_WIRE) << rate << ", " << step;
		}
	}
}

// Links that whip round meet along edges that are almost parallel, whose crossings run along them within the step.
TEST(MechanismChain, OfAllTrianglesHoldsInPasses)
{
	for (const int rate : {56, 60, 64})
	{
		const auto scene = chainInPasses(1, ContactMetric::errorShare(0.005), rate);
		for (int step = 0; step < 20; ++step)
		{
			scene->step();
			EXPECT_GT(scene->state().outcome[1], -0.01 * LINK_WIRE) << rate << ", " << step;
		}
	}
}

// Dry stones carry each other: nothing gives by more than half of a joint's millimetre.
TEST(MechanismArch, Stands)
{
	const SceneDefinition& definition = definitionOf("arch");
	const auto scene = makeScene(definition, settingsOf(definition.info));
	for (int step = 0; step < 60; ++step) scene->step();
	const std::vector<double> outcome = scene->state().outcome;
	EXPECT_LT(outcome[0], 0.0005) << "sliding";
	EXPECT_GT(outcome[2], 0.0005) << "joint";
	EXPECT_LT(std::fabs(outcome[3]), 0.0005) << "drop of the crown";
}

// What is left of a swing never grows by more than a thousandth of what it began with, and in the end hardly any is left.
// Means over several steps: an integrator moves energy to and fro within each.
TEST(MechanismSwings, SmallOnesNeitherGrowNorStay)
{
	constexpr std::size_t kWindow = 20;
	const std::vector<std::pair<std::string, double>> swings = {{"rocking-torus", 60}, {"spinning-plate", 240}};
	for (const auto& [name, rate] : swings)
	{
		const SceneDefinition& definition = definitionOf(name);
		SceneSettings settings = settingsOf(definition.info);
		settings.dt = 1 / rate;
		const auto scene = makeScene(definition, settings);
		std::vector<double> energies;
		double least = HUGE_VAL;
		for (int step = 0; step < 5 * int(rate); ++step)
		{
			scene->step();
			const SceneState state = scene->state();
			energies.push_back(state.energy());
			least = std::min(least, state.potential);
		}
		double lowest = HUGE_VAL, rise = 0, left = 0;
		for (std::size_t i = 0; i + kWindow <= energies.size(); ++i)
		{
			left = std::accumulate(energies.begin() + i, energies.begin() + i + kWindow, 0.0) / kWindow - least;
			lowest = std::min(lowest, left);
			rise = std::max(rise, left - lowest);
		}
		const double first = energies.front() - least;
		EXPECT_LT(rise, 1e-3 * first) << name;
		EXPECT_LT(left, 0.02 * first) << name;
	}
}

// A body moved by its own play into its neighbour is seen.
TEST(MechanismChecks, SeePlantedOverlaps)
{
	const SceneInfo& info = definitionOf("press").info;
	std::vector<ModelMesh> meshes;
	for (const SceneModel& model : info.models) meshes.push_back(*makeModel(model.name));
	std::vector<Pose> poses;
	for (const BodyDefinition& body : definitionOf("press").bodies) poses.push_back(body.start);
	poses[1].position.y = -0.010;
	EXPECT_EQ(overlapOf(info, meshes, poses), "");
	poses[1].position.x += 0.00003;
	EXPECT_NE(overlapOf(info, meshes, poses), "");
}

}  // namespace
