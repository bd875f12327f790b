// SPDX-License-Identifier: Zlib
// A: cases with a closed form, each at three steps and, where tessellation matters, two resolutions (its parameter).
// What a mesh cannot do better than its facets is judged beside Bullet's best shape of the same mesh.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "demos/extremes/Stage.h"
#include "demos/models/Mechanisms.h"

namespace clod::demo
{
namespace
{
using Readings = std::vector<Reading>;

const std::vector<double> kRates = {240, 60, 1000};
const std::vector<double> kGimpactRates = {240, 60, 480};  // where a step takes milliseconds
constexpr double kHalfFloor = 0.5;
constexpr double kDegree = kPi / 180;

std::vector<Case> triangles(const std::vector<int>& counts)
{
	std::vector<Case> cases;
	for (const int count : counts) cases.push_back({double(count), fmt::format("{} triangles", count)});
	return cases;
}
std::vector<Case> sides(const std::vector<int>& counts)
{
	std::vector<Case> cases;
	for (const int count : counts) cases.push_back({double(count), fmt::format("{} sides", count)});
	return cases;
}

std::size_t addFloor(Stage& stage, double length = 60)
{
	return stage.add(boxSolid({length, 1, 10}), fixedAt({{0, -kHalfFloor, 0}}));
}
// Turns about x, so that a solid about y rolls along x.
Pose lyingAt(const Vec3& place)
{
	return turnedAbout({1, 0, 0}, kPi / 2, place);
}
std::size_t parameterCount(const Setting& setting)
{
	return std::size_t(setting.parameter);
}
// The same run of Bullet's primitive: what no contact touches may not differ by a bit.
Readings besidePrimitive(Workshop& workshop, const Setting& setting, const std::function<Readings(const Setting&)>& run)
{
	(void)workshop;
	Readings readings = run(setting);
	Setting primitive = setting;
	primitive.collider = Collider::primitive;
	const Readings same = run(primitive);
	readings.push_back(differenceFrom(same.front().value, readings.front().value));
	return readings;
}

Readings freeFall(Workshop& workshop, const Setting& setting)
{
	return besidePrimitive(workshop, setting,
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
		const std::size_t cube =
			stage.add(boxSolid({1, 1, 1}, parameterCount(setting)), movingAt(1, {{0, 0.5005, 0}}));
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

// A polygon that rolls as one: between impacts it turns about a corner, at each the angular momentum about the next one is
// kept (the rimless wheel, McGeer 1990). Inertia of a unit of mass about its middle; starts flat on a side, with time / 2e5
// a step. The speed of its middle along the slope, in the mean over a side.
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
	const double speed = stage.velocity(body).x, round = kGravity * std::sin(angle) * 2 / (1 + inertia / (radius * radius));
	const bool isRound = setting.collider == Collider::primitive;
	return {relativeTo(round, speed), relativeTo(isRound ? round : polygonSpeed(sides, radius, inertia, angle, 2), speed)};
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
	return besidePrimitive(workshop, setting,
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
	BodyDefinition wheel = movingAt(1, turnedAbout({0, 0, 1}, -kPi / 2, {reach, 0, 0}), cross({0, rate, 0}, {reach, 0, 0}),
									spin * axis + Vec3{0, rate, 0});
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
		const std::size_t block = stage.add(boxSolid({0.5, 1, 0.5}, parameterCount(setting)), movingAt(1, {{0, 0.5003, 0}}));
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
					const double tilt = std::atan2(stage.pose(block).rotation.row[0].y, stage.pose(block).rotation.row[1].y);
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

// Times of zero crossings from one side, in the mean; NaN where there are fewer than two.
class Period
{
public:
	void add(double time, double angle)
	{
		if (m_hasLast && m_last < 0 && angle >= 0) m_crossings.push_back(time - (time - m_time) * angle / (angle - m_last));
		m_last = angle;
		m_time = time;
		m_hasLast = true;
		m_largest = std::max(m_largest, std::fabs(angle));
	}
	double mean() const
	{
		if (m_crossings.size() < 2) return std::nan("");
		return (m_crossings.back() - m_crossings.front()) / double(m_crossings.size() - 1);
	}
	double largest() const { return m_largest; }
	void restart() { m_largest = 0; }

private:
	std::vector<double> m_crossings;
	double m_last = 0, m_time = 0, m_largest = 0;
	bool m_hasLast = false;
};

// Facets are felt by small swings: these take several. Both bodies roll, so that their angle is a pendulum's at any size.
constexpr double kSwing = 20 * kDegree;
// By the arithmetic-geometric mean of 1 and cos(amplitude / 2).
double swingPeriod(double smallRate)
{
	double a = 1, g = std::cos(kSwing / 2);
	for (int i = 0; i < 6; ++i)
	{
		const double mean = (a + g) / 2;
		g = std::sqrt(a * g);
		a = mean;
	}
	return 2 * kPi / smallRate / a;
}

// Seconds of a swing to watch: its period, and by how much the amplitude of the last period is above the first one's.
struct Swing
{
	Period period;
	double growth;
};
Swing watchSwing(Stage& stage, double expected, int periods, const std::function<double()>& angle)
{
	Swing swing;
	double first = 0;
	const double start = stage.state().time;
	stage.watch(expected * periods,
				[&]
				{
					const double time = stage.state().time;
					swing.period.add(time, angle());
					if (first == 0 && time - start >= expected)
					{
						first = swing.period.largest();
						swing.period.restart();
					}
					if (time - start < expected * (periods - 1)) swing.period.restart();
					return true;
				});
	swing.growth = swing.period.largest() / first - 1;
	return swing;
}

Readings ballInBowl(Workshop& workshop, const Setting& setting)
{
	const double scale = 1 / DISH_RADIUS, ball = 0.2, reach = 1 - ball, start = kSwing;
	const double expected = swingPeriod(std::sqrt(5 * kGravity / (7 * reach)));
	Stage stage(workshop, setting);
	stage.setFriction(0.8);
	const Solid dish = partSolid("dish", parameterCount(setting), scale);
	stage.add(dish, fixedAt({}));
	const std::size_t body = stage.add(ballSolid(ball, parameterCount(setting) < 5000 ? 768 : 1728),
									   movingAt(1, {{reach * std::sin(start), -reach * std::cos(start), 0}}));
	const Swing swing = watchSwing(stage, expected, 3,
								   [&] { return std::atan2(stage.place(body).x, -stage.place(body).y); });
	return {relativeTo(expected, swing.period.mean()), amount(std::max(0.0, -swing.growth)),
			amount(std::max(0.0, swing.growth))};
}

Readings torusOnPeg(Workshop& workshop, const Setting& setting)
{
	const double ring = 0.775, tube = 0.3, peg = 0.25, a = ring - tube, start = kSwing;
	const double inertia = ring * ring + 0.75 * tube * tube;
	const double expected = swingPeriod(std::sqrt(kGravity / ((a - peg) * (1 + inertia / (a * a)))));
	Stage stage(workshop, setting);
	stage.setFriction(0.8);
	stage.add(cylinderSolid(peg, 2, int(setting.parameter / 10)), fixedAt(lyingAt({})));
	const double reach = a - peg - 0.0005;
	const std::size_t body = stage.add(torusSolid(ring, tube, parameterCount(setting)),
									   movingAt(1, lyingAt({reach * std::sin(start), -reach * std::cos(start), 0})));
	const Swing swing = watchSwing(stage, expected, 3,
								   [&] { return std::atan2(stage.place(body).x, -stage.place(body).y); });
	return {relativeTo(expected, swing.period.mean()), amount(std::max(0.0, swing.growth))};
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

Readings cradle(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting);
	stage.setGravity({});
	stage.scene().world.restitution = 1;
	const Solid ball = ballSolid(0.5, parameterCount(setting));
	std::vector<std::size_t> balls;
	for (int i = 0; i < 5; ++i)
		balls.push_back(stage.add(ball, movingAt(1, {{i == 0 ? -2.0 : 1.001 * (i - 1), 0, 0}}, {i == 0 ? 3.0 : 0, 0, 0})));
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
	const double expected = 2 * kPi * std::sqrt(inertia / (kGravity * reach));
	return besidePrimitive(workshop, setting,
						   [&](const Setting& one) -> Readings
						   {
							   Stage stage(workshop, one);
							   const double start = 3 * kDegree;
							   Pose pose = turnedAbout({0, 0, 1}, start);
							   pose.position = toTransform(pose) * Vec3{0, -reach, 0};
							   BodyDefinition rod = movingAt(1, pose);
							   rod.joints = {{BodyJoint::Kind::hinge, {0, 0, 0}, {0, 0, 1}, {}}};
							   const std::size_t body = stage.add(boxSolid({width, height, width}), rod);
							   const Swing swing = watchSwing(stage, expected, 5, [&]
															  { return std::atan2(stage.place(body).x, -stage.place(body).y); });
							   return {relativeTo(expected, swing.period.mean())};
						   });
}

// A coin set rolling on its rim, as in the scene spinning-plate.
Readings coin(Workshop& workshop, const Setting& setting)
{
	Stage stage(workshop, setting, "spinning-plate", 0.25, {"floor", "plate"});
	double lowest = stage.energy(), risen = 0;
	const double start = lowest;
	stage.watch(3,
				[&]
				{
					const double energy = stage.energy();
					lowest = std::min(lowest, energy);
					risen = std::max(risen, energy - lowest);
					return true;
				});
	return {amount(risen / start)};
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
	const std::size_t peg = stage.add(boxSolid({width, 1, width}, 300), movingAt(1, {{0.3 * clearance, 0.501, -0.2 * clearance}}));
	stage.seconds(0.3);
	const double time = stage.state().time;
	return {relativeTo(kGravity * time * (time + setting.dt()) / 2, 0.501 - stage.place(peg).y)};
}
}  // namespace

std::vector<Row> analyticRows()
{
	const Bound same{0};
	const std::vector<Limit> rollingLimits = {
		{"what has facets rolls as a polygon, each facet that lands is an impact; Bullet's hulls feel them less", anyRun, "speed"},
		{"at 1/60 s what turns by about a facet a step loses more than the polygon does", largeSteps, "beside a polygon's"}};
	std::vector<Limit> roundLimits = rollingLimits;
	roundLimits.push_back({"coarse levels have coarse facets", coarseLevels, "beside a polygon's"});
	const std::vector<Quantity> rolling = {{"speed", "share", {0.01, 1, 0.01}}, {"beside a polygon's", "share", {0.03, 1}}};
	std::vector<Row> rows;
	rows.push_back({"A1", "free fall for 2 s", "g t (t + dt) / 2; to the bit as the primitive", "", {}, kRates,
					{{"way", "share", {1e-5, 1}}, {"beside the primitive", "m", same}}, freeFall, {}, true});
	rows.push_back({"A2", "the slope that a cube slips on", "atan mu", "", triangles({12, 1200}), kRates,
					{{"angle", "degrees", {0.5, 2}}}, slipAngle});
	rows.push_back({"A3", "a cube slides down 30 degrees", "g (sin - mu cos) t", "", triangles({12, 1200}), kRates,
					{{"speed", "share", {0.03, 1.5}}}, slidingDown, {}, true});
	rows.push_back({"A4", "a cube slides to a stop", "v^2 / (2 mu g)", "", triangles({12, 1200}), kRates,
					{{"way", "share", {0.03, 1.5}}}, slidingStop, {}, true});
	rows.push_back({"A5a", "a ball rolls down 15 degrees", "5/7 g sin t, as the hull + 1 %; a rolling polygon (McGeer 1990)", "", triangles({432, 1728}), kRates,
					rolling, rollingBall, roundLimits});
	rows.push_back({"A5b", "a cylinder rolls down 15 degrees", "2/3 g sin t, as the hull + 1 %; a rolling polygon", "", sides({24, 96}), kRates,
					rolling, rollingCylinder, rollingLimits});
	rows.push_back({"A5c", "a torus rolls down 15 degrees", "g sin t / (1 + I / m r^2), as GImpact + 1 %; a rolling polygon", "",
					triangles({480, 1920}), kRates, rolling, rollingTorus, roundLimits});
	rows.push_back({"A6", "a ball slides, then rolls", "5/7 v", "", triangles({300, 1200}), kRates,
					{{"speed", "share", {0.02, 1, 0.02}}}, slidingThenRolling,
					{{"facets brake it, as in A5", anyRun, ""}}});
	rows.push_back({"A7", "a ball bounces", "height e^2; no energy gained in 20 s", "",
					{{1, "e = 1"}, {0.5, "e = 0.5"}, {0, "e = 0"}}, kRates,
					{{"height", "of the drop's", {0.01, 1}}, {"energy gained", "share", {0.02, 1}}}, bounce,
					{{"what has facets and turns gains some per cent of energy in perfectly elastic bounces",
					  [](const Setting& one) { return one.parameter == 1; }, "energy gained"}}, true});
	rows.push_back({"A8", "two balls collide off centre", "momenta are kept", "", triangles({300, 1200}), kRates,
					{{"momentum", "share", {1e-5}}, {"angular momentum", "share", {1e-4, 1}}, {"missed", "", {0}}},
					obliqueCollision,
					{{"friction of a contact that is made ahead acts at two places, as with Bullet's solids", anyRun, "angular momentum"}}, true});
	rows.push_back({"A9", "a box tumbles freely about its middle axis", "to the bit as the primitive of the same inertia", "", {},
					kRates, {{"energy", "share", {HUGE_VAL}}, {"beside the primitive", "J", same}}, tumbling, {}, true});
	rows.push_back({"A10", "a wheel on its axle goes round", "m g l / (I w); as the primitive", "", {}, kRates,
					{{"angle", "share", {0.05, 2}}}, precession});
	rows.push_back({"A11", "the slope that a block topples on", "atan(width / height)", "", triangles({12, 1200}), kRates,
					{{"angle", "degrees", {0.5, 1}}}, toppling});
	rows.push_back({"A12", "a block rocks (Housner 1963)", "4/p acosh(1 / (1 - lean / angle)); (1 - 1.5 sin^2)^2", "",
					triangles({12, 1200}), kRates,
					{{"period", "share", {0.03, 1}}, {"energy after the impact", "share", {0.1, 1}}}, rockingBlock});
	rows.push_back({"A13", "a ball swings in a bowl", "2 pi sqrt(7 (R - r) / 5 g), for 20 degrees", "", triangles({3600, 7200}), kGimpactRates,
					{{"period", "share", {0.02, 1}}, {"amplitude lost", "share", {0.05, 2}}, {"amplitude gained", "share", {0.01, 1}}},
					ballInBowl,
					{{"facets brake it, as in A5", anyRun, "amplitude lost"},
					 {"facets change its period by some per cent; at 1/60 s and on coarse levels it may stop on one", anyRun, "period"}}});
	rows.push_back({"A14", "a torus swings on a round peg", "2 pi sqrt((a - rho) (1 + I / m a^2) / g), for 20 degrees", "",
					triangles({960, 1920}), kGimpactRates,
					{{"period", "share", {0.02, 1}}, {"amplitude gained", "share", {0.01, 1}}}, torusOnPeg,
					{{"coarse levels have coarse facets", coarseLevels, ""}}});
	rows.push_back({"A15", "a torus lies on a floor", "height = that of its middle over its lowest corners; 2e-5 m a minute", "", triangles({480, 1280}),
					kGimpactRates, {{"height", "share", {1e-3, 1}}, {"drift", "m/minute", {2e-5, 2}}}, restingTorus,
					{{"a coarse level lies off by its deviation, and moves when it changes", coarseLevels, ""}}, true});
	rows.push_back({"A16", "a torus falls down a peg without friction", "g t^2 / 2", "", triangles({480, 1280}), kGimpactRates,
					{{"way", "share", {0.01}}}, torusDownPeg});
	rows.push_back({"A17", "a puck slides half round a tube", "v exp(-mu angle); of a polygon v (cos - mu sin)^sides", "",
					sides({48, 192}), kRates, {{"speed", "share", {0.05, 1}}, {"beside a polygon's", "share", {0.05, 1}}}, puckInTube});
	rows.push_back({"A18", "Newton's cradle of five balls", "momentum kept, no energy gained", "", triangles({300, 1200}), kRates,
					{{"momentum", "share", {1e-5}}, {"energy gained", "share", {0.01, 1}}, {"speed of the last", "share", {0.05, 1}}},
					cradle});
	rows.push_back({"A19", "a rod swings about an ideal axle", "2 pi sqrt(I / m g l); to the bit as the primitive", "", {}, kRates,
					{{"period", "share", {0.01}}, {"beside the primitive", "s", same}}, freePendulum, {}, true});
	rows.push_back({"A20", "a coin rolls on its rim", "its energy never rises", "", {}, kRates,
					{{"energy risen", "share", {0.01, 1}}}, coin});
	rows.push_back({"A21", "a peg falls into a hole wider by a clearance", "g t^2 / 2", "",
					{{0.02, "20 mm"}, {0.002, "2 mm"}, {0.001, "1 mm"}, {0.0005, "0.5 mm"}}, kRates, {{"way", "share", {0.01}}}, pegInHole,
					{{"a clearance under 0.1 % of the radius can jam at the rim",
					  [](const Setting& one) { return one.parameter < 0.001; }, ""}}});
	return rows;
}
}  // namespace clod::demo
