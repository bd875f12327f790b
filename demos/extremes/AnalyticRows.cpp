// SPDX-License-Identifier: Zlib
// A: cases with a closed form, each at three steps and, where tessellation matters, two resolutions (its parameter).
#include <algorithm>
#include <cmath>

#include "demos/extremes/RowParts.h"
#include "demos/extremes/Swing.h"

namespace clod::demo
{
namespace
{
// The same run of Bullet's primitive: what no contact touches may not differ by a bit.
Readings besidePrimitive(const Setting& setting, const std::function<Readings(const Setting&)>& run)
{
	Readings readings = run(setting);
	Setting primitive = setting;
	primitive.collider = Collider::primitive;
	const Readings same = run(primitive);
	readings.push_back(differenceFrom(same.front().value, readings.front().value));
	return readings;
}

Readings freeFall(Workshop& workshop, const Setting& setting)
{
	return besidePrimitive(setting,
						   [&](const Setting& one) -> Readings
						   {
							   Stage stage(workshop, one);
							   const std::size_t cube = stage.add(boxSolid({1, 1, 1}), movingAt(1, {}));
							   stage.seconds(2);
							   const double time = stage.state().time;
							   return {relativeTo(kGravity * time * (time + one.dt()) / 2, -stage.place(cube).y)};
						   });
}

// Angles where it has moved by a centimetre in two seconds, halved to a fiftieth of a degree.
Readings slipAngle(Workshop& workshop, const Setting& setting)
{
	const auto slips = [&](double angle)
	{
		Stage stage(workshop, setting);
		stage.setGravity(slopeGravity(angle));
		stage.setFriction(0.5);
		addFloor(stage);
		const std::size_t cube = stage.add(boxSolid({1, 1, 1}, parameterCount(setting)), movingAt(1, {{0, 0.5005, 0}}));
		stage.seconds(2);
		return length(stage.place(cube) - Vec3{0, 0.5, 0}) > 0.01;
	};
	double low = 20 * kDegree, high = 33 * kDegree;
	while (high - low > 0.02 * kDegree)
	{
		const double middle = (low + high) / 2;
		(slips(middle) ? high : low) = middle;
	}
	return {differenceFrom(std::atan(0.5) / kDegree, (low + high) / 2 / kDegree)};
}

Readings slidingDown(Workshop& workshop, const Setting& setting)
{
	const double angle = 30 * kDegree, friction = 0.2;
	Stage stage(workshop, setting);
	stage.setGravity(slopeGravity(angle));
	stage.setFriction(friction);
	addFloor(stage);
	const std::size_t cube = stage.add(boxSolid({1, 1, 1}, parameterCount(setting)), movingAt(1, {{0, 0.5005, 0}}));
	stage.seconds(2);
	return {relativeTo(kGravity * (std::sin(angle) - friction * std::cos(angle)) * 2, stage.velocity(cube).x)};
}

Readings slidingStop(Workshop& workshop, const Setting& setting)
{
	const double friction = 0.3, speed = 3;
	Stage stage(workshop, setting);
	stage.setFriction(friction);
	addFloor(stage);
	const std::size_t cube =
		stage.add(boxSolid({1, 1, 1}, parameterCount(setting)), movingAt(1, {{0, 0.5005, 0}}, {speed, 0, 0}));
	stage.seconds(2);
	return {relativeTo(speed * speed / (2 * friction * kGravity), stage.place(cube).x)};
}

// The mean over ten heights: where in a step the ball meets the floor is a matter of chance.
Readings bounce(Workshop& workshop, const Setting& setting)
{
	const double e = setting.parameter;
	const int drops = setting.isQuick ? 2 : 10;
	double sum = 0, most = 0;
	for (int i = 0; i < drops; ++i)
	{
		Stage stage(workshop, setting);
		stage.scene().world.restitution = std::sqrt(e);
		addFloor(stage, 10);
		const double drop = 0.5 + 0.0737 * i;
		const std::size_t ball = stage.add(ballSolid(0.5, 1200), movingAt(1, {{0, 0.5 + drop, 0}}));
		double highest = 0;
		bool isUp = false, isOver = false;
		stage.watch(i == 0 && e == 1 ? 20 : 4,
					[&]
					{
						const double speed = stage.velocity(ball).y;
						isUp = isUp || speed > 0;
						isOver = isOver || (isUp && speed < 0);
						if (isUp && !isOver) highest = std::max(highest, stage.place(ball).y - 0.5);
						if (i == 0) most = std::max(most, (stage.energy() - kGravity * 0.5) / (kGravity * drop));
						return !isOver || i == 0;
					});
		sum += highest / drop;
	}
	return {differenceFrom(e * e, sum / drops), amount(std::max(0.0, most - 1))};
}

Readings obliqueCollision(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting);
	stage.setGravity({});
	stage.setFriction(0.3);
	stage.scene().world.restitution = std::sqrt(0.5);
	const std::size_t count = parameterCount(setting);
	const std::size_t a = stage.add(ballSolid(0.5, count), movingAt(1, {{-1.2, 0.3, 0.1}}, {4, 0, 0}, {0, 2, 1}));
	const std::size_t b = stage.add(ballSolid(0.5, count), movingAt(2, {}, {0, 0.1, 0}));
	const auto momenta = [&]
	{
		Vec3 linear, angular;
		for (const std::size_t body : {a, b})
		{
			const double mass = stage.scene().bodies[body].mass;
			const Hierarchy& hierarchy = stage.hierarchy(body);
			linear += mass * stage.velocity(body);
			// The mesh's inertia is a multiple of the unit matrix, to rounding.
			const double inertia = mass * hierarchy.asset().inertia[0] / hierarchy.asset().volume;
			angular += cross(stage.place(body), mass * stage.velocity(body)) + inertia * stage.turning(body);
		}
		return std::make_pair(linear, angular);
	};
	const auto before = momenta();
	stage.seconds(1);
	const auto after = momenta();
	return {amount(length(after.first - before.first) / length(before.first)),
			amount(length(after.second - before.second) / length(before.second)),
			amount(length(stage.velocity(a) - Vec3{4, 0, 0}) > 0.1 ? 0 : HUGE_VAL)};
}

Readings tumbling(Workshop& workshop, const Setting& setting)
{
	return besidePrimitive(
		setting,
		[&](const Setting& one) -> Readings
		{
			Stage stage(workshop, one);
			stage.setGravity({});
			const std::size_t box = stage.add(boxSolid({1, 0.6, 0.3}), movingAt(1, {}, {}, {0.01, 6, 0.01}));
			const double start = stage.energy();
			stage.seconds(10);
			(void)box;
			return {relativeTo(start, stage.energy())};
		});
}

// A wheel on a horizontal axle, held at one point of it: it goes round by m g l / (I w).
Readings precession(Workshop& workshop, const Setting& setting)
{
	const double reach = 0.5, spin = 80, radius = 0.5;
	Stage stage(workshop, setting);
	const Vec3 axis = {1, 0, 0};
	const double rate = kGravity * reach / (0.5 * radius * radius * spin);
	// The wheel's own axis is y; it starts along x and already goes round.
	BodyDefinition wheel = movingAt(1, turnedAbout({0, 0, 1}, -kPi / 2, {reach, 0, 0}),
									cross({0, rate, 0}, {reach, 0, 0}), spin * axis + Vec3{0, rate, 0});
	wheel.joints = {{BodyJoint::Kind::ball, {0, 0, 0}, {0, 1, 0}, {}}};
	const std::size_t body = stage.add(cylinderSolid(radius, 0.1, 24), wheel);
	const double time = 1.2 / rate;
	stage.seconds(time);
	const Vec3 place = stage.place(body);
	return {relativeTo(rate * stage.state().time, std::atan2(-place.z, place.x))};
}

Readings toppling(Workshop& workshop, const Setting& setting)
{
	const auto topples = [&](double angle)
	{
		Stage stage(workshop, setting);
		stage.setGravity(slopeGravity(angle));
		stage.setFriction(2);
		addFloor(stage);
		const std::size_t block =
			stage.add(boxSolid({0.5, 1, 0.5}, parameterCount(setting)), movingAt(1, {{0, 0.5003, 0}}));
		stage.seconds(3);
		return stage.pose(block).rotation.row[1].y < 0.9;
	};
	double low = 20 * kDegree, high = 33 * kDegree;
	while (high - low > 0.02 * kDegree)
	{
		const double middle = (low + high) / 2;
		(topples(middle) ? high : low) = middle;
	}
	return {differenceFrom(std::atan(0.5) / kDegree, (low + high) / 2 / kDegree)};
}

// Let go at half the angle at which it would stand on its edge.
Readings rockingBlock(Workshop& workshop, const Setting& setting)
{
	const double width = 0.5, height = 2, reach = std::hypot(width, height) / 2, angle = std::atan2(width, height);
	const double lean = angle / 2, p = std::sqrt(3 * kGravity / (4 * reach));
	Stage stage(workshop, setting);
	stage.setFriction(1);
	addFloor(stage);
	// About its lower right edge, which stays at the origin.
	Pose pose = turnedAbout({0, 0, 1}, -lean);
	pose.position = toTransform(pose) * Vec3{-width / 2, height / 2, 0};
	pose.position.y += 2e-4;
	const std::size_t block = stage.add(boxSolid({width, height, 0.5}, parameterCount(setting)), movingAt(1, pose));
	double upright = std::nan(""), before = 0, last = 0;
	double ratio = std::nan("");
	stage.watch(3,
				[&]
				{
					const double tilt =
						std::atan2(stage.pose(block).rotation.row[0].y, stage.pose(block).rotation.row[1].y);
					const double now = stage.turning(block).z;
					if (std::isnan(upright) && tilt <= 0.002)
					{
						upright = stage.state().time;
						before = last;
					}
					// A twentieth of a second on the impact is over.
					if (!std::isnan(upright) && stage.state().time > upright + 0.05)
					{
						// Gravity brakes it again meanwhile.
						const double braked = p * p * angle * 0.05;
						ratio = std::pow((now + braked) / before, 2);
						return false;
					}
					last = std::max(last, now);
					return true;
				});
	const double share = 1 - 1.5 * std::sin(angle) * std::sin(angle);
	return {relativeTo(4 / p * std::acosh(1 / (1 - lean / angle)), 4 * upright), relativeTo(share * share, ratio)};
}

Readings restingTorus(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting);
	stage.setFriction(0.36);
	const std::size_t floor = addFloor(stage, 10);
	const Solid solid = torusSolid(0.5, 0.2, parameterCount(setting));
	const std::size_t torus = stage.add(solid, movingAt(1, {{0, 0.21, 0}}));
	double radius = 0;  // of its tube, where its corners are lowest
	for (const Vec3& vertex : solid.mesh.vertices) radius = std::max(radius, -vertex.y);
	stage.seconds(3);
	const Vec3 start = stage.place(torus);
	const double minutes = setting.isQuick ? 0.05 : 0.1;
	stage.seconds(60 * minutes);
	return {relativeTo(radius + stage.restGap(floor, torus), stage.place(torus).y),
			amount(length(stage.place(torus) - start) / minutes)};
}

