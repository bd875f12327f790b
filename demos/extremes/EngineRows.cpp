// SPDX-License-Identifier: Zlib
// E: extremes of the engine. Sizes, speeds, masses, steps, distances and overlaps at which a body still rests, stands
// or parts.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "demos/extremes/RowParts.h"

namespace clod::demo
{
namespace
{
const Vec3 kFloorSize = {10, 1, 10};

std::vector<Case> percent(const std::vector<double>& shares)
{
	std::vector<Case> cases;
	for (const double share : shares) cases.push_back({share, fmt::format("{:g} %", 100 * share)});
	return cases;
}

// A cube of a metre (or of a size) let go a little over the floor's middle.
struct CubeOnFloor
{
	std::size_t floor, cube;
	double rest;  // the height of its centre, in its sizes
	CubeOnFloor(Stage& stage, double size, double mass, double drop = 0.05)
	{
		floor = stage.add(boxSolid(size * kFloorSize), fixedAt({{0, -size * kHalfFloor, 0}}));
		cube =
			stage.add(boxSolid({size, size, size}), movingAt(mass, {{0, size * (0.5 + drop) + 2 * stage.margin, 0}}));
		rest = 0.5 + stage.restGap(floor, cube) / size;
	}
};

double aside(const Vec3& place)
{
	return std::hypot(place.x, place.z);
}

// All lengths, the gravity and Bullet's unit follow the size.
Readings scaledWorld(Workshop& workshop, const Setting& setting)
{
	const double size = setting.parameter;
	Stage stage(workshop, setting);
	stage.scene().info.worldScale = 1 / size;
	stage.setGravity({0, -kGravity * size, 0});
	stage.setFriction(0.36);
	const CubeOnFloor scene(stage, size, 1);
	stage.seconds(setting.isQuick ? 2 : 10);
	return {differenceFrom(scene.rest, stage.place(scene.cube).y / size),
			amount(aside(stage.place(scene.cube)) / size)};
}

Readings unscaledWorld(Workshop& workshop, const Setting& setting)
{
	const double size = setting.parameter;
	Stage stage(workshop, setting);
	stage.setFriction(0.36);
	const CubeOnFloor scene(stage, size, 1);
	stage.seconds(2);
	return {differenceFrom(scene.rest, stage.place(scene.cube).y / size)};
}

Readings margins(Workshop& workshop, const Setting& setting)
{
	if (setting.collider == Collider::primitive) throw NotApplicable("margins of a box are inside of it");
	Stage stage(workshop, setting);
	stage.margin = setting.parameter;
	stage.setFriction(0.36);
	const CubeOnFloor scene(stage, 1, 1);
	stage.seconds(2);
	return {differenceFrom(scene.rest, stage.place(scene.cube).y)};
}

Readings heavyOnLight(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting);
	stage.setFriction(0.36);
	const CubeOnFloor light(stage, 1, 1, 0.001);
	const double mass = setting.parameter, drop = 0.002 + stage.restGap(light.cube, light.cube);
	const std::size_t heavy = stage.add(boxSolid({1, 1, 1}), movingAt(mass, {{0, 1.5 + drop, 0}}));
	const double start = stage.energy(), scale = (mass + 1) * kGravity;
	double deepest = 0, highest = start;
	stage.watch(3,
				[&]
				{
					deepest = std::max({deepest, 0.5 - stage.place(light.cube).y,
										1 - (stage.place(heavy).y - stage.place(light.cube).y)});
					highest = std::max(highest, stage.energy());
					return true;
				});
	return {amount(deepest), amount((highest - start) / scale)};
}

Readings anyMass(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting);
	stage.setFriction(0.36);
	const CubeOnFloor scene(stage, 1, setting.parameter);
	stage.seconds(2);
	return {differenceFrom(scene.rest, stage.place(scene.cube).y)};
}

// Balls of 5 cm at a wall 2 cm thick.
Readings thinWall(Workshop& workshop, const Setting& setting)
{
	const double speed = setting.parameter;
	const int shots = setting.isQuick ? 4 : 20;
	int through = 0;
	for (int i = 0; i < shots; ++i)
	{
		Stage stage(workshop, setting);
		stage.setGravity({});
		stage.add(boxSolid({0.02, 100, 100}), fixedAt({}));  // nobody goes round it
		const double run = 1 + 0.037 * i;
		const std::size_t ball = stage.add(
			ballSolid(0.05, 108), movingAt(1, {{-run, 0.03 * i, 0.02 * i}}, {speed, 0, 0}, {double(i), 2.0 * i, 3}));
		stage.steps(int((run + 1) / speed * setting.rate) + 10);
		if (stage.place(ball).x > 0) ++through;
	}
	return {amount(double(through) / shots)};
}

