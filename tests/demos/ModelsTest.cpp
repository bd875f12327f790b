// SPDX-License-Identifier: GPL-3.0-or-later
// The benchmark models: counts, topology, triangle quality, size, fit; and each measure failing on a planted fault.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include "demos/models/Models.h"
#include "tests/demos/MeshFacts.h"
#include "tests/support/Files.h"
#include "tests/support/NamedTests.h"

namespace clod::demo::test
{
using clod::test::readText;
using clod::test::TemporaryFolder;

namespace
{
constexpr double PI = 3.14159265358979323846;
constexpr double SQUARE_ROOT_OF_EPSILON = 1.5e-8;

ModelMesh builtAfresh(const std::string& name, size_t triangles)
{
	auto mesh = makeModel(name, triangles);
	EXPECT_TRUE(mesh) << mesh.error();
	return mesh ? *mesh : ModelMesh{};
}

// Built once for all tests.
const ModelMesh& built(const std::string& name, size_t triangles = 0)
{
	static std::map<std::pair<std::string, size_t>, ModelMesh> meshes;
	const auto key = std::make_pair(name, triangles == 0 ? paperTriangleCount(name) : triangles);
	const auto entry = meshes.find(key);
	return entry != meshes.end() ? entry->second : meshes.emplace(key, builtAfresh(name, triangles)).first->second;
}

// A quarter of the paper's triangles; digits have a minimum.
size_t coarseCount(const std::string& name)
{
	return std::max<size_t>(name.compare(0, 6, "number") == 0 ? 540 : 300, paperTriangleCount(name) / 4);
}

std::vector<std::string> allNames()
{
	std::vector<std::string> names = modelNames();
	names.insert(names.end(), testShapeNames().begin(), testShapeNames().end());
	return names;
}

int genus(const std::string& name)
{
	static const std::map<std::string, int> holes = {
		{"cup", 1},          {"torus", 1},   {"smooth-torus", 1}, {"nut", 1},       {"number0", 1},
		{"number4", 1},      {"number6", 1}, {"number8", 2},      {"number9", 1},   {"arm", 1},
		{"arm-with-pin", 1}, {"rod", 2},     {"bore", 1},         {"chain-link", 1}};
	const auto entry = holes.find(name);
	return entry == holes.end() ? 0 : entry->second;
}

bool sameBytes(const ModelMesh& a, const ModelMesh& b)
{
	return a.vertices.size() == b.vertices.size() && a.triangles == b.triangles &&
		   std::memcmp(a.vertices.data(), b.vertices.data(), a.vertices.size() * sizeof(Vec3)) == 0;
}
}  // namespace

TEST(Models, CountsAreThePapers)
{
	const std::map<std::string, size_t> table = {
		{"cup", 64000}, {"spoon", 86016}, {"spiral", 32160}, {"torus", 32000}, {"bowl", 12288}};
	for (const auto& [name, count] : table) EXPECT_EQ(built(name).triangles.size(), count) << name;
	size_t digits = 0;
	for (int digit = 0; digit < 10; ++digit)
	{
		const size_t count = built("number" + std::to_string(digit)).triangles.size();
		EXPECT_NEAR(double(count), 1080, 0.03 * 1080) << digit;
		digits += count;
	}
	EXPECT_NEAR(double(digits) / 10, 1080, 10);
}

// One process a model, which builds it once for all that is asked of every model.
class EachModel : public testing::TestWithParam<std::string>
{
};

void expectAClosedManifoldOfTheRightGenus(const std::string& name)
{
	for (const size_t wanted : {coarseCount(name), paperTriangleCount(name)})
	{
		const ModelMesh& mesh = built(name, wanted);
		EXPECT_EQ(manifoldFault(mesh), "") << wanted;
		EXPECT_EQ(pieceCount(mesh), 1u);
		EXPECT_EQ(eulerCharacteristic(mesh), 2 - 2 * genus(name)) << wanted;
		EXPECT_GT(volume(mesh), 0);
		EXPECT_NEAR(double(mesh.triangles.size()), double(wanted), std::max(12.0, 0.1 * double(wanted)));
	}
}

void expectNoIntersections(const std::string& name)
{
	for (const size_t wanted : {std::max<size_t>(1000, paperTriangleCount(name) / 16), paperTriangleCount(name)})
		EXPECT_FALSE(intersectsItself(built(name, wanted))) << wanted;
}

// Mechanisms that have some still; each leaves the list with its slivers.
const std::set<std::string> kWithSlivers = {"piston", "tumbler", "dish"};

void expectNoSlivers(const std::string& name)
{
	const ModelMesh& mesh = built(name);
	if (kWithSlivers.count(name) > 0)
	{
		EXPECT_TRUE(worstAspect(mesh) >= 12 || double(aspectsOver(mesh, 6)) >= 0.01 * double(mesh.triangles.size()))
			<< "has none any more: take it off the list";
		return;
	}
	EXPECT_LT(worstAspect(mesh), 12);
	EXPECT_LT(double(aspectsOver(mesh, 6)), 0.01 * double(mesh.triangles.size()));
	const double size = length(highCorner(mesh) - lowCorner(mesh));
	EXPECT_GT(smallestHeight(mesh), 1e-4 * size);
}

// What results were measured on: volume, surface, and how far vertices are from the origin in the mean, in metres.
void expectThatOfTheResults(const std::string& name)
{
	static const std::map<std::string, std::array<double, 3>> expected = {
		{"cup", {7.766615e-05, 0.05113453, 0.05562573}},
		{"spoon", {3.551442e-06, 0.004408569, 0.07445073}},
		{"spiral", {3.9021e-05, 0.01453913, 0.1173625}},
		{"torus", {1.099319e-05, 0.00418355, 0.01608707}},
		{"bowl", {5.434568e-05, 0.03719491, 0.0412937}},
		{"number0", {6.292386e-07, 0.0006178162, 0.006976343}},
		{"number1", {4.646788e-07, 0.0004598096, 0.00674177}},
		{"number2", {5.772636e-07, 0.0005807581, 0.007358853}},
		{"number3", {5.61984e-07, 0.0005631261, 0.006921344}},
		{"number4", {5.646214e-07, 0.0005214085, 0.005904317}},
		{"number5", {5.948956e-07, 0.0005986353, 0.00699887}},
		{"number6", {6.318955e-07, 0.0005935696, 0.006606013}},
		{"number7", {4.314033e-07, 0.0004412172, 0.007099993}},
		{"number8", {7.370813e-07, 0.0006800794, 0.0068196}},
		{"number9", {6.317579e-07, 0.0005937051, 0.006585022}},
		{"bolt", {5.02593e-06, 0.002786042, 0.02382054}},
		{"nut", {1.356244e-06, 0.00122725, 0.007466604}},
		{"slab", {0.0008, 0.096, 0.08423344}},
		{"floor", {0.0008, 0.096, 0.08767261}},
		{"box", {8e-06, 0.0024, 0.01286664}},
		{"sphere", {4.143774e-06, 0.001250086, 0.01}},
		{"smooth-torus", {1.07265e-05, 0.003646447, 0.0160863}},
		{"landscape", {0.12, 8.280154, 0.7774461}},
		{"pin", {0.006887052, 0.299803, 0.122889}},
		{"arm", {0.03681576, 1.100293, 0.3620177}},
		{"arm-with-pin", {0.04185356, 1.250672, 0.6045473}},
		{"crank", {0.0375968, 1.145284, 0.2934638}},
		{"rod", {0.02720438, 0.9315795, 0.4622842}},
		{"piston", {0.1250376, 1.790358, 0.3605678}},
		{"bore", {0.059328, 2.17536, 0.4115625}},
		{"rack", {3.081499e-05, 0.01275553, 0.04319219}},
		{"pinion", {9.790911e-06, 0.004322766, 0.01767188}},
		{"chain-link", {1.327323e-06, 0.001084596, 0.01047616}},
		{"tumbler", {1.701074e-05, 0.02162017, 0.03647357}},
		{"dish", {3.156355e-05, 0.02185366, 0.06177644}},
		{"plate", {8.481137e-06, 0.006219558, 0.02848287}},
		{"peg", {3.397419e-06, 0.00194866, 0.01049334}},
		{"block", {1.2e-05, 0.0032, 0.0200778}},
		{"socket", {2.56158e-05, 0.007944, 0.02263666}},
		{"wedge20", {2.821232e-06, 0.002047867, 0.01718194}},
		{"wedge30", {4.287187e-06, 0.00229952, 0.01791648}},
		{"wedge40", {5.823524e-06, 0.002576213, 0.0183867}},
		{"wedge50", {7.460923e-06, 0.002884543, 0.01914425}},
		{"wedge60", {9.237604e-06, 0.003233162, 0.0198564}},
		{"wedge70", {1.120332e-05, 0.003633737, 0.02059888}},
		{"wedge80", {1.342559e-05, 0.004102491, 0.02133157}},
		{"wedge90", {1.6e-05, 0.004662742, 0.0223257}},
		{"voussoir25", {11.27103, 33.04289, 10.09546}},
		{"voussoir101", {2.78999, 21.72021, 10.07135}}};
	const ModelMesh& mesh = built(name);
	double area = 0, away = 0;
	for (const auto& t : mesh.triangles)
		area += 0.5 * length(cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]));
	for (const Vec3& v : mesh.vertices) away += length(v) / double(mesh.vertices.size());
	const std::array<double, 3> found = {volume(mesh), area, away};
	for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found[i] / expected.at(name)[i], 1, 1e-5) << i;
}