Readings torusDownPeg(Workshop& workshop, const Setting& setting)
{
	const double ring = 0.5, tube = 0.2;
	Stage stage(workshop, setting);
	stage.add(cylinderSolid(0.29, 40, 32), fixedAt({}));
	const std::size_t torus = stage.add(torusSolid(ring, tube, parameterCount(setting)),
										movingAt(1, turnedAbout({0, 0, 1}, 0.02, {0.004, 18, 0})));
	stage.seconds(1.5);
	const double time = stage.state().time;
	return {relativeTo(kGravity * time * (time + setting.dt()) / 2, 18 - stage.place(torus).y)};
}

Readings cradle(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting);
	stage.setGravity({});
	stage.scene().world.restitution = 1;
	const Solid ball = ballSolid(0.5, parameterCount(setting));
	std::vector<std::size_t> balls;
	for (int i = 0; i < 5; ++i)
		balls.push_back(
			stage.add(ball, movingAt(1, {{i == 0 ? -2.0 : 1.001 * (i - 1), 0, 0}}, {i == 0 ? 3.0 : 0, 0, 0})));
	const double start = stage.energy();
	stage.seconds(1.5);
	Vec3 momentum;
	for (const std::size_t one : balls) momentum += stage.velocity(one);
	return {amount(length(momentum - Vec3{3, 0, 0}) / 3), amount(std::max(0.0, stage.energy() / start - 1)),
			relativeTo(3, stage.velocity(balls.back()).x)};
}