// Cubes of a metre a millimetre apart, the lowest over the floor by as much.
struct Tower
{
	std::vector<std::size_t> cubes;
	double rest;  // the height of the highest one's centre
	double drop = 0;
	Tower(Stage& stage, int count, double x, double gap)
	{
		const std::size_t floor = stage.add(boxSolid(kFloorSize), fixedAt({{x, -kHalfFloor, 0}}));
		rest = -0.5;
		for (int i = 0; i < count; ++i)
		{
			cubes.push_back(stage.add(boxSolid({1, 1, 1}), movingAt(1, {{x, 0.5 + i + (i + 1) * gap, 0}})));
			rest += 1 + stage.restGap(i == 0 ? floor : cubes.back(), cubes.back());
		}
	}
};

Readings tower(Workshop& workshop, const Setting& setting, int count, double time)
{
	Stage stage(workshop, setting);
	stage.setFriction(0.36);
	const Tower tower(stage, count, 0, 0.001);
	stage.seconds(time);
	const std::size_t top = tower.cubes.back();
	const Vec3 place = stage.place(top);
	return {differenceFrom(tower.rest, place.y), amount(aside(place)), amount(length(stage.velocity(top)))};
}

Readings anyStep(Workshop& workshop, const Setting& setting)
{
	return tower(workshop, setting, 5, 2);
}

Readings towers(Workshop& workshop, const Setting& setting)
{
	return tower(workshop, setting, int(setting.parameter), setting.isQuick ? 2 : 5);
}

// The same tower near the origin and far away: places of its cubes over its own foot.
Readings farAway(Workshop& workshop, const Setting& setting)
{
	const auto heights = [&](double x)
	{
		Stage stage(workshop, setting);
		stage.setFriction(0.36);
		const Tower tower(stage, 5, x, 0.001);
		stage.seconds(2);
		std::vector<Vec3> places;
		for (const std::size_t cube : tower.cubes) places.push_back(stage.place(cube) - Vec3{x, 0, 0});
		return places;
	};
	const std::vector<Vec3> near = heights(0), there = heights(setting.parameter);
	double farthest = 0;
	for (std::size_t i = 0; i < near.size(); ++i) farthest = std::max(farthest, length(there[i] - near[i]));
	const double allowed = 0.001 + 4 * setting.parameter * std::pow(2.0, -23);
	return {amount(farthest / allowed)};
}

// Equal cubes that overlap by a share of their size; what they are apart is told along the axis they parted by.
Readings overlapping(Workshop& workshop, const Setting& setting, const Vec3& offset)
{
	Stage stage(workshop, setting);
	stage.setGravity({});
	const std::size_t first = stage.add(boxSolid({1, 1, 1}), movingAt(1, {}));
	const std::size_t second = stage.add(boxSolid({1, 1, 1}), movingAt(1, {offset}));
	const auto apart = [&]
	{
		const Vec3 way = stage.place(second) - stage.place(first);
		return std::max({std::fabs(way.x), std::fabs(way.y), std::fabs(way.z)});
	};
	double before = apart(), fastest = 0;
	stage.watch(1,
				[&]
				{
					const double now = apart();
					fastest = std::max(fastest, (now - before) * setting.rate);
					before = now;
					return true;
				});
	const Vec3 momentum = stage.velocity(first) + stage.velocity(second);
	return {amount(std::max(0.0, 1 - before)), amount(fastest),
			amount(length(stage.velocity(first) - stage.velocity(second))), amount(length(momentum))};
}

Readings deepStart(Workshop& workshop, const Setting& setting)
{
	return overlapping(workshop, setting, {1 - setting.parameter, 0.05, 0.03});
}

Readings coincident(Workshop& workshop, const Setting& setting)
{
	return overlapping(workshop, setting, {});
}

Solid restingSolid(double parameter)
{
	return parameter == 0 ? boxSolid({1, 1, 1}) : torusSolid(0.5, 0.2, 960);
}