TEST_P(EachModel, IsSoundAndTheSameEveryTime)
{
	const std::string& name = GetParam();
	expectAClosedManifoldOfTheRightGenus(name);
	expectNoIntersections(name);
	expectNoSlivers(name);
	expectThatOfTheResults(name);
	EXPECT_TRUE(sameBytes(built(name, coarseCount(name)), builtAfresh(name, coarseCount(name))));
}
INSTANTIATE_TEST_SUITE_P(All, EachModel, testing::ValuesIn(allNames()), clod::test::nameOfTest);

TEST(Models, OfOtherCountsAreOthers)
{
	EXPECT_FALSE(sameBytes(built("bowl"), built("bowl", 12000)));
}

TEST(Models, ScaleByFourAndSixteen)
{
	for (const std::string name : {"cup", "spoon", "spiral", "torus", "bowl"})
		for (const size_t factor : {4, 16})
			EXPECT_EQ(built(name, factor * paperTriangleCount(name)).triangles.size(),
					  factor * paperTriangleCount(name))
				<< name;
}

TEST(Models, VolumesMeetTheClosedForms)
{
	// Inscribed meshes are smaller; the error falls with the square of the edge.
	const double torus = 2 * PI * PI * TORUS_RING_RADIUS * TORUS_TUBE_RADIUS * TORUS_TUBE_RADIUS;
	const double ball = 4.0 / 3 * PI * 1e-6;
	for (const auto& [name, exact] :
		 std::map<std::string, double>{{"smooth-torus", torus}, {"sphere", ball}, {"slab", 8e-4}, {"box", 8e-6}})
	{
		const double coarse = exact - volume(built(name, 3200)), fine = exact - volume(built(name, 12800));
		if (name == "slab" || name == "box")
			EXPECT_NEAR(coarse, 0, 1e-12 * exact) << name;
		else
			EXPECT_NEAR(coarse / fine, 4, 0.25) << name;
		EXPECT_NEAR(fine, 0, 0.01 * exact) << name;
	}
}