// About an axle at the end of a rod, for ten small swings.
Readings freePendulum(Workshop& workshop, const Setting& setting)
{
	const double reach = 0.4, height = 1, width = 0.2;
	const double inertia = (height * height + width * width) / 12 + reach * reach;
	const double start = 3 * kDegree, expected = swingPeriod(std::sqrt(kGravity * reach / inertia), start);
	return besidePrimitive(setting,
						   [&](const Setting& one) -> Readings
						   {
							   Stage stage(workshop, one);
							   Pose pose = turnedAbout({0, 0, 1}, start);
							   pose.position = toTransform(pose) * Vec3{0, -reach, 0};
							   BodyDefinition rod = movingAt(1, pose);
							   rod.joints = {{BodyJoint::Kind::hinge, {0, 0, 0}, {0, 0, 1}, {}}};
							   const std::size_t body = stage.add(boxSolid({width, height, width}), rod);
							   const Swing swing =
								   watchSwing(stage, expected, 5,
											  [&] { return std::atan2(stage.place(body).x, -stage.place(body).y); });
							   return {relativeTo(expected, swing.period)};
						   });
}

// A square peg over a hole that is wider by the parameter on either side, without friction.
Readings pegInHole(Workshop& workshop, const Setting& setting)
{
	const double clearance = setting.parameter, width = 0.4;
	Stage stage(workshop, setting);
	const double inside = width + 2 * clearance, outside = 1.2;
	// The block with the hole is one mesh: a tube of four sides, turned so that its walls face the peg.
	const double corner = std::sqrt(0.5);
	Solid block = tubeSolid(inside / 2, outside * corner, 1, 4);
	stage.add(block, fixedAt({{0, -0.5, 0}}));
	const std::size_t peg =
		stage.add(boxSolid({width, 1, width}, 300), movingAt(1, {{0.3 * clearance, 0.501, -0.2 * clearance}}));
	stage.seconds(0.3);
	const double time = stage.state().time;
	return {relativeTo(kGravity * time * (time + setting.dt()) / 2, 0.501 - stage.place(peg).y)};
}
}  // namespace

