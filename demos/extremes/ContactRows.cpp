// SPDX-License-Identifier: Zlib
// C: faults that contact points once had, each the smallest scene that showed it (by its number in the list they were
// collected in). J: bodies joined by Bullet's constraints that touch each other too.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "demos/extremes/RowParts.h"
#include "demos/models/Mechanisms.h"

namespace clod::demo
{
namespace
{
const std::vector<double> kRates = {240, 60};
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
	// The largest of two seconds, once it has been let go and has slipped into its swing, and of the last two.
	const double settled = 1, window = 2, time = 10;
	double early = 0, late = 0;
	stage.watch(time,
				[&]
				{
					const double now = stage.state().time, size = std::fabs(stage.state().outcome[0]);
					if (now > settled && now <= settled + window) early = std::max(early, size);
					if (now > time - window) late = std::max(late, size);
					return true;
				});
	return {amount(std::max(0.0, late / early - 1))};
}
Readings ringOnPegGrows(Workshop& workshop, const Setting& setting)
{
	return swingOf(workshop, setting, "ring-on-peg");
}
Readings torusInDishGrows(Workshop& workshop, const Setting& setting)
{
	return swingOf(workshop, setting, "rocking-torus");
}

// Five seconds after it was stirred; the scene's friction and damping.
Readings spoonCreeps(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting, "spoon-cup", 0.05, {});
	stage.seconds(setting.isQuick ? 6 : 10);
	const Vec3 start = stage.place(1);
	const double minutes = setting.isQuick ? 0.05 : 0.5;
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

// --- Bodies joined by Bullet's constraints -------------------------------------------------------------------------

// How far the two ends of a joint are apart, between a body and an earlier one or the world.
double jointGap(Stage& stage, std::size_t body, const std::vector<Pose>& starts)
{
	double gap = 0;
	for (const BodyJoint& joint : stage.scene().bodies[body].joints)
	{
		const auto now = [&](std::size_t one)
		{ return stage.pose(one) * (inverse(toTransform(starts[one])) * joint.point); };
		gap = std::max(gap, length(now(body) - (joint.partner ? now(*joint.partner) : joint.point)));
	}
	return gap;
}
std::vector<Pose> startsOf(Stage& stage)
{
	std::vector<Pose> starts;
	for (const BodyDefinition& body : stage.scene().bodies) starts.push_back(body.start);
	return starts;
}

struct JointedRun
{
	double gap = 0, overlap = 0, gained = 0, end = 0;
};
// Overlaps of all pairs of boxes that are near, energy over what there was, and the speed at the end.
JointedRun watchJoints(Stage& stage, double time, double energyScale)
{
	JointedRun run;
	const std::vector<Pose> starts = startsOf(stage);
	const double start = stage.energy();
	stage.watch(
		time,
		[&]
		{
			for (std::size_t body = 0; body < starts.size(); ++body)
				run.gap = std::max(run.gap, jointGap(stage, body, starts));
			for (const BodyPair& pair : stage.state().pairs)
				run.overlap = std::max(run.overlap, stage.deepest(pair.a, pair.b));
			run.gained = std::max(run.gained, (stage.energy() - start) / energyScale);
			return true;
		},
		4);
	for (std::size_t body = 0; body < starts.size(); ++body) run.end = std::max(run.end, length(stage.velocity(body)));
	return run;
}
Readings readingsOf(const JointedRun& run)
{
	return {amount(run.gap), amount(run.overlap), amount(std::max(0.0, run.gained)), amount(run.end)};
}
// Of several starts, as what tumbles is a matter of chance.
JointedRun meanOf(const std::vector<JointedRun>& runs)
{
	JointedRun mean;
	for (const JointedRun& run : runs)
	{
		const double share = 1.0 / double(runs.size());
		mean.gap += share * run.gap;
		mean.overlap += share * run.overlap;
		mean.gained = std::max(mean.gained, run.gained);
		mean.end += share * run.end;
	}
	return mean;
}

// Ten bars hang from the world, each held by a ball joint at the end of the one before and touching it as they fold.
JointedRun foldedChain(Workshop& workshop, const Setting& setting, double push)
{
	Stage stage(workshop, setting);
	stage.setFriction(0.36);
	stage.add(boxSolid({10, 1, 10}), fixedAt({{0, -0.5, 0}}));
	const double length = 0.4, width = 0.1, pitch = length + 0.02;
	const int count = 10;
	double energy = 0;
	for (int i = 0; i < count; ++i)
	{
		BodyDefinition bar = movingAt(1, {{0.0, 0.25 + (i + 0.5) * pitch, 0}});
		if (i > 0) bar.joints = {{BodyJoint::Kind::ball, {0, 0.25 + i * pitch, 0}, {0, 1, 0}, std::size_t(i)}};
		if (i == count / 2) bar.velocity = {1, 0, push};
		stage.add(boxSolid({width, length, width}), bar);
		energy += kGravity * bar.start.position.y;
	}
	return watchJoints(stage, setting.isQuick ? 1 : 4, energy);
}
Readings foldedChains(Workshop& workshop, const Setting& setting)
{
	std::vector<JointedRun> runs;
	for (const double push : {0.3, 0.35, 0.4, 0.45}) runs.push_back(foldedChain(workshop, setting, push));
	Readings readings = readingsOf(meanOf(runs));
	readings.pop_back();  // they still tumble
	return readings;
}

// A door on its hinge is thrown against its stop and back; the frame is one body with it by the hinge.
Readings door(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting);
	stage.setFriction(0.36);
	const std::size_t frame = stage.add(boxSolid({0.1, 2, 0.3}), fixedAt({}));
	stage.add(boxSolid({0.1, 2, 0.3}), fixedAt({{1.15, 0, -0.2}}));
	BodyDefinition leaf = movingAt(10, {{0.565, 0, 0}}, {}, {});
	leaf.joints = {{BodyJoint::Kind::hinge, {0.055, 0, 0}, {0, 1, 0}, frame}};
	leaf.turning = {0, 3, 0};
	leaf.velocity = cross(leaf.turning, Vec3{0.51, 0, 0});
	stage.add(boxSolid({1.0, 1.9, 0.06}), leaf);
	Readings readings = readingsOf(watchJoints(stage, setting.isQuick ? 1 : 4, 0.5 * 10 * 9 / 3.0));
	readings.pop_back();  // its hinge has no friction
	return readings;
}

