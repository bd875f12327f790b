// SPDX-License-Identifier: Zlib
// J: bodies joined by Bullet's constraints that touch each other too.
#include <algorithm>
#include <optional>

#include "demos/extremes/RowParts.h"

namespace clod::demo
{
namespace
{
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

std::vector<Row> jointRows()
{
	std::vector<Row> rows;
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
					glued});
	return rows;
}
}  // namespace clod::demo
