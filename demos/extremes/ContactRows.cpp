// SPDX-License-Identifier: Zlib
// C: faults that contact points once had, each the smallest scene that showed it (by its number in the list they were
// collected in).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "demos/extremes/RowParts.h"
#include "demos/models/Mechanisms.h"

namespace clod::demo
{
namespace
{
constexpr double kResolution = 0.25;

// A scene of `clod-bench run` to its end, in seconds; the look gets its outcome.
void watchScene(Stage& stage, const std::function<void(const std::vector<double>&)>& look, double share = 1)
{
	const SceneInfo& info = stage.scene().info;
	stage.watch(share * info.steps * info.dt,
				[&]
				{
					look(stage.state().outcome);
					return true;
				});
}

Readings armOnPin(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting, "pendulum", kResolution, {});
	double off = 0, left = 1, most = 1;
	watchScene(stage,
			   [&](const std::vector<double>& outcome)
			   {
				   off = std::max(off, outcome[2]);
				   left = outcome[0];
				   most = std::max(most, left);
			   });
	return {amount(off / PIN_PLAY), differenceFrom(1, left), amount(most - 1)};
}

Readings crossedWedges(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting, "wedges", kResolution,
				{"wedge20", "wedge30", "wedge40", "wedge50", "wedge60", "wedge70", "wedge80", "wedge90"});
	std::vector<double> gaps;
	watchScene(stage, [&](const std::vector<double>& outcome) { gaps = outcome; });
	double worst = 0;
	for (const double gap : gaps) worst = std::max(worst, std::fabs(gap) / WEDGE_HEIGHT);
	return {amount(worst)};
}

Readings rackOnPinions(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting, "rack", 1, {});
	const double start = stage.energy();
	double slip = 0, end = start;
	watchScene(stage,
			   [&](const std::vector<double>& outcome)
			   {
				   slip = std::max({slip, std::fabs(outcome[0]), std::fabs(outcome[1])});
				   end = stage.energy();
			   });
	return {amount(slip / (BACKLASH / 2)), relativeTo(start, end)};
}

// Edge over parallel edge, exactly; kept upright and on its line, it can only rest or fall through.
Readings parallelEdges(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting);
	const double scale = 1 / WEDGE_HEIGHT;
	const Solid wedge = partSolid("wedge" + std::to_string(int(setting.parameter)), 80, scale, true);
	stage.add(wedge, fixedAt({}));
	BodyDefinition upper = movingAt(1, turnedAbout({1, 0, 0}, kPi, {0, 0.05, 0}));
	upper.moves = {0, 1, 0};
	upper.turns = {0, 0, 0};
	const std::size_t body = stage.add(wedge, upper);
	stage.seconds(1);
	return {amount(std::fabs(stage.place(body).y))};
}

// A lid that comes down at 1 m/s on a cube on a floor, and stops with 20 % of it squeezed away.
Readings crusher(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting);
	stage.setFriction(0.36);
	stage.add(boxSolid({10, 1, 10}), fixedAt({{0, -0.5, 0}}));
	const std::size_t cube = stage.add(boxSolid({1, 1, 1}), movingAt(1, {{0, 0.501, 0}}));
	BodyDefinition lid = fixedAt({});
	lid.course = [](double time) { return Pose{{0, 1.5 + std::max(-0.2, 0.1 - time), 0}}; };
	stage.add(boxSolid({4, 1, 4}), lid);
	double fastest = 0, sunk = 0;
	stage.watch(2,
				[&]
				{
					fastest = std::max(fastest, length(stage.velocity(cube)));
					sunk = std::max({sunk, 0.4 - stage.place(cube).y, stage.place(cube).y - 0.5});
					return true;
				});
	return {amount(sunk), amount(fastest)};
}

// Beside where it comes to rest from above.
Readings sunkTorus(Workshop& workshop, const Setting& setting)
{
	const double scale = 1 / DISH_RADIUS, ring = 0.35, tube = 0.12;
	const double rest = -std::sqrt((1 - tube) * (1 - tube) - ring * ring);
	double fastest = 0;
	const auto heightFrom = [&](double above)
	{
		Stage stage(workshop, setting);
		stage.setFriction(0.36);
		stage.add(partSolid("dish", 3600, scale), fixedAt({}));
		const std::size_t torus = stage.add(torusSolid(ring, tube, 960), movingAt(1, {{0, rest + above, 0}}));
		fastest = 0;
		stage.watch(2,
					[&]
					{
						fastest = std::max(fastest, length(stage.velocity(torus)));
						return true;
					});
		return stage.place(torus).y;
	};
	const double fromAbove = heightFrom(0.01), fromBelow = heightFrom(-0.04);
	return {differenceFrom(fromAbove, fromBelow), amount(fastest)};
}

// Only the deepest of the full meshes is asked for.
Readings pileUp(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting, "drop", kResolution, {"floor"});
	const double radius = 0.02;
	double deepest = 0;
	stage.watch(
		1.5,
		[&]
		{
			for (const BodyPair& pair : stage.state().pairs) deepest = std::max(deepest, stage.deepest(pair.a, pair.b));
			return true;
		},
		8);
	return {amount(deepest / radius)};
}