// A cart on four wheels (hinges) that stand on the floor under a load of a hundred times their weight.
Readings cart(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting);
	stage.setFriction(0.8);
	stage.add(boxSolid({40, 1, 10}), fixedAt({{0, -0.5, 0}}));
	const double radius = 0.3, height = 0.301;
	const std::size_t deck =
		stage.add(boxSolid({2, 0.2, 0.8}), movingAt(setting.parameter, {{0, height + 0.05, 0}}, {2, 0, 0}));
	for (const double x : {-0.8, 0.8})
		for (const double z : {-0.55, 0.55})
		{
			Pose pose = turnedAbout({1, 0, 0}, kPi / 2, {x, height, z});
			BodyDefinition wheel = movingAt(1, pose, {2, 0, 0}, {0, 0, -2 / radius});
			wheel.joints = {{BodyJoint::Kind::hinge, {x, height, z}, {0, 0, 1}, deck}};
			stage.add(cylinderSolid(radius, 0.2, 96), wheel);
		}
	const JointedRun run = watchJoints(stage, setting.isQuick ? 1 : 3, (setting.parameter + 4) * kGravity * height);
	return {amount(run.gap), amount(run.overlap), amount(std::max(0.0, run.gained)),
			relativeTo(2, stage.velocity(deck).x)};
}

// A block glued to another of a hundredth of its weight stands on that one.
Readings glued(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting);
	stage.setFriction(0.36);
	stage.add(boxSolid({10, 1, 10}), fixedAt({{0, -0.5, 0}}));
	const std::size_t light = stage.add(boxSolid({1, 1, 1}), movingAt(1, {{0, 0.502, 0}}));
	BodyDefinition heavy = movingAt(setting.parameter, {{0.2, 1.504, 0}});
	heavy.joints = {{BodyJoint::Kind::fixed, {0.1, 1.003, 0}, {0, 1, 0}, light}};
	stage.add(boxSolid({1, 1, 1}), heavy);
	return readingsOf(watchJoints(stage, 3, (setting.parameter + 1) * kGravity * 1.5));
}

std::vector<Quantity> jointQuantities(const std::optional<Quantity>& last = {})
{
	std::vector<Quantity> quantities = {
		{"joint open", "m", {0.005, 2}}, {"overlap", "m", {0.005, 2}}, {"energy gained", "share", {0.01, 1}}};
	if (last) quantities.push_back(*last);
	return quantities;
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
					{{"a deviation above the play lets the pin out", coarseLevels, "pin off its axis"}},
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
					"never higher",
					"",
					{},
					kRates,
					{{"amplitude gained", "share", {0.01, 1}}},
					ringOnPegGrows});
	rows.push_back({"C11b",
					"a torus rocks in a dish for 10 s, frictionless",
					"never higher",
					"",
					{},
					kRates,
					{{"amplitude gained", "share", {0.01, 1}}},
					torusInDishGrows,
					{{"at 1/60 s coarse facets keep it going",
					  [](const Setting& s) { return largeSteps(s) && coarseLevels(s); }, ""}},
					true});
	rows.push_back({"C12",
					"a spoon at rest in a cup, never asleep",
					"creeps 1e-4 radii a minute at most",
					"",
					{},
					kRates,
					{{"creep", "R/minute", {1e-4}}},
					spoonCreeps,
					{{"at 1/60 s and on levels coarser than exact it can creep by some hundredths of a radius a minute",
					  [](const Setting& s) { return largeSteps(s) || s.collider != Collider::exact; }, ""}},
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
		 {{"at 1/60 s it leaves the thread", largeSteps, ""}, {"a deviation above the play jams it", coarseLevels, ""}},
		 true});
	rows.push_back({"J1",
					"ten bars in ball joints fold onto each other and a floor",
					"at most twice Bullet's",
					"",
					{},
					kRates,
					jointQuantities(),
					foldedChains,
					{},
					true});
	rows.push_back({"J2",
					"a door on a hinge swings against its stop",
					"at most twice Bullet's",
					"",
					{},
					kRates,
					jointQuantities(),
					door});
	rows.push_back({"J3",
					"a cart rolls on four wheels on hinges",
					"keeps its speed of 2 m/s",
					"",
					{{4, "1:1"}, {100, "25:1"}, {400, "100:1"}},
					kRates,
					jointQuantities(Quantity{"speed", "share", {0.05, 1}}),
					cart,
					{{"wheels of facets roll as polygons, as in A5", anyRun, "speed"}}});
	rows.push_back({"J4",
					"a block fixed to a lighter one stands on it",
					"at most twice Bullet's",
					"",
					{{1, "1:1"}, {100, "100:1"}},
					kRates,
					jointQuantities(Quantity{"speed at the end", "m/s", {0.1, 2}}),
					glued,
					{{"at 1/60 s a joint that carries a hundred times the weight of what it stands on tears open",
					  [](const Setting& s) { return largeSteps(s) && s.parameter >= 100; }, ""}}});
	return rows;
}
}  // namespace clod::demo