Readings restForLong(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting);
	stage.setFriction(0.36);
	stage.add(boxSolid(kFloorSize), fixedAt({{0, -kHalfFloor, 0}}));
	const double height = setting.parameter == 0 ? 0.5 : 0.2;
	const std::size_t body = stage.add(restingSolid(setting.parameter), movingAt(1, {{0, height + 0.01, 0}}));
	stage.seconds(5);
	// GImpact takes milliseconds a step.
	const double minutes = setting.isQuick ? 0.1 : setting.parameter == 0 ? 10 : 1;
	const Transform start = stage.pose(body);
	stage.seconds(60 * minutes);
	const Transform turn = inverse(start) * stage.pose(body);
	double cosine = -0.5;
	for (int k = 0; k < 3; ++k) cosine += 0.5 * turn.rotation.row[k][k];
	return {amount(aside(stage.place(body) - start.translation) / minutes),
			amount(std::acos(std::clamp(cosine, -1.0, 1.0)) * 60 / minutes),
			amount(stage.state().kinetic / (kGravity * height))};
}

// On a slope whose tangent is a hundredth below and above the friction of 0.5.
Readings nearlySlipping(Workshop& workshop, const Setting& setting)
{
	const bool isBelow = setting.parameter < 1;
	const double angle = std::atan(0.5 * setting.parameter);
	Stage stage(workshop, setting);
	stage.setGravity(slopeGravity(angle));
	stage.setFriction(0.5);
	stage.add(boxSolid({40, 1, 10}), fixedAt({{0, -kHalfFloor, 0}}));
	const std::size_t cube = stage.add(boxSolid({1, 1, 1}), movingAt(1, {{0, 0.5005, 0}}));
	stage.seconds(0.5);
	const Vec3 start = stage.place(cube);
	const double time = isBelow ? (setting.isQuick ? 5 : 30) : 5;
	double until = time;
	bool slid = false;
	stage.watch(
		time,
		[&]
		{
			slid = length(stage.place(cube) - start) > 0.01;
			if (slid) until = stage.state().time - 0.5;
			return isBelow || !slid;
		},
		isBelow ? int(setting.rate) : 1);
	if (isBelow) return {amount(length(stage.place(cube) - start) * 60 / time)};
	return {slid ? amount(until) : amount(HUGE_VAL)};
}

// In the air; then thrown flat onto a floor.
Readings spinning(Workshop& workshop, const Setting& setting)
{
	const bool isFree = setting.parameter == 0;
	Stage stage(workshop, setting);
	stage.setFriction(0.36);
	if (isFree) stage.setGravity({});
	stage.add(boxSolid(kFloorSize), fixedAt({{0, isFree ? -100 : -kHalfFloor, 0}}));
	const Vec3 turning = isFree ? Vec3{1, 100, 1} : Vec3{20, 100, 5};
	const std::size_t plate = stage.add(cylinderSolid(0.5, 0.04, 24), movingAt(1, {{0, 1, 0}}, {1, -3, 0}, turning));
	const double start = stage.state().kinetic + (isFree ? 0 : kGravity * 1.0), rim = 100 * 0.5 + 3;
	double most = 0, fastest = 0;
	stage.watch(setting.isQuick ? 1 : (isFree ? 10 : 4),
				[&]
				{
					const double energy = stage.state().kinetic + (isFree ? 0 : kGravity * stage.place(plate).y);
					most = std::max(most, energy / start);
					fastest = std::max(fastest, length(stage.velocity(plate)));
					return true;
				});
	return {amount(std::max(0.0, most - 1)), amount(fastest / rim)};
}
}  // namespace