TEST(Models, CupHasTheStatedSizes)
{
	const ModelMesh& cup = built("cup");
	EXPECT_NEAR(lowCorner(cup).x, -CUP_OUTER_RADIUS, 1e-5);
	EXPECT_NEAR(lowCorner(cup).y, 0, 1e-9);
	EXPECT_NEAR(highCorner(cup).y, CUP_HEIGHT, 2e-4);
	// Wall: from inside vertices at half height to the outer surface, away from the handle.
	size_t checked = 0;
	for (const Vec3& v : cup.vertices)
	{
		const double radius = std::hypot(v.x, v.z);
		if (v.x > 0 || std::fabs(v.y - 0.05) > 0.02 || radius > 0.038 || ++checked % 200 != 0) continue;
		const Vec3 outside = {v.x / radius * 0.05, v.y, v.z / radius * 0.05};
		const double gap = 0.05 - radius - distanceToMesh(outside, cup);
		EXPECT_NEAR(gap, CUP_WALL, 6e-5);
	}
	EXPECT_GT(checked, 1000u);
	double opening = 1;
	for (const Vec3& v : cup.vertices)
		if (v.y > CUP_HEIGHT - 0.003) opening = std::min(opening, std::hypot(v.x, v.z));
	EXPECT_NEAR(opening, CUP_OPENING_RADIUS, 1e-4);
}

