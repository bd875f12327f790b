// SPDX-License-Identifier: GPL-3.0-or-later
// Input extremes X1 to X23 through the whole program: what comes out is BUILT (a file that clod-build check proves),
// REFUSED (exit code 3, the reason and the first element) or LIMIT (exit code 5), never anything else: no crash, no
// hang, no other exit code, nothing half written. X19, real collections, is scripts/real-meshes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/builder/ObjText.h"
#include "tests/support/ChildProgram.h"
#include "tests/support/Files.h"
#include "tests/support/Meshes.h"

namespace clod::test
{
namespace
{
namespace fs = std::filesystem;
using builder::Mesh;

std::size_t count(const TemporaryFolder& folder)
{
	return std::size_t(std::distance(fs::directory_iterator(folder.path()), {}));
}

// "BUILT", "REFUSED ...message", "LIMIT ...message", or "ILLEGAL ..." with what was wrong.
std::string outcome(const std::string& program, const TemporaryFolder& folder, const std::string& mesh,
					double seconds = 500)
{
	const std::string out = folder.file("out.clod");
	const std::size_t filesBefore = count(folder);
	const auto run = [&](std::vector<std::string> words)
	{ return waitForProgram(startProgram(std::move(words), folder.file("stdout"), folder.file("stderr")), seconds); };
	const int code = run({program, "build", mesh, "-o", out, "--quiet", "--json", folder.file("report.json")});
	const std::string message = readText(folder.file("stderr"));
	if (code == 0)
	{
		const int proof = run({program, "check", out, "--quiet"});
		return proof == 0 ? "BUILT" : "ILLEGAL: check ends with " + std::to_string(proof);
	}
	if (count(folder) != filesBefore + 2) return "ILLEGAL: leaves files behind";  // stdout, stderr
	if (code != 3 && code != 5) return "ILLEGAL: ends with " + std::to_string(code) + " " + message;
	if (message.find(": ") == std::string::npos) return "ILLEGAL: no reason: " + message;
	return (code == 3 ? "REFUSED " : "LIMIT ") + message;
}

struct Case
{
	const char* name;
	std::function<std::string()> text;
	std::string expected;  // BUILT, or REFUSED or LIMIT
	std::string message;   // what else must be said: reason and element
	int patches = 0;       // at level 0, where it is known
	const char* file = "mesh.obj";
};

std::function<std::string()> obj(const std::string& text)
{
	return [text] { return text; };
}

std::function<std::string()> obj(Mesh (*make)())
{
	return [make] { return objText(make()); };
}

Mesh jittered(Mesh mesh, double by)
{
	std::mt19937 random(8);
	std::uniform_real_distribution<double> uniform(-by, by);
	for (Vec3& v : mesh.vertices) v += Vec3{uniform(random), uniform(random), uniform(random)};
	return mesh;
}

Mesh scaled(Mesh mesh, double by, const Vec3& shift = {})
{
	for (Vec3& v : mesh.vertices) v = by * v + shift;
	return mesh;
}

// Saddles everywhere: the top of a box is z = a sin x sin y.
Mesh saddles()
{
	Mesh mesh = boxMesh({1, 1, 0.5}, 16);
	for (Vec3& v : mesh.vertices)
		if (v.z == 0.5) v.z += 0.12 * std::sin(9 * v.x) * std::sin(9 * v.y);
	return mesh;
}

// Every vertex of a ball alternately out and in.
Mesh urchin()
{
	Mesh mesh = sphereMesh(1, 24, 12);
	for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
		mesh.vertices[i] = (i % 2 == 0 ? 1.0 : 0.6) * mesh.vertices[i];
	return mesh;
}

// A thin sheet in sharp folds, its walls thinner than its edges.
Mesh foldedSheet()
{
	Mesh mesh = boxMesh({1, 0.02, 1}, 12);
	for (Vec3& v : mesh.vertices)
		v.y = double(roundToFloat(v.y + 0.3 * std::abs(std::fmod(std::abs(v.x) * 6, 2.0) - 1)));
	return mesh;
}

std::string binaryStlHeader(std::uint32_t facets)
{
	std::string bytes(84, '\0');
	for (int i = 0; i < 4; ++i) bytes[std::size_t(80 + i)] = char(facets >> (8 * i));
	return bytes;
}

std::string garbage()
{
	std::mt19937 random(18);
	std::string bytes;
	for (int i = 0; i < 20'000; ++i) bytes += char(random());
	return bytes;
}

// Random triangles among random points: crosses itself everywhere and is no surface.
std::string randomSoup()
{
	std::mt19937 random(180);
	std::string text;
	const auto add = [&](const char* kind, const std::array<std::uint32_t, 3>& from, std::uint32_t count)
	{
		text += kind;
		for (const std::uint32_t least : from) text += " " + std::to_string(least + random() % count);
		text += "\n";
	};
	for (int i = 0; i < 300; ++i) add("v", {0, 0, 0}, 1000);
	for (int i = 0; i < 600; ++i) add("f", {1, 101, 201}, 100);
	return text;
}

const char* const kPlyHuge =
	"ply\nformat binary_little_endian 1.0\nelement vertex 4294967295\nproperty float x\nproperty float y\nproperty "
	"float z\nelement face 4294967295\nproperty list uchar int vertex_indices\nend_header\n";

const Case kCases[] = {
	{"X01NoBytes", obj(""), "REFUSED", "empty: the mesh has no vertices"},
	{"X01HeaderOnly", obj(binaryStlHeader(0)), "REFUSED", "empty", 0, "mesh.stl"},
	{"X01NoFaces", obj(kVertices), "REFUSED", "empty: the mesh has no faces"},
	{"X02OneTriangle", obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "REFUSED", "open boundary: edge (0, 1) of face 0"},
	{"X02CoplanarPair", obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"), "REFUSED", "open boundary"},
	{"X03Tetrahedron", obj(tetrahedron(0, 1, 1)), "BUILT", "", 1},
	{"X03Cube", obj(kCube), "BUILT", "", 1},
	{"X04NaN", obj(replaced(kCube, "v 1 1 0", "v 1 nan 0")), "REFUSED", "not finite: vertex 2"},
	{"X04Infinite", obj(replaced(kCube, "v 1 1 0", "v 1 -inf 0")), "REFUSED", "not finite: vertex 2"},
	{"X04Denormal", obj(replaced(kCube, "v 0 0 0", "v -0 1e-310 1e-999")), "BUILT", "", 1},
	{"X04Huge", obj(replaced(kCube, "v 1 1 0", "v 1 1e38 0")), "LIMIT", "1e+38"},
	{"X04Minute",
	 [] {
		 return objText(scaled(boxMesh({1, 1, 1}, 1), 1e-38));
	 },
	 "LIMIT", "scale it"},
	{"X05IndexTooLarge", obj(replaced(kCube, "f 5 6 7 8", "f 5 6 7 9")), "REFUSED", "index out of range: face 1"},
	{"X05Index32Bits", obj(replaced(kCube, "f 5 6 7 8", "f 5 6 7 4294967295")), "REFUSED", "index out of range"},
	{"X05RelativeIndex", obj(replaced(kCube, "f 5 6 7 8", "f -4 -3 -2 -9")), "REFUSED", "line 10"},
	{"X06NoArea", obj(kCube + "f 1 1 2\n"), "REFUSED", "degenerate face: face 6"},
	{"X06Needle", obj("v 0 0 0\nv 1000 0 0\nv 0 0.001 0\nv 0 0 0.001\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"), "BUILT",
	 "", 1},
	{"X07DuplicateFace", obj(kCube + "f 1 4 3 2\n"), "REFUSED", "duplicate face: face 6"},
	{"X07DuplicateVertices", obj(replaced(kCube, "f 5 6 7 8", "v 1 1 1\nf 5 6 9 8")), "BUILT", "", 1},
	{"X08FlatFacesOfManyTriangles",
	 [] {
		 return objText(boxMesh({1, 1, 1}, 24));
	 },
	 "BUILT", "", 1},
	{"X08WithinRoundingOfFlat",
	 [] {
		 return objText(jittered(boxMesh({1, 1, 1}, 12), 6e-8));
	 },
	 "BUILT", ""},
	{"X09Inverted", obj(tetrahedron(0, 1, 1, true)), "REFUSED", "inverted: the mesh is inside out from face 0"},
	{"X09OneComponent", obj(tetrahedron(0, 1, 1) + tetrahedron(5, 0.5, 5, true)), "REFUSED",
	 "inverted: the component of face 4"},
	{"X09OneFace", obj(replaced(kCube, "f 5 6 7 8", "f 8 7 6 5")), "REFUSED", "inconsistent orientation"},
	{"X10ThreeFacesAtAnEdge", obj(kCube + "v 2 0 0\nf 1 2 9\n"), "REFUSED", "non-manifold edge: edge (0, 1)"},
	{"X10BowTie", obj(tetrahedron(0, 1, 1) + "v 3 1 1\nv 3 3 1\nv 3 1 3\nf 1 6 5\nf 1 5 7\nf 1 7 6\nf 5 6 7\n"),
	 "REFUSED", "non-manifold vertex: vertex 0"},
	{"X11Open", obj(kVertices + kBottom + kSides), "REFUSED", "open boundary: edge"},
	{"X12Crossing", obj(tetrahedron(0, 1, 1) + tetrahedron(0.3, 1, 5)), "REFUSED", "self-intersection: faces"},
	{"X12CoplanarOverlap",
	 obj(kCube + "v .5 .5 1\nv 1.5 .5 1\nv 1.5 1.5 1\nv .5 .5 2\nf 9 11 10\nf 9 10 12\nf 10 11 12\nf 11 9 12\n"),
	 "REFUSED", "self-intersection: faces"},
	{"X13TwoComponents", obj(tetrahedron(0, 1, 1) + tetrahedron(5, 1, 5)), "BUILT", "", 2},
	{"X13Cavity", obj(tetrahedron(0, 3, 1) + tetrahedron(0, 0.5, 5, true)), "BUILT", ""},
	{"X13ShellFacingOut", obj(tetrahedron(0, 3, 1) + tetrahedron(0, 0.5, 5)), "REFUSED", "cavity"},
	{"X14Genus", [] { return objText(torusMesh(1, 0.4, 24, 12)); }, "BUILT", ""},
	{"X14ThinWall", obj(foldedSheet), "BUILT", ""},
	{"X15FourBillion", obj(kPlyHuge), "REFUSED", "too short", 0, "mesh.ply"},
	{"X15FacetsBeyondTheFile", obj(binaryStlHeader(0xFFFFFFFFu)), "REFUSED", "facets", 0, "mesh.stl"},
	{"X16AllVerticesEqual", obj("v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n"), "REFUSED", "zero volume"},
	{"X16Collinear", obj("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"), "REFUSED",
	 "zero volume"},
	{"X16Flat", obj("v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0.5 0.5 0\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"), "REFUSED",
	 "zero volume"},
	{"X17Far",
	 [] {
		 return objText(scaled(torusMesh(1, 0.4, 24, 12), 1, {1e6, -1e6, 1e6}));
	 },
	 "BUILT", ""},
	{"X17Small", [] { return objText(scaled(torusMesh(1, 0.4, 24, 12), 1e-6)); }, "BUILT", ""},
	{"X17FarAndSmall",
	 [] {
		 return objText(scaled(torusMesh(1, 0.4, 24, 12), 1e-6, {1e6, 0, 0}));
	 },
	 "BUILT", ""},
	{"X18GarbageObj", garbage, "REFUSED", "syntax: line 1"},
	{"X18GarbageStl", garbage, "REFUSED", "syntax", 0, "mesh.stl"},
	{"X18GarbageGlb", garbage, "REFUSED", "syntax", 0, "mesh.glb"},
	{"X18RandomSoup", randomSoup, "REFUSED", "face"},
	{"X20CrLfTabsNGons",
	 obj("# c\r\no a\r\nv\t0 0 0\r\nv 1 0 0 1.0\r\nv +1 1.0e0 0\r\nv 0 1 0\r\nv 0 0 1\r\nv 1 0 1\r\nv 1 1 1\r\nv 0 1 "
		 "1\r\ng x\r\nf 1/1 4/1 3/1 2/1\r\nf 5//1 6//1 7//1 8//1\r\nf 1 2 6 5\r\nf 2 3 \\\r\n 7 6 # t\r\nf 3 4 8 "
		 "7\r\nf 4 1 5 8"),
	 "BUILT", "", 1},
	{"X20LocaleComma", obj(replaced(kCube, "v 1 1 0", "v 1,0 1,0 0")), "REFUSED", "syntax: line 3"},
	{"X21Saddles", obj(saddles), "BUILT", ""},
	{"X21Urchin", obj(urchin), "BUILT", ""},
	{"X22Folds", [] { return objText(wrinkledTorusMesh(1, 0.35, 0.06, 6, 36, 14)); }, "BUILT", ""},
	{"X23LargeConvex", [] { return objText(sphereMesh(1, 60, 30)); }, "BUILT", "", 1},
};

class Extreme : public ::testing::TestWithParam<Case>
{
};
}  // namespace

TEST_P(Extreme, IsBuiltRefusedOrALimit)
{
	const Case& entry = GetParam();
	const TemporaryFolder folder;
	const std::string found = outcome(CLOD_BUILD_PROGRAM, folder, folder.file(entry.file, entry.text()));
	EXPECT_EQ(found.substr(0, entry.expected.size()), entry.expected) << found;
	EXPECT_NE(found.find(entry.message), std::string::npos) << found;
	if (entry.patches == 0 || found != "BUILT") return;
	const auto report = nlohmann::json::parse(readText(folder.file("report.json")));
	EXPECT_EQ(report["levels"][0]["patches"], entry.patches);
}

INSTANTIATE_TEST_SUITE_P(Input, Extreme, ::testing::ValuesIn(kCases),
						 [](const auto& entry) { return std::string(entry.param.name); });

TEST(Extremes, LongPathIsRefusedOrBuilt)
{
	const TemporaryFolder folder;
	const std::string longName(4096, 'x');
	EXPECT_EQ(outcome(CLOD_BUILD_PROGRAM, folder, "/" + longName + ".obj").substr(0, 7), "REFUSED");
}

// The judge itself, before programs that misbehave.
TEST(Extremes, JudgeNamesWhatIsIllegal)
{
	const auto judged = [](const std::string& script)
	{
		const TemporaryFolder folder;
		const std::string program = folder.file("program", "#!/bin/sh\n" + script + "\n");
		fs::permissions(program, fs::perms::owner_all);
		return outcome(program, folder, "mesh.obj", 1);
	};
	EXPECT_EQ(judged("echo mesh.obj: empty: it is >&2; exit 3").substr(0, 7), "REFUSED");
	EXPECT_EQ(judged("echo mesh.obj: limit: it is >&2; exit 5").substr(0, 5), "LIMIT");
	EXPECT_EQ(judged("echo mesh.obj: failure >&2; exit 1").substr(0, 7), "ILLEGAL");
	EXPECT_EQ(judged("kill -SEGV $$").substr(0, 7), "ILLEGAL");
	EXPECT_EQ(judged("exec sleep 60").substr(0, 7), "ILLEGAL");
	EXPECT_EQ(judged("echo x > $4; echo mesh.obj: empty: it is >&2; exit 3").substr(0, 7), "ILLEGAL");
	EXPECT_EQ(judged("exit 3").substr(0, 7), "ILLEGAL");
	EXPECT_EQ(judged("test $1 = build && exit 0; exit 4").substr(0, 7), "ILLEGAL");
}
}  // namespace clod::test