Readings swingOf(Workshop& workshop, const Setting& setting, const std::string& scene)
{
	Stage stage(workshop, setting, scene, kResolution, {});
	// What it has over its rest, in means of half a second, as an integrator moves energy to and fro within steps.
	const std::size_t window = std::size_t(setting.rate / 2);
	std::vector<double> energies;
	double least = HUGE_VAL;
	stage.watch(10,
				[&]
				{
					energies.push_back(stage.energy());
					least = std::min(least, stage.state().potential);
					return true;
				});
	double lowest = HUGE_VAL, first = 0, gained = 0;
	for (std::size_t i = 0; i + window <= energies.size(); i += window)
	{
		const double left =
			std::accumulate(energies.begin() + long(i), energies.begin() + long(i + window), 0.0) / double(window) -
			least;
		if (i == 0) first = left;
		lowest = std::min(lowest, left);
		gained = std::max(gained, left - lowest);
	}
	return {amount(gained / first)};
}
Readings ringOnPegGrows(Workshop& workshop, const Setting& setting)
{
	return swingOf(workshop, setting, "ring-on-peg");
}
Readings torusInDishGrows(Workshop& workshop, const Setting& setting)
{
	return swingOf(workshop, setting, "rocking-torus");
}

// Once it has settled, five seconds to half a minute after it was stirred; the scene's friction and damping.
Readings spoonCreeps(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting, "spoon-cup", 0.05, {});
	stage.seconds(setting.isQuick ? 10 : 40);
	const Vec3 start = stage.place(1);
	const double minutes = setting.isQuick ? 0.05 : 1;
	stage.seconds(60 * minutes);
	const double radius = double(stage.hierarchy(1).asset().radius);
	return {amount(length(stage.place(1) - start) / radius / minutes)};
}

// Facets brake it: it need not keep up with the smooth helix motion, but keep to the thread, and seat.
Readings nutOnBolt(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting, "bolt-gravity", kResolution, {});
	double offAxis = 0, offThread = 0, height = 0;
	watchScene(stage,
			   [&](const std::vector<double>& outcome)
			   {
				   height = outcome[0];
				   offThread = std::max(offThread, std::fabs(outcome[2]));
				   offAxis = std::max(offAxis, outcome[3]);
			   });
	const double seat = BOLT_HEAD_HEIGHT + NUT_HEIGHT / 2;
	return {amount(std::fabs(height - seat) / THREAD_LEAD), amount(offThread), amount(offAxis / THREAD_PLAY)};
}
}  // namespace

std::vector<Row> contactRows()
{
	std::vector<Row> rows;
	rows.push_back({"C1",
					"an arm swings on a flanged pin, frictionless",
					"keeps to the pin and most of its energy",
					"",
					{},
					kRates,
					{{"pin off its axis", "of the play", {1.5}},
					 {"energy left", "share", {0.2, 1}},
					 {"energy gained", "share", {0.02}}},
					armOnPin,
					{},
					true});
	rows.push_back({"C2",
					"wedges of 20 to 90 degrees, edge on edge, crossed",
					"none falls through",
					"",
					{},
					kRates,
					{{"edges apart", "heights", {0.02}}},
					crossedWedges});
	rows.push_back({"C3",
					"a rack rises and falls between pinions",
					"meshes; keeps its energy",
					"",
					{},
					kRates,
					{{"slip", "of half the backlash", {1.5}}, {"energy", "share", {0.05, 1}}},
					rackOnPinions,
					{{"at 1/60 s several teeth pass in a step: they slip", largeSteps, "slip"}},
					true});
	rows.push_back({"C5",
					"an edge exactly over a parallel edge",
					"rests on it",
					"",
					{{30, "30 degrees"}, {90, "90 degrees"}},
					kRates,
					{{"edges apart", "m", {0.01}}},
					parallelEdges});
	rows.push_back({"C6a",
					"a lid squeezes a cube on a floor by 20 %",
					"it stays between them",
					"",
					{},
					kRates,
					{{"out of its room", "m", {0.1, 1}}, {"speed", "m/s", {3, 1}}},
					crusher});
	rows.push_back({"C6b",
					"a torus starts sunk into a bowl",
					"comes up",
					"",
					{},
					kRates,
					{{"off its place", "m", {1e-3}}, {"speed", "m/s", {3, 1}}},
					sunkTorus,
					{},
					true});
	rows.push_back({"C9",
					"three bodies fall on each other: deepest overlap",
					"no worse than Bullet's",
					"",
					{},
					{1920, 240},
					{{"overlap", "R", {0.02, 1}}},
					pileUp,
					{},
					true});
	rows.push_back({"C11a",
					"a ring swings on a peg for 10 s",
					"never more energy: 0.1 % of the amplitude at most",
					"",
					{},
					kRates,
					{{"energy gained", "share", {2e-3, 1}}},
					ringOnPegGrows,
					{{"at 1/60 s what has facets gains up to half a per cent", largeSteps, ""}}});
	rows.push_back({"C11b",
					"a torus rocks in a dish for 10 s, frictionless",
					"never more energy: 0.1 % of the amplitude at most",
					"",
					{},
					kRates,
					{{"energy gained", "share", {2e-3, 1}}},
					torusInDishGrows,
					{{"coarse levels have coarse facets, which give a small swing up to 3 % of what a large one had",
					  coarseLevels, ""}},
					true});
	rows.push_back({"C12",
					"a spoon at rest in a cup, never asleep",
					"creeps 2e-5 radii a minute at most",
					"",
					{},
					kRates,
					{{"creep", "R/minute", {2e-5}}},
					spoonCreeps,
					{},
					true});
	rows.push_back(
		{"C13",
		 "a nut runs down a bolt, frictionless",
		 "keeps to the thread and seats",
		 "",
		 {},
		 {960, 240, 60},
		 {{"end off its seat", "leads", {0.05}},
		  {"off the thread", "degrees", {15}},
		  {"off the axis", "of the play", {1.5}}},
		 nutOnBolt,
		 {{"at 1/60 s it leaves the thread", largeSteps, ""}},
		 true});
	return rows;
}
}  // namespace clod::demo