TEST(Models, SpoonIsThinAndFitsTheCup)
{
	const ModelMesh& spoon = built("spoon");
	const Vec3 low = lowCorner(spoon), high = highCorner(spoon);
	EXPECT_NEAR(high.x - low.x, SPOON_LENGTH, 2e-4);
	// Thickness in the middle of the bowl: the closest pair of vertices on its two sheets.
	double smallest = 1;
	for (const Vec3& v : spoon.vertices)
	{
		if (std::fabs(v.x - 0.023) > 0.0008 || std::fabs(v.z) > 0.0008) continue;
		for (const Vec3& w : spoon.vertices)
			if (std::fabs(w.x - v.x) < 0.0008 && std::fabs(w.z - v.z) < 0.0008 && std::fabs(w.y - v.y) > 5e-4)
				smallest = std::min(smallest, length(w - v));
	}
	EXPECT_NEAR(smallest, SPOON_BOWL_THICKNESS, 1e-4);
	// Wider nowhere than the opening; leaning from the bottom's edge over the rim, its centre of mass is inside.
	EXPECT_LT(high.z - low.z, 2 * CUP_OPENING_RADIUS - 0.02);
	const double toRim = std::hypot(2 * CUP_OPENING_RADIUS, CUP_HEIGHT - CUP_WALL);
	EXPECT_GT(SPOON_LENGTH, toRim);
	EXPECT_LT(0.55 * SPOON_LENGTH, 0.75 * toRim);
}

TEST(Models, TorusPassesAlongTheSpiralWithClearanceButNotStraight)
{
	const ModelMesh& torus = built("torus");
	const double bounding = TORUS_RING_RADIUS + TORUS_TUBE_RADIUS * (1 + TORUS_WRINKLE);
	double widest = 0;
	for (double height = 0.03; height < SPIRAL_HEIGHT - 0.03; height += 0.005)
	{
		// Axis of the ring along the rod; distance of its vertices to the rod's axis, densely sampled.
		const Vec3 y = spiralTangent(height), x = normalized(cross(y, {0, 0, 1})), z = cross(x, y);
		const Vec3 centre = spiralAxis(height);
		double clearance = 1;
		for (size_t i = 0; i < torus.vertices.size(); i += 7)
		{
			const Vec3& v = torus.vertices[i];
			const Vec3 p = centre + v.x * x + v.y * y + v.z * z;
			for (double h = height - 0.015; h < height + 0.015; h += 0.0005)
				clearance = std::min(clearance, length(p - spiralAxis(h)) - SPIRAL_ROD_RADIUS);
		}
		EXPECT_GE(clearance, 2 * 0.035 * bounding) << height;
		widest = std::max(widest, std::hypot(centre.x, centre.z) + SPIRAL_ROD_RADIUS);
	}
	EXPECT_GT(widest, TORUS_RING_RADIUS - TORUS_TUBE_RADIUS * (1 - TORUS_WRINKLE));
	// The peg's mesh is the tube round that axis.
	const ModelMesh& peg = built("spiral");
	for (double height = 0.06; height < 0.2; height += 0.02)
		EXPECT_NEAR(distanceToMesh(spiralAxis(height), peg), SPIRAL_ROD_RADIUS, 5e-5);
	EXPECT_NEAR(highCorner(peg).y, SPIRAL_HEIGHT, 1e-5);
}

