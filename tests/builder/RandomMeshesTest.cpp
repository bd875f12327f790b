// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes that nobody has thought of, from a seed: sound ones of any size, place and proportion, and such with a fault
// planted. Never a crash, never an internal failure. What has a fault is refused with its first offending element; what is built
// passes the checker, and its certified errors hold for samples of both surfaces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <regex>

#include "builder/check/Check.h"
#include "builder/check/Geometry.h"
#include "clod/builder/Builder.h"
#include "tests/builder/ObjText.h"
#include "tests/support/Files.h"
#include "tests/support/Meshes.h"
#include "tests/support/Setting.h"

namespace clod::builder
{
namespace
{
using Random = std::mt19937_64;

double between(Random& random, double low, double high)
{
	return low + (high - low) * double(random() >> 11) * 0x1p-53;
}
Vec3 anyVector(Random& random)
{
	const double x = between(random, -1, 1), y = between(random, -1, 1), z = between(random, -1, 1);
	return {x, y, z};
}

void append(TriangleMesh& mesh, const TriangleMesh& other, const Vec3& at, double scale = 1)
{
	const auto first = std::uint32_t(mesh.vertices.size());
	for (const Vec3& v : other.vertices) mesh.vertices.push_back(scale * v + at);
	for (auto t : other.triangles)
	{
		for (std::uint32_t& v : t) v += first;
		mesh.triangles.push_back(t);
	}
}
void turnOver(TriangleMesh& mesh)
{
	for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
}

enum class Fault
{
	none,
	open,
	twice,
	flipped,
	fin,
	degenerate,
	tJunction,
	inverted,
	notFinite,
	index,
	crossing,
	touching,
	oneTriangle,
	nested,
	count
};

struct Start
{
	TriangleMesh mesh;
	Fault fault = Fault::none;
	bool isPlain = false;  // as a modeller would make it
};

// About the origin, about as large as one.
TriangleMesh solidOf(Random& random, bool& isConvex)
{
	const std::uint64_t kind = random() % 7;
	isConvex = kind < 3;
	const int more = int(random() % 8);
	Mesh mesh;
	switch (kind)
	{
		case 0:
			return {{{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
		case 1: mesh = test::boxMesh({1, 0.6, 0.3}, 1 + more % 3); break;
		case 2: mesh = test::sphereMesh(1, 5 + more, 4 + more / 2); break;
		case 3: mesh = test::torusMesh(1, 0.4, 7 + more, 5 + more / 2); break;
		case 4: mesh = test::wrinkledTorusMesh(1, 0.35, 0.06, 5, 20, 6); break;
		case 5:
			mesh = test::boxMesh({1, 1, 1}, 6);
			for (Vec3& v : mesh.vertices)
				if (v.z == 1) v.z += 0.2 * std::sin(4 * v.x) * std::sin(4 * v.y);
			break;
		default:
			mesh = test::sphereMesh(1, 8 + more, 6);
			for (std::size_t i = 0; i < mesh.vertices.size(); ++i) mesh.vertices[i] = (i % 2 ? 1.0 : 0.7) * mesh.vertices[i];
	}
	return {mesh.vertices, mesh.triangles};
}

void plant(Start& start, bool isConvex, Random& random)
{
	TriangleMesh& mesh = start.mesh;
	const TriangleMesh whole = mesh;
	const std::size_t at = std::size_t(random() % mesh.triangles.size());
	const std::array<std::uint32_t, 3> t = mesh.triangles[at];
	const auto added = std::uint32_t(mesh.vertices.size());
	const auto rightmost = [](const Vec3& l, const Vec3& r) { return l.x < r.x; };
	switch (start.fault)
	{
		case Fault::open: mesh.triangles.erase(mesh.triangles.begin() + std::ptrdiff_t(at)); break;
		case Fault::twice: mesh.triangles.push_back({t[1], t[2], t[0]}); break;
		case Fault::flipped: std::swap(mesh.triangles[at][0], mesh.triangles[at][1]); break;
		case Fault::fin:
			mesh.vertices.push_back(3 * anyVector(random));
			mesh.triangles.push_back({t[0], t[1], added});
			break;
		case Fault::degenerate: mesh.triangles.push_back({t[0], t[0], t[1]}); break;
		case Fault::tJunction:
			mesh.vertices.push_back(0.5 * (mesh.vertices[t[0]] + mesh.vertices[t[1]]));
			mesh.triangles[at] = {t[0], added, t[2]};
			mesh.triangles.push_back({added, t[1], t[2]});
			break;
		case Fault::inverted: turnOver(mesh); break;
		case Fault::notFinite:
			mesh.vertices[t[0]].y = std::numeric_limits<double>::infinity();
			if (random() % 2) mesh.vertices[t[0]].y = std::numeric_limits<double>::quiet_NaN();
			break;
		case Fault::index: mesh.triangles[at][2] = random() % 2 ? added : std::numeric_limits<std::uint32_t>::max(); break;
		case Fault::crossing: append(mesh, whole, {0.21, 0.17, 0.13}); break;
		case Fault::touching:
		{
			const auto [least, most] = std::minmax_element(whole.vertices.begin(), whole.vertices.end(), rightmost);
			append(mesh, whole, *most - *least);
			break;
		}
		case Fault::oneTriangle: mesh.triangles = {t}; break;
		case Fault::nested:
			if (!isConvex) start.fault = Fault::none;
			if (isConvex) append(mesh, whole, {}, 0.2);
			break;
		default: break;
	}
}

Start startOf(std::uint64_t seed)
{
	Random random(seed);
	Start start;
	bool isConvex = false;
	start.mesh = solidOf(random, isConvex);
	start.isPlain = true;
	if (random() % 2) start.fault = Fault(random() % std::uint64_t(Fault::count));
	if (isConvex && start.fault == Fault::none && random() % 3 == 0)  // a cavity
	{
		TriangleMesh inside = start.mesh;
		turnOver(inside);
		append(start.mesh, inside, {}, 0.2);
	}
	if (start.fault == Fault::none && random() % 4 == 0) append(start.mesh, TriangleMesh(start.mesh), {5, 0, 0});
	plant(start, isConvex, random);
	if (random() % 2 && start.fault != Fault::touching)  // noise; a lot of it makes surfaces cross
	{
		const double noise = std::pow(10, between(random, -9, -1));
		for (Vec3& v : start.mesh.vertices) v += noise * anyVector(random);
		start.isPlain = start.isPlain && noise < 1e-3 && noise > 1e-5;
	}
	Vec3 scale = std::pow(10, between(random, -6, 6)) * Vec3{1, 1, 1}, offset;
	if (random() % 4 == 0)  // needles and sheets
	{
		const double thin = std::pow(10, between(random, -6, 0));
		scale[int(random() % 3)] *= thin;
		start.isPlain = start.isPlain && thin > 0.1;
	}
	if (random() % 4 == 0)
	{
		offset = 1e6 * anyVector(random);
		start.isPlain = start.isPlain && scale.x > 1;
	}
	for (Vec3& v : start.mesh.vertices) v = Vec3{scale.x * v.x, scale.y * v.y, scale.z * v.z} + offset;
	return start;
}

// Over an outline all of which is seen from the origin, z from 0 to 1.
TriangleMesh prism(const std::vector<std::array<double, 2>>& outline)
{
	TriangleMesh mesh;
	const auto n = std::uint32_t(outline.size());
	for (const double z : {0.0, 1.0})
	{
		for (const auto& p : outline) mesh.vertices.push_back({p[0], p[1], z});
		mesh.vertices.push_back({0, 0, z});
	}
	for (std::uint32_t i = 0; i < n; ++i)
	{
		const std::uint32_t next = (i + 1) % n, up = n + 1;
		mesh.triangles.push_back({next, i, n});
		mesh.triangles.push_back({i + up, next + up, n + up});
		mesh.triangles.push_back({i, next, next + up});
		mesh.triangles.push_back({i, next + up, i + up});
	}
	return mesh;
}

Vec3 sampleOf(const check::Triangle& t, Random& random)
{
	double u = between(random, 0, 1), v = between(random, 0, 1);
	if (u + v > 1) u = 1 - u, v = 1 - v;
	return t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
}

// However thin the triangle: that to its sides, and to its plane where the point is over it.
double distance(const check::Triangle& t, const Vec3& p)
{
	double least = std::numeric_limits<double>::infinity();
	const Vec3 normal = cross(t[1] - t[0], t[2] - t[0]);
	bool isOver = true;
	for (std::size_t i = 0; i < 3; ++i)
	{
		const Vec3 from = t[i], along = t[(i + 1) % 3] - from;
		const double share = std::min(1.0, std::max(0.0, dot(p - from, along) / dot(along, along)));
		least = std::min(least, length(from + share * along - p));
		isOver = isOver && dot(cross(along, p - from), normal) >= 0;
	}
	return isOver ? std::min(least, std::abs(dot(normal, p - t[0])) / length(normal)) : least;
}

// Points of the input are as near to hulls, and those of faces to the input, as each level says. Empty, or where not.
std::string brokenError(const TriangleMesh& mesh, const Hierarchy& h, Random& random)
{
	const double* origin = h.asset().meshFromBody;
	std::vector<check::Triangle> input;
	for (const auto& t : mesh.triangles)
	{
		check::Triangle corners;
		for (std::size_t i = 0; i < 3; ++i) corners[i] = mesh.vertices[t[i]] - Vec3{origin[0], origin[1], origin[2]};
		input.push_back(corners);
	}
	const double room = 1e-7 * double(h.asset().radius) + 4e-16 * length({origin[0], origin[1], origin[2]});
	std::vector<Vec3> points;
	for (int i = 0; i < 60; ++i) points.push_back(sampleOf(input[std::size_t(random() % input.size())], random));
	for (std::size_t level = 0; level < h.levels().size; ++level)
	{
		const Level& all = h.levels()[level];
		std::vector<double> nearest(points.size(), std::numeric_limits<double>::infinity());
		double cover = 0;
		for (std::uint32_t n = all.firstNode; n < all.firstNode + all.nodeCount; ++n)
		{
			const Node& node = h.node(n);
			cover = std::max(cover, double(node.cover));
			std::vector<Vec3> hull;
			const Vec3 inward{double(node.inward[0]), double(node.inward[1]), double(node.inward[2])};
			for (std::uint32_t v = 0; v < node.vertexCount; ++v)
				for (const double share : {0.0, 1.0})
					hull.push_back(h.hull(node).vertex(v) + share * double(node.thickness) * inward);
			std::vector<check::Triangle> faces;
			for (const Face& face : h.faces(node))
				faces.push_back({h.hull(node).vertex(face.vertex[0]), h.hull(node).vertex(face.vertex[1]),
								 h.hull(node).vertex(face.vertex[2])});
			for (std::size_t i = 0; i < points.size(); ++i)
			{
				if (nearest[i] <= double(node.cover)) continue;
				nearest[i] = std::min(nearest[i], check::distanceToHull(hull, points[i], room, 0));
				for (const check::Triangle& face : faces) nearest[i] = std::min(nearest[i], distance(face, points[i]));
			}
			for (const check::Triangle& face : faces)
				for (int i = 0; i < 2; ++i)
				{
					const Vec3 p = sampleOf(face, random);
					double nearestInput = std::numeric_limits<double>::infinity();
					for (const check::Triangle& t : input) nearestInput = std::min(nearestInput, distance(t, p));
					if (nearestInput > double(node.surf) + room)
						return "level " + std::to_string(level) + ", node " + std::to_string(n) +
							   ": a face is farther away than surf";
				}
		}
		for (const double least : nearest)
			if (least > cover + 2 * room) return "level " + std::to_string(level) + ": a point is farther away than cover";
	}
	return "";
}

// Of a refusal: reason, and the element or the number that is wrong.
bool namesAnElement(const std::string& message)
{
	static const std::regex element("(face|faces|vertex|vertice|edge|line|component|byte)s? .*[0-9]|volume of|no vertices|no faces|"
									"same place|long; the limits");
	return message.find(": ") != std::string::npos && std::regex_search(message, element);
}

std::string judged(const Start& start, const Outcome& outcome, bool isMended, Random& random)
{
	if (outcome.status == Status::refused || outcome.status == Status::limit)
	{
		if (start.isPlain && start.fault == Fault::none) return "a sound mesh is refused: " + outcome.message;
		return namesAnElement(outcome.message) || isMended ? "" : "no element is named: " + outcome.message;
	}
	if (outcome.status != Status::built) return "failed: " + outcome.message;
	if (start.fault != Fault::none && !isMended) return "built in spite of fault " + std::to_string(int(start.fault));
	if (!isMended && !outcome.changes.empty()) return "changed without a word: " + outcome.changes[0];
	check::Options options;
	options.threads = 1;
	for (const check::Invariant& invariant : check::checkHierarchy(*outcome.hierarchy, options))
		if (invariant.violations > 0) return invariant.name + ": " + invariant.firstViolation;
	return isMended ? "" : brokenError(start.mesh, *outcome.hierarchy, random);
}
}  // namespace

TEST(RandomMeshes, AreBuiltAndProvedOrRefusedWithAReason)
{
	const int starts = test::setting("CLOD_STARTS", 8), first = test::setting("CLOD_FIRST_START", 0);
	const test::TemporaryFolder folder;
	int built = 0, refused = 0;
	for (int seed = first; seed < first + starts; ++seed)
	{
		Random random{std::uint64_t(seed) + 1000};
		const Start start = startOf(std::uint64_t(seed));
		FileOptions options;
		options.threads = 1;
		const bool isFile = random() % 2 && start.fault != Fault::index;
		const std::string path = folder.file("mesh.obj", test::objText({start.mesh.vertices, start.mesh.triangles}));
		const Outcome outcome = isFile ? buildFile(path, options) : build(start.mesh, options);
		EXPECT_EQ(judged(start, outcome, false, random), "") << "seed " << seed;
		++(outcome.status == Status::built ? built : refused);
		if (outcome.status == Status::built || random() % 3) continue;
		options.repair = true;
		EXPECT_EQ(judged(start, build(start.mesh, options), true, random), "") << "mended, seed " << seed;
	}
	EXPECT_GT(built, starts / 5);
	EXPECT_GT(refused, starts / 5);
}

// Hulls are flat where the tolerance of a level is more than the sheet's thickness, and must span no notch then. By day as on a
// chessboard: two bodies of each thickness, three thicknesses of each body.
TEST(RandomMeshes, SheetsOfAnyThicknessPassTheChecker)
{
	std::vector<std::array<double, 2>> corners = {{-1, -1}, {3, -1}, {3, 1}, {1, 1}, {1, 3}, {-1, 3}}, teeth;
	for (int i = 0; i < 24; ++i)
	{
		const double angle = i * std::acos(-1.0) / 12, r = i / 2 % 2 ? 1 : 0.8;
		teeth.push_back({r * std::cos(angle), r * std::sin(angle)});
	}
	Mesh ring = test::torusMesh(1, 0.4, 16, 8), wave = test::boxMesh({1, 1, 1}, 6);
	for (Vec3& v : ring.vertices) v = {v.z, v.x, v.y};
	for (Vec3& v : wave.vertices) v = {v.y + (v.y == 1 ? 0.2 * std::sin(4 * v.x) * std::sin(4 * v.z) : 0), v.z, v.x};
	const bool isNight = test::setting("CLOD_EVERY_SHEET", 0) != 0;
	Random random(1);
	int square = 0;
	for (double thickness = 0.1; thickness > 5e-7; thickness *= 0.1, ++square)
		for (const auto& [name, mesh] :
			 {std::pair("ring", TriangleMesh{ring.vertices, ring.triangles}), {"wave", {wave.vertices, wave.triangles}},
			  {"L", prism(corners)}, {"gear", prism(teeth)}})
		{
			if (++square % 2 && !isNight) continue;
			Start start{mesh, Fault::none, true};
			for (Vec3& v : start.mesh.vertices) v.z *= thickness;
			if (name == std::string("L"))  // aslant, where both sides are rounded
				for (Vec3& v : start.mesh.vertices) v = {0.8 * v.x - 0.6 * v.z, v.y, 0.6 * v.x + 0.8 * v.z};
			EXPECT_EQ(judged(start, build(start.mesh), false, random), "") << name << ", thickness " << thickness;
		}
}

// Stars cut from sheets of any thickness, plain, bent or rough, turned in half of the cases: their rims are slivers.
TEST(RandomMeshes, RandomSheetsPassTheChecker)
{
	const int starts = test::setting("CLOD_STARTS", 12), first = test::setting("CLOD_FIRST_START", 45);
	for (int seed = first; seed < first + starts; ++seed)
	{
		Random random{std::uint64_t(seed) + 2000};
		std::vector<std::array<double, 2>> outline;
		const int corners = 5 + int(random() % 40);
		for (int i = 0; i < corners; ++i)
		{
			const double angle = (i + between(random, 0, 0.6)) * 2 * std::acos(-1.0) / corners;
			const double r = between(random, 0.3, 1);
			outline.push_back({r * std::cos(angle), r * std::sin(angle)});
		}
		const double thickness = std::pow(10, between(random, -8, -1)), size = std::pow(10, between(random, -3, 3));
		const std::uint64_t kind = random() % 3;
		const Vec3 axis = normalized(anyVector(random));
		const bool isTurned = random() % 2;
		Start start{prism(outline), Fault::none, false};
		for (Vec3& v : start.mesh.vertices)
		{
			if (kind == 1) v.z += 2 * v.x * v.x;
			if (kind == 2) v.z += between(random, 0, 0.3);
			v.z *= thickness;
			if (isTurned) v = 2 * dot(axis, v) * axis - v;  // half a turn
			v = size * v;
		}
		EXPECT_EQ(judged(start, build(start.mesh), false, random), "") << "seed " << seed << ", thickness " << thickness;
	}
}

// Sheets whose hulls spanned notches, and one folded flat: rims, half a turn, were told from slits by noise.
TEST(RandomMeshes, SheetsThatWereBuiltWrong)
{
	for (const std::uint64_t seed : {66, 98, 173, 209, 426, 893})
	{
		Random random{seed};
		const Start start = startOf(seed);
		ASSERT_EQ(start.fault, Fault::none) << seed;
		EXPECT_EQ(judged(start, build(start.mesh), false, random), "") << "seed " << seed;
	}
}

// The judge itself.
TEST(RandomMeshes, JudgeFindsPlantedFaults)
{
	Random random(1);
	const Mesh torus = test::torusMesh(1, 0.4, 16, 8);
	Start start{{torus.vertices, torus.triangles}, Fault::none, true};
	Outcome outcome = build(start.mesh);
	ASSERT_EQ(judged(start, outcome, false, random), "");
	for (Vec3& v : start.mesh.vertices) v.z *= 1.02;
	EXPECT_NE(judged(start, outcome, false, random), "");
	start.fault = Fault::open;
	EXPECT_NE(judged(start, outcome, false, random), "");
	start.fault = Fault::none;
	outcome.changes = {"sewn"};
	EXPECT_NE(judged(start, outcome, false, random), "");
	outcome.status = Status::failed;
	EXPECT_NE(judged(start, outcome, false, random), "");
	outcome.status = Status::refused;
	outcome.message = "open boundary";
	start.fault = Fault::open;
	EXPECT_NE(judged(start, outcome, false, random), "");
	outcome.message = "open boundary: edge (0, 1) of face 0";
	EXPECT_EQ(judged(start, outcome, false, random), "");
}
}  // namespace clod::builder
