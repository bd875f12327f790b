// SPDX-License-Identifier: GPL-3.0-or-later
// The families themselves.
#include <cmath>
#include <stdexcept>

#include "demos/models/Models.h"
#include "tests/oracle/Families.h"

namespace clod::oracle
{
namespace
{
constexpr double kPi = 3.14159265358979323846, kDegree = kPi / 180;
const Vec3 kDown{0, -1, 0};

Mat3 aboutY(double angle)
{
	return rotationFromQuaternion(0, std::sin(0.5 * angle), 0, std::cos(0.5 * angle));
}
Mat3 aboutX(double angle)
{
	return rotationFromQuaternion(std::sin(0.5 * angle), 0, 0, std::cos(0.5 * angle));
}
TriangleMesh upsideDown(const TriangleMesh& mesh)
{
	return moved(mesh, {aboutX(kPi), {}});
}

// A stands at `at` in B's frame, turned by `turned`.
Start standing(const Mat3& turned, const Vec3& at, const Vec3& approachInB, double travel)
{
	const Transform aFromB = inverse(Transform{turned, at});
	return {aFromB, normalized(aFromB.rotation * approachInB), travel};
}
Start onCourse(Start start, const Vec3& linear, const Vec3& angular)
{
	start.course = {linear, angular, 0};
	return start;
}
Vec3 nearDown(Random& random, double spread)
{
	const Vec3 aside = direction(random);  // drawn before its share, whoever compiled this
	return normalized(kDown + spread * uniform(random, 0, 1) * aside);
}

TriangleMesh model(const std::string& name, std::size_t triangles)
{
	auto made = demo::makeModel(name, triangles);
	if (!made) throw std::runtime_error(made.error());
	TriangleMesh mesh;
	mesh.vertices = made->vertices;
	for (const auto& t : made->triangles) mesh.triangles.push_back({t[0], t[1], t[2]});
	return mesh;
}
TriangleMesh unitModel(const std::string& name, std::size_t triangles)
{
	const TriangleMesh mesh = model(name, triangles);
	return scaled(mesh, 1 / Solid(mesh).radius());
}

// Pin with a flange in the hole of an arm's end.
std::vector<BodyPair> pinPairs()
{
	const TriangleMesh pin =
		turned({{0, 0.7}, {0, -0.5}, {0.3, -0.5}, {0.3, 0.5}, {0.5, 0.5}, {0.5, 0.7}}, 24);
	const TriangleMesh arm = turned({{0.31, -0.25}, {0.9, -0.25}, {0.9, 0.25}, {0.31, 0.25}}, 24);
	return {{pin, arm}};
}
Start pinStart(Random& random, std::size_t)
{
	const double side = uniform(random, 0, 1);
	const double height = side < 0.5 ? uniform(random, -0.24, -0.15) : uniform(random, -0.1, 0.2);
	const Mat3 about = aboutY(uniform(random, 0, kPi));
	const Mat3 turn = rotation(random, 0.008) * about;
	const Vec3 at{uniform(random, -0.003, 0.003), height, uniform(random, -0.003, 0.003)};
	return onCourse(standing(turn, at, direction(random), 0.15), {}, {0, 1, 0});
}

// Teeth between -1 and 1 of a rack, and a gear that meshes with it.
TriangleMesh rack(int teeth, double pitch, double height)
{
	std::vector<Point2> profile;
	for (int i = -teeth; i <= teeth; ++i)
		for (const double x : {-0.32, -0.15, 0.15, 0.32})
			profile.push_back({(i + x) * pitch, std::fabs(x) < 0.2 ? height : 0});
	return ridges(profile, -0.3, 0.3);
}
TriangleMesh gear(int teeth, double pitch, double height)
{
	std::vector<double> radii;
	const double root = teeth * pitch / (2 * kPi) - 0.5 * height;
	for (int i = 0; i < 8 * teeth; ++i) radii.push_back(root + (i % 8 == 0 || i % 8 == 1 || i % 8 == 7 ? height : 0));
	return prism(radii, 0.25);
}
constexpr double kPitch = 0.45, kTooth = 0.22;
constexpr int kTeeth = 12;
std::vector<BodyPair> rackPairs()
{
	return {{gear(kTeeth, kPitch, kTooth), rack(3, kPitch, kTooth)}};
}
Start rackStart(Random& random, std::size_t)
{
	const double pitchRadius = kTeeth * kPitch / (2 * kPi), roll = uniform(random, -1, 1) * kPitch;
	const double angle = -roll / pitchRadius - 0.5 * kPi + kPi / kTeeth + uniform(random, -0.05, 0.05);
	const Mat3 turn = rotationFromQuaternion(0, 0, std::sin(0.5 * angle), std::cos(0.5 * angle));
	const Vec3 at{roll, pitchRadius + 0.5 * kTooth + uniform(random, 0.01, 0.08), uniform(random, -0.02, 0.02)};
	const double side = uniform(random, 0, 2 * kPi);
	const Start start = standing(turn, at, {std::cos(side), std::sin(side), 0.1 * uniform(random, -1, 1)}, 0.3);
	return onCourse(start, -pitchRadius * (start.aFromB.rotation * Vec3{1, 0, 0}), {0, 0, 1});
}

std::vector<BodyPair> threadPairs()
{
	const double scale = 1 / demo::NUT_RADIUS;
	return {{scaled(model("nut", 1800), scale), scaled(model("bolt", 3000), scale)}};
}
Start threadStart(Random& random, std::size_t)
{
	const double scale = 1 / demo::NUT_RADIUS, height = uniform(random, 0.016, 0.034);
	const Mat3 turn = aboutY(-2 * kPi * height / demo::THREAD_LEAD);
	return onCourse(standing(turn, {0, scale * height, 0}, direction(random), 0.1),
					{0, scale * demo::THREAD_LEAD / (2 * kPi), 0}, {0, -1, 0});
}

// A cup of `radius` and wall 0.06.
TriangleMesh shell(double radius)
{
	const double in = radius - 0.06;
	return turned({{0, 0.06}, {0, 0}, {0.8 * radius, 0}, {radius, 1}, {in, 1}, {0.8 * radius - 0.06, 0.06}}, 32);
}
std::vector<BodyPair> shellPairs()
{
	return {{shell(0.62), shell(0.7)}, {torus(0.5, 0.1, 32, 12), shell(0.7)}};
}
Start shellStart(Random& random, std::size_t pair)
{
	const Mat3 about = aboutY(uniform(random, 0, kPi));
	const Mat3 turn = rotation(random, 0.03) * about;
	const Vec3 way = nearDown(random, pair == 1 ? 0.3 : 0.7);
	if (pair == 1) return standing(turn, {0, uniform(random, 0.9, 1.2), 0}, way, 1.2);
	return standing(turn, {0, uniform(random, 0.1, 0.3), 0}, way, 0.5);
}

std::vector<BodyPair> chainPairs()
{
	return {{torus(0.75, 0.2, 64, 24), torus(0.75, 0.2, 64, 24)}};
}
Start chainStart(Random& random, std::size_t)
{
	const Mat3 about = aboutY(uniform(random, 0, kPi));
	const Mat3 turn = rotation(random, 0.6) * aboutX(0.5 * kPi) * about;
	const Mat3 before = aboutY(uniform(random, 0, 2 * kPi));
	const Vec3 at = before * Vec3{0.75 + uniform(random, -0.2, 0.2), uniform(random, -0.1, 0.1), 0};
	return standing(before * turn, at, direction(random), 0.8);
}

const double kWedges[] = {20, 30, 40, 50, 60, 70, 90};
std::vector<BodyPair> wedgePairs()
{
	std::vector<BodyPair> pairs;
	for (const double angle : kWedges)
	{
		const TriangleMesh mesh = wedge(angle * kDegree, 1, 1);
		pairs.push_back({upsideDown(mesh), mesh});
	}
	return pairs;
}
Start crossedStart(Random& random, std::size_t)
{
	const Mat3 about = aboutY(uniform(random, 20, 90) * kDegree);
	const Mat3 turn = rotation(random, 0.1) * about;
	return standing(turn, {uniform(random, -0.5, 0.5), 0.25, uniform(random, -0.5, 0.5)}, kDown, 0.6);
}
Start parallelStart(Random& random, std::size_t)
{
	const double kind = uniform(random, 0, 3);
	const Mat3 turn = aboutY(kind < 1 ? 0 : uniform(random, -0.03, 0.03));
	const double beside = kind < 2 ? 0 : uniform(random, -0.02, 0.02);
	return standing(turn, {beside, 0.05, uniform(random, -0.8, 0.8)}, kDown, 0.4);
}

// Two boxes flush beside each other, 0.001 apart.
std::vector<BodyPair> seamPairs()
{
	const TriangleMesh half = box({1.2, 0.3, 1.2});
	return {{box({0.5, 0.5, 0.5}), joined(half, half, {2.401, 0, 0})}};
}
Start seamStart(Random& random, std::size_t)
{
	const Mat3 upright = aboutY(uniform(random, 0, kPi));
	const Mat3 turn = rotation(random, uniform(random, 0, 1) < 0.5 ? 0 : 0.05) * upright;
	return standing(turn, {1.2 + uniform(random, -0.7, 0.7), 0.9, uniform(random, -0.6, 0.6)}, kDown, 0.6);
}

std::vector<BodyPair> ridgePairs()
{
	std::vector<BodyPair> pairs;
	for (const double angle : {110, 130, 150})
	{
		const TriangleMesh mesh = wedge(angle * kDegree, 0.35, 1);
		pairs.push_back({upsideDown(mesh), mesh});
	}
	return pairs;
}
Start ridgeStart(Random& random, std::size_t)
{
	const Mat3 about = aboutY(uniform(random, -0.5, 0.5) * kPi);
	const Mat3 turn = rotation(random, 0.05) * about;
	const Vec3 way = nearDown(random, 0.5);
	return standing(turn, {uniform(random, -0.3, 0.3), 0.2, uniform(random, -0.5, 0.5)}, way, 0.6);
}

std::vector<BodyPair> valleyPairs()
{
	const TriangleMesh valley = ridges({{-1, 0.8}, {-0.8, 0.8}, {0, 0}, {0.8, 0.8}, {1, 0.8}}, -0.3, 1);
	return {{upsideDown(wedge(70 * kDegree, 0.7, 0.8)), valley},
			{upsideDown(wedge(90 * kDegree, 0.7, 0.8)), valley},
			{box({0.4, 0.4, 0.4}), valley}};
}
Start valleyStart(Random& random, std::size_t pair)
{
	const Mat3 about = aboutY(pair == 2 ? uniform(random, 0, kPi) : 0);
	const Mat3 turn = rotation(random, 0.05) * about;
	const Vec3 way = nearDown(random, 0.5);
	return standing(turn, {uniform(random, -0.1, 0.1), pair == 2 ? 1.4 : 0.25, uniform(random, -0.3, 0.3)}, way, 1.2);
}

std::vector<BodyPair> ledgePairs()
{
	const TriangleMesh step = ridges({{-1.2, 0}, {0, 0}, {0.001, 0.5}, {1.2, 0.5}}, -0.3, 1);
	return {{box({0.4, 0.3, 0.35}), step}};
}
Start ledgeStart(Random& random, std::size_t)
{
	const Mat3 about = aboutY(uniform(random, 0, kPi));
	const Mat3 turn = rotation(random, 0.4) * about;
	const double side = uniform(random, -0.6, 0.5);
	const Vec3 approach = normalized(Vec3{uniform(random, -0.2, 1), uniform(random, -1, -0.1), 0});
	return standing(turn, {side, side > -0.6 ? 1.1 : 0.7, uniform(random, -0.4, 0.4)}, approach, 1.5);
}

// Corners of cubes: their edges lean by 54.7 degrees against the axis.
std::vector<BodyPair> cornerPairs()
{
	const double steep = 1 / std::sqrt(2.0);
	return {{upsideDown(spike(3, 0.6, 0.6 * steep)), pit(3, 1, steep, 0.3)}};
}
Start cornerStart(Random& random, std::size_t)
{
	const Mat3 upright = aboutY(uniform(random, 0, 1) < 0.3 ? 0 : uniform(random, -0.1, 0.1));
	const Mat3 turn = rotation(random, 0.06) * upright;
	// Upside down about x the triangle's corners lie at the same turns.
	const Vec3 way = nearDown(random, 0.6);
	return standing(turn, {uniform(random, -0.1, 0.1), 0.3, uniform(random, -0.1, 0.1)}, way, 0.6);
}

std::vector<BodyPair> tetrahedronPairs()
{
	const TriangleMesh needle = spike(3, 0.25, 1.2), flat = spike(3, 1, 0.3);
	return {{needle, needle}, {needle, flat}};
}
Start anyStart(Random& random, std::size_t)
{
	const Mat3 turn = rotation(random, 2 * kPi);
	const Vec3 from = direction(random);
	const double share = 0.5 * uniform(random, 0, 1);
	return standing(turn, 2.4 * from, share * direction(random) - 1.5 * from, 2.8);
}

std::vector<BodyPair> spikePairs()
{
	return {{upsideDown(spike(4, 0.35, 0.9)), pit(4, 0.9, 0.7, 0.3)},
			{upsideDown(spike(8, 0.2, 0.9)), pit(4, 0.9, 0.7, 0.3)}};
}
Start spikeStart(Random& random, std::size_t)
{
	const Mat3 about = aboutY(uniform(random, 0, kPi));
	const Mat3 turn = rotation(random, 0.15) * about;
	const Vec3 way = nearDown(random, 0.4);
	return standing(turn, {uniform(random, -0.3, 0.3), 0.7, uniform(random, -0.3, 0.3)}, way, 0.9);
}

std::vector<BodyPair> modelPairs()
{
	const TriangleMesh cup = unitModel("cup", 4000), spoon = unitModel("spoon", 4000), ring = unitModel("torus", 6000),
					   bowl = unitModel("bowl", 4000);
	return {{spoon, cup}, {ring, bowl}, {cup, cup}, {ring, ring}, {spoon, bowl}};
}

std::vector<BodyPair> mixedPairs()
{
	const TriangleMesh slab = box({10, 0.5, 10});
	return {{scaled(torus(0.75, 0.25, 24, 12), 0.1), unitModel("cup", 1200)},
			{scaled(box({0.5, 0.5, 0.5}), 0.1), slab},
			{scaled(spike(3, 0.5, 1), 0.2), torus(0.75, 0.25, 24, 12)}};
}
Start mixedStart(Random& random, std::size_t pair)
{
	if (pair != 1) return anyStart(random, pair);
	const Mat3 turn = rotation(random, uniform(random, 0, 1) < 0.5 ? 0.05 : 3.1);
	return standing(turn, {uniform(random, -8, 8), 0.7, uniform(random, -8, 8)}, kDown, 0.4);
}

std::vector<BodyPair> overlapPairs()
{
	const TriangleMesh cube = box({0.58, 0.58, 0.58}), ring = torus(0.75, 0.25, 24, 12);
	return {{cube, cube}, {ring, unitModel("bowl", 1000)}, {cube, torus(0.75, 0.25, 24, 12)}};
}
}  // namespace

const std::vector<Family>& families()
{
	static const std::vector<Family> all = {
		{"pin-in-hole", "a flanged pin in the hole of an arm, 24 sides, play 0.01", pinPairs, pinStart},
		{"rack", "a gear of 12 teeth on a rack", rackPairs, rackStart},
		{"thread", "a nut on a bolt's thread", threadPairs, threadStart},
		{"nested-shells", "a cup in a cup, a ring in a cup", shellPairs, shellStart},
		{"chain-links", "two interlocked rings", chainPairs, chainStart},
		{"wedges-crossed", "edge on edge at 20 to 90 degrees, wedges of 20 to 90 degrees", wedgePairs, crossedStart},
		{"wedges-parallel", "edge on edge, parallel or nearly", wedgePairs, parallelStart},
		{"box-on-seam", "a box with yaw on two flush boxes that are one body", seamPairs, seamStart},
		{"ridge-on-ridge", "obtuse ridges at any yaw", ridgePairs, ridgeStart},
		{"valley", "wedges and a box in a valley of 90 degrees", valleyPairs, valleyStart},
		{"ledge", "a box at a step's edge and inner corner", ledgePairs, ledgeStart},
		{"corner-in-corner", "a cube's corner in the inner corner of three walls", cornerPairs, cornerStart},
		{"acute-tetrahedra", "needles and flat tetrahedra in any position", tetrahedronPairs, anyStart},
		{"spike-in-pit", "pyramids in a pyramid's pit", spikePairs, spikeStart},
		{"models", "cup, spoon, torus and bowl of about 1,000 triangles in any position", modelPairs, anyStart},
		{"mixed-sizes", "a tenth to a hundredth of the other's size", mixedPairs, mixedStart},
		{"overlap", "boxes and rings 2 to 100 % of the radius deep", overlapPairs, anyStart, true}};
	return all;
}
}  // namespace clod::oracle
