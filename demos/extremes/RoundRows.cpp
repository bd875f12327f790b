// SPDX-License-Identifier: Zlib
// A: closed forms of bodies that roll or slide round. What a mesh cannot do better than its facets is judged beside the
// polygon's closed form, and beside Bullet's best shape of the same mesh.
#include <algorithm>
#include <cmath>

#include "demos/extremes/RowParts.h"
#include "demos/extremes/Stage.h"
#include "demos/extremes/Swing.h"
#include "demos/models/Mechanisms.h"

namespace clod::demo
{
namespace
{
constexpr double kSwing =
	20 * kDegree;  // small swings feel facets; both bodies roll, so that this is a pendulum's angle

// A polygon that rolls as one: between impacts it turns about a corner, at each the angular momentum about the next one
// is kept (the rimless wheel, McGeer 1990). Inertia of a unit of mass about its middle; starts flat on a side, with
// time / 2e5 a step. The speed of its middle along the slope, in the mean over a side.
double polygonSpeed(int sides, double radius, double inertia, double slope, double time)
{
	const double half = kPi / sides, about = inertia + radius * radius;
	const double kept = (inertia + radius * radius * std::cos(2 * half)) / about;
	// Of the corner's spoke against the surface's normal; the weight pulls it on where it leans further than the slope.
	double angle = -half, rate = 0, t = 0;
	const double dt = time / 2e5;
	while (t < time)
	{
		rate += dt * kGravity * radius * std::sin(angle + slope) / about;
		if (angle <= -half && rate < 0) rate = 0;  // it lies on its side
		angle += dt * rate;
		if (angle >= half)
		{
			angle -= 2 * half;
			rate *= kept;
		}
		t += dt;
	}
	return rate * radius * std::sin(half) / half;
}

Readings rollingDown(Workshop& workshop, const Setting& setting, const Solid& solid, const Pose& pose, double radius,
					 double inertia, int sides)
{
	const double angle = 15 * kDegree;
	Stage stage(workshop, setting);
	stage.setGravity(slopeGravity(angle));
	stage.setFriction(0.8);
	addFloor(stage);
	const std::size_t body = stage.add(solid, movingAt(1, pose));
	stage.seconds(2);
	const double speed = stage.velocity(body).x,
				 round = kGravity * std::sin(angle) * 2 / (1 + inertia / (radius * radius));
	const bool isRound = setting.collider == Collider::primitive;
	return {relativeTo(round, speed),
			relativeTo(isRound ? round : polygonSpeed(sides, radius, inertia, angle, 2), speed)};
}
Readings rollingBall(Workshop& workshop, const Setting& setting)
{
	// Of n x n cells a side of a cube, n even: it rolls on a ring of 4 n corners.
	const int sides = 4 * int(std::lround(std::sqrt(setting.parameter / 12)));
	return rollingDown(workshop, setting, ballSolid(0.5, parameterCount(setting)),
					   {turnedAbout({0, 0, 1}, kPi / sides, {0, 0.5005, 0})}, 0.5, 0.4 * 0.25, sides);
}
Readings rollingCylinder(Workshop& workshop, const Setting& setting)
{
	return rollingDown(workshop, setting, cylinderSolid(0.5, 1, int(setting.parameter)), lyingAt({0, 0.5005, 0}), 0.5,
					   0.5 * 0.25, int(setting.parameter));
}
Readings rollingTorus(Workshop& workshop, const Setting& setting)
{
	const double ring = 0.4, tube = 0.1;
	const int sides = torusSections(parameterCount(setting));
	const Pose onSide = turnedTwice(lyingAt({}), turnedAbout({0, 0, 1}, kPi / sides, {0, 0.5005, 0}));
	return rollingDown(workshop, setting, torusSolid(ring, tube, parameterCount(setting)), onSide, ring + tube,
					   ring * ring + 0.75 * tube * tube, sides);
}

Readings slidingThenRolling(Workshop& workshop, const Setting& setting)
{
	const double speed = 5, friction = 0.4;
	Stage stage(workshop, setting);
	stage.setFriction(friction);
	addFloor(stage);
	const std::size_t ball =
		stage.add(ballSolid(0.5, parameterCount(setting)), movingAt(1, {{-20, 0.5005, 0}}, {speed, 0, 0}));
	stage.seconds(1.2 * 2 * speed / (7 * friction * kGravity));
	return {relativeTo(speed * 5 / 7, stage.velocity(ball).x)};
}

Readings ballInBowl(Workshop& workshop, const Setting& setting)
{
	const double scale = 1 / DISH_RADIUS, ball = 0.2, reach = 1 - ball, start = kSwing;
	const double expected = swingPeriod(std::sqrt(5 * kGravity / (7 * reach)), start);
	Stage stage(workshop, setting);
	stage.setFriction(0.8);
	const Solid dish = partSolid("dish", parameterCount(setting), scale);
	stage.add(dish, fixedAt({}));
	const std::size_t body = stage.add(ballSolid(ball, parameterCount(setting) < 5000 ? 768 : 1728),
									   movingAt(1, {{reach * std::sin(start), -reach * std::cos(start), 0}}));
	const Swing swing =
		watchSwing(stage, expected, 3, [&] { return std::atan2(stage.place(body).x, -stage.place(body).y); });
	return {relativeTo(expected, swing.period), amount(std::max(0.0, -swing.growth)),
			amount(std::max(0.0, swing.growth))};
}

Readings torusOnPeg(Workshop& workshop, const Setting& setting)
{
	const double ring = 0.775, tube = 0.3, peg = 0.25, a = ring - tube, start = kSwing;
	const double inertia = ring * ring + 0.75 * tube * tube;
	const double expected = swingPeriod(std::sqrt(kGravity / ((a - peg) * (1 + inertia / (a * a)))), start);
	Stage stage(workshop, setting);
	stage.setFriction(0.8);
	stage.add(cylinderSolid(peg, 2, int(setting.parameter / 10)), fixedAt(lyingAt({})));
	const double reach = a - peg - 0.0005;
	const std::size_t body = stage.add(torusSolid(ring, tube, parameterCount(setting)),
									   movingAt(1, lyingAt({reach * std::sin(start), -reach * std::cos(start), 0})));
	const Swing swing =
		watchSwing(stage, expected, 3, [&] { return std::atan2(stage.place(body).x, -stage.place(body).y); });
	return {relativeTo(expected, swing.period), amount(std::max(0.0, swing.growth))};
}

// A puck that may not turn slides round inside a tube that presses it inward.
Readings puckInTube(Workshop& workshop, const Setting& setting)
{
	const double wall = 2, radius = 0.2, friction = 0.2, speed = 2;
	Stage stage(workshop, setting);
	stage.setGravity({});
	stage.setFriction(friction);
	const int count = int(setting.parameter);
	stage.add(tubeSolid(wall, wall + 0.3, 1, count), fixedAt({}));
	BodyDefinition puck = movingAt(1, {{0, 0, wall - radius - 0.002}}, {speed, 0, 0});
	puck.moves = {1, 0, 1};
	puck.turns = {0, 0, 0};
	const std::size_t body = stage.add(cylinderSolid(radius, 0.2, 48), puck);
	double turned = 0, last = std::atan2(stage.place(body).x, stage.place(body).z);
	stage.watch(10,
				[&]
				{
					const double angle = std::atan2(stage.place(body).x, stage.place(body).z);
					turned += std::remainder(angle - last, 2 * kPi);
					last = angle;
					return turned < kPi;
				});
	// At each side of a polygon what goes into the wall is lost, and so much of it again along the wall.
	const double side = 2 * kPi / count, kept = std::pow(std::cos(side) - friction * std::sin(side), turned / side);
	const double now = length(stage.velocity(body));
	return {relativeTo(speed * std::exp(-friction * turned), now), relativeTo(speed * kept, now)};
}

// A coin set rolling on its rim, as in the scene spinning-plate.
Readings coin(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting, "spinning-plate", 0.25, {"floor", "plate"});
	constexpr double kSoon = 0.25;  // s: a real one rolls for seconds
	double lowest = stage.energy(), risen = 0, soon = 0;
	const double start = lowest;
	stage.watch(3,
				[&]
				{
					const double energy = stage.energy();
					lowest = std::min(lowest, energy);
					risen = std::max(risen, energy - lowest);
					if (stage.state().time <= kSoon) soon = energy;
					return true;
				});
	return {amount(risen / start), amount(std::max(0.0, 1 - soon / start))};
}

}  // namespace