TEST(Models, TorusHasFortyWavesOfFivePercent)
{
	const ModelMesh& torus = built("torus");
	double low = 1, high = 0;
	for (const Vec3& v : torus.vertices)
	{
		const double tube = std::hypot(std::hypot(v.x, v.z) - TORUS_RING_RADIUS, v.y);
		low = std::min(low, tube);
		high = std::max(high, tube);
	}
	EXPECT_NEAR(high, TORUS_TUBE_RADIUS * (1 + TORUS_WRINKLE), 1e-6);
	EXPECT_NEAR(low, TORUS_TUBE_RADIUS * (1 - TORUS_WRINKLE), 1e-5);
	// Crests along the outer equator: vertices higher than both neighbours on that line.
	std::map<double, double> equator;
	for (const Vec3& v : torus.vertices)
		if (v.y == 0 && std::hypot(v.x, v.z) > TORUS_RING_RADIUS) equator[std::atan2(v.z, v.x)] = std::hypot(v.x, v.z);
	std::vector<double> radii;
	for (const auto& [angle, radius] : equator) radii.push_back(radius);
	int crests = 0;
	for (size_t i = 0; i < radii.size(); ++i)
		crests += radii[i] > radii[(i + 1) % radii.size()] && radii[i] >= radii[(i + radii.size() - 1) % radii.size()];
	EXPECT_EQ(crests, TORUS_WAVES);
}

TEST(Models, DigitsAreTwentyMillimetresTall)
{
	for (int digit = 0; digit < 10; ++digit)
	{
		const ModelMesh& mesh = built("number" + std::to_string(digit));
		EXPECT_NEAR(highCorner(mesh).y - lowCorner(mesh).y, 0.020, 1.5e-4) << digit;
		EXPECT_NEAR(highCorner(mesh).z - lowCorner(mesh).z, 0.005, SQUARE_ROOT_OF_EPSILON) << digit;
	}
}

// Between wall and face a quarter circle of 0.7 mm, where the triangles are small enough to show it.
TEST(Models, DigitsHaveRoundedEdges)
{
	constexpr double kWall = 1.8e-3, kBevel = 0.7e-3;
	const ModelMesh& mesh = built("number2", 4 * paperTriangleCount("number2"));
	std::vector<Vec3> wall;
	for (const Vec3& v : mesh.vertices)
		if (std::fabs(v.z - kWall) < SQUARE_ROOT_OF_EPSILON) wall.push_back(v);
	int between = 0;
	for (const Vec3& v : mesh.vertices)
	{
		if (v.z < kWall + SQUARE_ROOT_OF_EPSILON) continue;
		double depth = kBevel;
		for (const Vec3& w : wall) depth = std::min(depth, std::hypot(w.x - v.x, w.y - v.y));
		if (depth > 0.9 * kBevel) continue;
		++between;
		const double rest = 1 - depth / kBevel;
		EXPECT_NEAR(v.z, kWall + kBevel * std::sqrt(1 - rest * rest), 0.1 * kBevel) << depth;
	}
	EXPECT_GT(between, 10);
}