std::vector<Row> analyticRows()
{
	const Bound same{0};
	std::vector<Row> rows;
	rows.push_back({"A1",
					"free fall for 2 s",
					"g t (t + dt) / 2; to the bit as the primitive",
					"",
					{},
					kAnalyticRates,
					{{"way", "share", {1e-5, 1}}, {"beside the primitive", "m", same}},
					freeFall});
	rows.push_back({"A2",
					"the slope that a cube slips on",
					"atan mu",
					"",
					triangles({12, 1200}),
					kAnalyticRates,
					{{"angle", "degrees", {0.5, 2}}},
					slipAngle});
	rows.push_back({"A3",
					"a cube slides down 30 degrees",
					"g (sin - mu cos) t",
					"",
					triangles({12, 1200}),
					kAnalyticRates,
					{{"speed", "share", {0.03, 1.5}}},
					slidingDown});
	rows.push_back({"A4",
					"a cube slides to a stop",
					"v^2 / (2 mu g)",
					"",
					triangles({12, 1200}),
					kAnalyticRates,
					{{"way", "share", {0.03, 1.5}}},
					slidingStop});
	rows.push_back({"A7",
					"a ball bounces",
					"height e^2; no energy gained in 20 s",
					"",
					{{1, "e = 1"}, {0.5, "e = 0.5"}, {0, "e = 0"}},
					kAnalyticRates,
					{{"height", "of the drop's", {0.01, 1}}, {"energy gained", "share", {0.02, 1}}},
					bounce,
					{{"what has facets and turns gains some per cent of energy in perfectly elastic bounces",
					  [](const Setting& one) { return one.parameter == 1; }, "energy gained"}}});
	rows.push_back({"A8",
					"two balls collide off centre",
					"momenta are kept",
					"",
					triangles({300, 1200}),
					kAnalyticRates,
					{{"momentum", "share", {1e-5}}, {"angular momentum", "share", {1e-4, 1}}, {"missed", "", {0}}},
					obliqueCollision,
					{{"friction of a contact that is made ahead acts at two places, as with Bullet's solids", anyRun,
					  "angular momentum"}}});
	rows.push_back({"A9",
					"a box tumbles freely about its middle axis",
					"to the bit as the primitive of the same inertia",
					"",
					{},
					kAnalyticRates,
					{{"energy", "share", {HUGE_VAL}}, {"beside the primitive", "J", same}},
					tumbling});
	rows.push_back({"A10",
					"a wheel on its axle goes round",
					"m g l / (I w); as the primitive",
					"",
					{},
					kAnalyticRates,
					{{"angle", "share", {0.05, 2}}},
					precession});
	rows.push_back({"A11",
					"the slope that a block topples on",
					"atan(width / height)",
					"",
					triangles({12, 1200}),
					kAnalyticRates,
					{{"angle", "degrees", {0.5, 1}}},
					toppling});
	rows.push_back({"A12",
					"a block rocks (Housner 1963)",
					"4/p acosh(1 / (1 - lean / angle)); (1 - 1.5 sin^2)^2",
					"",
					triangles({12, 1200}),
					kAnalyticRates,
					{{"period", "share", {0.03, 1}}, {"energy after the impact", "share", {0.1, 1}}},
					rockingBlock});
	rows.push_back({"A15",
					"a torus lies on a floor",
					"height = that of its middle over its lowest corners; 2e-5 m a minute",
					"",
					triangles({480, 1280}),
					kGimpactRates,
					{{"height", "share", {1e-3, 1}}, {"drift", "m/minute", {2e-5, 2}}},
					restingTorus});
	rows.push_back({"A16",
					"a torus falls down a peg without friction",
					"g t^2 / 2",
					"",
					triangles({480, 1280}),
					kGimpactRates,
					{{"way", "share", {0.01}}},
					torusDownPeg});
	rows.push_back({"A18",
					"Newton's cradle of five balls",
					"momentum kept, no energy gained",
					"",
					triangles({300, 1200}),
					kAnalyticRates,
					{{"momentum", "share", {1e-5}},
					 {"energy gained", "share", {0.01, 1}},
					 {"speed of the last", "share", {0.05, 1}}},
					cradle,
					{{"coarse facets meet at points near each other, of whose impulses 40 iterations leave too much (200: none)",
					  coarseLevels, "energy gained"}}});
	rows.push_back({"A19",
					"a rod swings about an ideal axle",
					"2 pi sqrt(I / m g l); to the bit as the primitive",
					"",
					{},
					kAnalyticRates,
					{{"period", "share", {0.01}}, {"beside the primitive", "s", same}},
					freePendulum});
	rows.push_back({"A21",
					"a peg falls into a hole wider by a clearance",
					"g t^2 / 2",
					"",
					{{0.02, "20 mm"}, {0.002, "2 mm"}, {0.001, "1 mm"}, {0.0005, "0.5 mm"}},
					kAnalyticRates,
					{{"way", "share", {0.01}}},
					pegInHole,
					{{"a clearance under 0.1 % of the radius can jam at the rim",
					  [](const Setting& one) { return one.parameter < 0.001; }, ""}}});
	return rows;
}
}  // namespace clod::demo