std::vector<Row> roundRows()
{
	const Limit asPolygon = {
		"what has facets rolls as a polygon, each facet that lands is an impact; Bullet's hulls feel them less", anyRun,
		"speed"};
	const Limit coarse = {"coarse levels have coarse facets", coarseLevels, "beside a polygon's"};
	const Limit facetAStep = {"at 1/60 s what turns by about a facet a step loses more than the polygon does", largeSteps,
							  "beside a polygon's"};
	const std::vector<Quantity> rolling = {{"speed", "share", {0.01, 1, 0.01}},
										   {"beside a polygon's", "share", {0.03, 1}}};
	std::vector<Row> rows;
	rows.push_back({"A5a", "a ball rolls down 15 degrees",
					"5/7 g sin t, as the hull + 1 %; a rolling polygon (McGeer 1990)", "", triangles({432, 1728}),
					kAnalyticRates, rolling, rollingBall, {asPolygon, coarse}});
	rows.push_back({"A5b", "a cylinder rolls down 15 degrees", "2/3 g sin t, as the hull + 1 %; a rolling polygon", "",
					sides({24, 96}), kAnalyticRates, rolling, rollingCylinder, {asPolygon}});
	rows.push_back({"A5c", "a torus rolls down 15 degrees",
					"g sin t / (1 + I / m r^2), as GImpact + 1 %; a rolling polygon", "", triangles({480, 1920}),
					kAnalyticRates, rolling, rollingTorus, {asPolygon, facetAStep, coarse}});
	rows.push_back({"A6",
					"a ball slides, then rolls",
					"5/7 v",
					"",
					triangles({300, 1200}),
					kAnalyticRates,
					{{"speed", "share", {0.02, 1, 0.02}}},
					slidingThenRolling,
					{{"facets brake it, as in A5", anyRun, ""}}});
	rows.push_back(
		{"A13",
		 "a ball swings in a bowl",
		 "2 pi sqrt(7 (R - r) / 5 g), for 20 degrees",
		 "",
		 triangles({3600, 7200}),
		 kGimpactRates,
		 {{"period", "share", {0.02, 1}},
		  {"amplitude lost", "share", {0.05, 2}},
		  {"amplitude gained", "share", {0.01, 1}}},
		 ballInBowl,
		 {{"facets brake it, as in A5", anyRun, "amplitude lost"},
		  {"at 1/60 s, on coarse meshes and levels facets change its period, or it stops on one",
		   [](const Setting& s) { return largeSteps(s) || coarseLevels(s) || s.parameter < 5000; }, "period"}},
		 true});
	rows.push_back({"A14",
					"a torus swings on a round peg",
					"2 pi sqrt((a - rho) (1 + I / m a^2) / g), for 20 degrees",
					"",
					triangles({960, 1920}),
					kGimpactRates,
					{{"period", "share", {0.02, 1}}, {"amplitude gained", "share", {0.01, 1}}},
					torusOnPeg,
					{{"coarse levels have coarse facets", coarseLevels, ""}},
					true});
	rows.push_back({"A17",
					"a puck slides half round a tube",
					"v exp(-mu angle); of a polygon v (cos - mu sin)^sides",
					"",
					sides({48, 192}),
					kAnalyticRates,
					{{"speed", "share", {0.05, 1}}, {"beside a polygon's", "share", {0.05, 1}}},
					puckInTube});
	rows.push_back({"A20",
					"a coin rolls on its rim",
					"its energy never rises, and hardly falls in a quarter of a second",
					"",
					{},
					kAnalyticRates,
					{{"energy risen", "share", {0.01, 1}}, {"energy lost", "share", {0.1, 1}}},
					coin,
					{{"it loses the more the farther its point of contact goes round in a step; Bullet's hull a fifth as much",
					  anyRun, "energy lost"}}});
	return rows;
}
}  // namespace clod::demo