TEST(Models, BadRequestsAreRefusedByName)
{
	EXPECT_NE(makeModel("teapot").error().find("\"teapot\""), std::string::npos);
	EXPECT_NE(makeModel("teapot").error().find("spoon"), std::string::npos);
	EXPECT_FALSE(makeModel("number10"));
	EXPECT_FALSE(makeModel("number"));
	EXPECT_FALSE(makeModel(""));
	EXPECT_NE(makeModel("cup", 7).error().find("7 triangles"), std::string::npos);
	EXPECT_FALSE(makeModel("cup", size_t(-1)));
	EXPECT_EQ(paperTriangleCount("teapot"), 0u);
}

TEST(Models, ObjFilesHoldEveryDigit)
{
	const ModelMesh& mesh = built("number7");
	ModelMesh read;
	std::istringstream text(toObj(mesh));
	for (std::string line; std::getline(text, line);)
	{
		Vec3 v;
		std::array<uint32_t, 3> t = {};
		if (std::sscanf(line.c_str(), "v %lf %lf %lf", &v.x, &v.y, &v.z) == 3) read.vertices.push_back(v);
		if (std::sscanf(line.c_str(), "f %u %u %u", &t[0], &t[1], &t[2]) == 3)
			read.triangles.push_back({t[0] - 1, t[1] - 1, t[2] - 1});
	}
	EXPECT_TRUE(sameBytes(read, mesh));
}

// The measures above, each shown failing.
TEST(ModelsCheckers, FindPlantedFaults)
{
	const ModelMesh& good = built("box");
	ModelMesh hole = good;
	hole.triangles.pop_back();
	EXPECT_NE(manifoldFault(hole), "");
	ModelMesh turned = good;
	std::swap(turned.triangles[5][1], turned.triangles[5][2]);
	EXPECT_NE(manifoldFault(turned), "");
	ModelMesh unused = good;
	unused.vertices.push_back({});
	EXPECT_NE(manifoldFault(unused), "");
	ModelMesh outOfRange = good;
	outOfRange.triangles[3][1] = uint32_t(good.vertices.size());
	EXPECT_NE(manifoldFault(outOfRange), "");
	// Two boxes that share one vertex: closed, but not a manifold there.
	ModelMesh pinched = good;
	for (Vec3 v : good.vertices) pinched.vertices.push_back(v + Vec3{1, 0, 0});
	const uint32_t shift = uint32_t(good.vertices.size());
	for (auto t : good.triangles)
	{
		for (uint32_t& v : t) v = v == 0 ? 0 : v + shift;
		pinched.triangles.push_back(t);
	}
	pinched.vertices[shift] = pinched.vertices.back();
	for (auto& t : pinched.triangles)
		for (uint32_t& v : t) v = v == uint32_t(pinched.vertices.size() - 1) ? shift : v;
	pinched.vertices.pop_back();
	EXPECT_NE(manifoldFault(pinched).find("fans"), std::string::npos);

	ModelMesh insideOut = good;
	for (auto& t : insideOut.triangles) std::swap(t[1], t[2]);
	EXPECT_EQ(manifoldFault(insideOut), "");
	EXPECT_LT(volume(insideOut), 0);

	ModelMesh sliver = good;
	const auto& t = sliver.triangles[0];
	sliver.vertices[t[0]] = 0.5 * (sliver.vertices[t[1]] + sliver.vertices[t[2]]);
	EXPECT_GT(worstAspect(sliver), 12);
	EXPECT_LT(smallestHeight(sliver), 1e-9);
	EXPECT_GT(aspectsOver(sliver, 6), 0u);

	ModelMesh poked = good;  // a vertex pulled through the opposite face
	poked.vertices[poked.triangles[0][0]] += Vec3{0.1, 0.1, 0.1};
	EXPECT_TRUE(intersectsItself(poked));
}
}  // namespace clod::demo::test