std::vector<Row> engineRows()
{
	std::vector<Row> rows;
	rows.push_back({"E1",
					"a cube at rest in a world scaled with it",
					"identical up to scale",
					"",
					casesOf({1e-4, 0.01, 1, 100, 1e4}, " m"),
					kRates,
					{{"height", "sizes", {1e-4}}, {"drift", "sizes", {1e-3}}},
					scaledWorld});
	rows.push_back({"E2",
					"a cube at rest in Bullet's own units",
					"rests within a hundredth of its size",
					"size",
					casesOf({1e-3, 0.01, 0.1, 1, 10, 100}, " m"),
					kRates,
					{{"height", "sizes", {0.01}}},
					unscaledWorld});
	rows.push_back({"E3",
					"a cube with margins at rest",
					"height = half the size + margins",
					"",
					casesOf({0, 0.04, 2}, " m"),
					kRates,
					{{"height", "m", {1e-3}}},
					margins});
	rows.push_back({"E4",
					"a heavy cube on one of 1 kg",
					"overlap at most twice Bullet's; energy never rises",
					"mass ratio",
					casesOf({1, 10, 100, 1000, 1e4, 1e6}, ":1"),
					kRates,
					{{"overlap", "sizes", {0.01, 2}}, {"energy gained", "m g size", {0.01}}},
					heavyOnLight});
	rows.push_back({"E5",
					"a cube of any mass at rest",
					"height = half the size",
					"",
					casesOf({1e-9, 1e-3, 1e3, 1e7, 1e8}, " kg"),
					kRates,
					{{"height", "m", {1e-4}}},
					anyMass,
					{{"Bullet's float build takes bodies over 1.4e7 kg for static: they fall through what is static",
					  [](const Setting& s) { return s.parameter > 1.4e7; }, ""}}});
	rows.push_back({"E6",
					"balls of 5 cm at a wall of 2 cm",
					"none passes",
					"speed",
					casesOf({1, 10, 30, 100, 300, 1000}, " m/s"),
					kRates,
					{{"passed", "share", {0}}},
					thinWall});
	rows.push_back({"E7",
					"a tower of five cubes",
					"stands as it was put, or twice as far off as Bullet's",
					"step",
					{},
					{30, 60, 120, 240, 1000, 4000},
					{{"top's height", "m", {0.005, 2}}, {"top aside", "m", {0.005, 2}}, {"speed", "m/s", {0.01, 2}}},
					anyStep,
					{},
					true});
	rows.push_back({"E8",
					"a tower of five cubes far from the origin",
					"places differ from those at the origin by 1 mm + 4 ulp of the distance (float)",
					"distance",
					{{100, "100 m"}, {1e3, "1 km"}, {1e4, "10 km"}, {1e5, "100 km"}, {1e6, "1000 km"}},
					kRates,
					{{"difference", "of what rounding allows", {1}}},
					farAway});
	rows.push_back({"E9",
					"cubes that overlap from the start",
					"apart within a second, at 3 m/s at most, without momentum",
					"overlap",
					percent({0.02, 0.1, 0.3, 0.5, 0.8, 1}),
					kRates,
					{{"overlap left", "sizes", {0.01}},
					 {"fastest push", "m/s", {3}},
					 {"speed kept", "m/s", {0.1}},
					 {"momentum", "kg m/s", {3e-6}}},
					deepStart});
	rows.push_back({"E10",
					"two cubes in the same place",
					"as E9",
					"",
					{},
					kRates,
					{{"overlap left", "sizes", {0.01}},
					 {"fastest push", "m/s", {3}},
					 {"speed kept", "m/s", {0.1}},
					 {"momentum", "kg m/s", {3e-6}}},
					coincident});
	rows.push_back({"E11",
					"minutes at rest, never asleep",
					"2e-5 m a minute, 1e-3 rad an hour, 1e-8 m g h",
					"",
					{{0, "cube"}, {1, "torus"}},
					kRates,
					{{"drift", "m/minute", {2e-5}}, {"turn", "rad/hour", {1e-3}}, {"kinetic energy", "m g h", {1e-8}}},
					restForLong});
	rows.push_back({"E12",
					"towers of cubes",
					"at most twice as far off as Bullet's",
					"",
					casesOf({5, 10, 20}, ""),
					kRates,
					{{"top's height", "m", {0.005, 2}}, {"top aside", "m", {0.005, 2}}, {"speed", "m/s", {0.01, 2}}},
					towers,
					{{"twenty sink into the skin by up to half a millimetre each, and lean and sway by a quarter of a cube",
					  [](const Setting& s) { return s.parameter >= 20; }, ""}}});
	rows.push_back({"E13a",
					"a cube on a slope a hundredth less steep than slips",
					"creeps 1e-4 m a minute at most",
					"",
					{{0.99, "0.99 mu"}},
					kRates,
					{{"creep", "m/minute", {1e-4}}},
					nearlySlipping});
	rows.push_back({"E13b",
					"a cube on a slope a hundredth steeper than slips",
					"1 cm within 5 s",
					"",
					{{1.01, "1.01 mu"}},
					kRates,
					{{"time to slide 1 cm", "s", {5}}},
					nearlySlipping});
	rows.push_back({"E14",
					"a plate spinning at 100 rad/s",
					"no energy gained, no speed above its rim's",
					"",
					{{0, "free"}, {1, "onto a floor"}},
					kRates,
					{{"energy gained", "share", {0.01}}, {"speed", "of the rim's", {2}}},
					spinning});
	return rows;
}
}  // namespace clod::demo
