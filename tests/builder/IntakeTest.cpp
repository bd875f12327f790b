// SPDX-License-Identifier: GPL-3.0-or-later
// What the builder takes in and what it refuses: a table of input meshes with reason and first offending element.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "builder/intake/FileFrame.h"
#include "builder/intake/Intake.h"
#include "builder/intake/ReadMesh.h"
#include "tests/builder/ObjText.h"

namespace clod::test
{
namespace
{
using builder::Reason;

struct Case
{
	const char* name;
	std::string obj;
	const char* expected;  // "BUILT", or the start of the refusal
	const char* element;   // what the refusal must contain
};

const Case kCases[] = {
	{"X01NoBytes", "", "empty", "no vertices"},
	{"X01NoFaces", kVertices, "empty", "no faces"},
	{"X02OneTriangle", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "open boundary", "face 0"},
	{"X02CoplanarPair", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", "open boundary", "edge (0, 1)"},
	{"X03Cube", kCube, "BUILT", ""},
	{"X03Tetrahedron", tetrahedron(0, 1, 1), "BUILT", ""},
	{"X04NaN", replaced(kCube, "v 1 1 0", "v 1 nan 0"), "not finite", "vertex 2"},
	{"X04Infinite", replaced(kCube, "v 1 1 0", "v 1 -inf 0"), "not finite", "vertex 2"},
	{"X04TooLargeForDouble", replaced(kCube, "v 1 1 0", "v 1 1e999 0"), "not finite", "vertex 2"},
	{"X04TooLargeForFloat", replaced(kCube, "v 1 1 0", "v 1 1e38 0"), "limit", "1e+38"},
	{"X04DenormalAndMinusZero", replaced(kCube, "v 0 0 0", "v -0 1e-310 1e-999"), "BUILT", ""},
	{"X05IndexTooLarge", replaced(kCube, "f 5 6 7 8", "f 5 6 7 9"), "index out of range", "face 1"},
	{"X05IndexZero", replaced(kCube, "f 5 6 7 8", "f 5 6 7 0"), "index out of range", "line 10"},
	{"X05IndexHuge", replaced(kCube, "f 5 6 7 8", "f 5 6 7 4294967296"), "index out of range",
	 "line 10: vertex index 4294967296 "},
	{"X05IndexBeyondIntegers", replaced(kCube, "f 5 6 7 8", "f 5 6 7 99999999999999999999"), "syntax", "line 10"},
	{"X05RelativeOutOfRange", replaced(kCube, "f 5 6 7 8", "f -4 -3 -2 -9"), "index out of range", "line 10"},
	{"X05RelativeGood", replaced(kCube, "f 5 6 7 8", "f -4 -3 -2 -1"), "BUILT", ""},
	{"X06RepeatedCorner", kCube + "f 1 1 2\n", "degenerate face", "face 6"},
	{"X06Collinear",
	 "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nv 1 0 0\nf 1 3 5\nf 5 3 2\nf 1 4 3\nf 2 3 4\nf 1 2 4\nf 1 5 2\n",
	 "degenerate face", "face 5"},
	{"X06Needle", "v 0 0 0\nv 1000 0 0\nv 0 0.001 0\nv 0 0 0.001\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", "BUILT", ""},
	{"X07DuplicateFace", kCube + "f 1 4 3 2\n", "duplicate face", "face 6"},
	{"X07OppositeTwins", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n", "duplicate face", "face 1"},
	{"X07DuplicateVertices", replaced(kCube, "v 0 1 1\n", "v 0 1 1\nv 0 0 0\n"), "BUILT", ""},
	{"X09Inverted", tetrahedron(0, 1, 1, true), "inverted", "volume"},
	{"X09OneComponentInverted", tetrahedron(0, 1, 1) + tetrahedron(5, 0.5, 5, true), "inverted", "face 4"},
	{"X09OneFaceFlipped", replaced(kCube, "f 5 6 7 8", "f 8 7 6 5"), "inconsistent orientation", "face 1"},
	{"X10ThreeFacesAtAnEdge", kCube + "v 2 0 0\nf 1 2 9\n", "non-manifold edge", "edge (0, 1)"},
	{"X10BowTie", tetrahedron(0, 1, 1) + "v 3 1 1\nv 3 3 1\nv 3 1 3\nf 1 6 5\nf 1 5 7\nf 1 7 6\nf 5 6 7\n",
	 "non-manifold vertex", "vertex 0"},
	{"X11Open", kVertices + kBottom + kSides, "open boundary", "edge"},
	{"X12SelfIntersecting", tetrahedron(0, 1, 1) + tetrahedron(0.3, 1, 5), "self-intersection", "faces"},
	{"X13TwoComponents", tetrahedron(0, 1, 1) + tetrahedron(5, 1, 5), "BUILT", ""},
	{"X13Cavity", tetrahedron(0, 3, 1) + tetrahedron(0, 0.5, 5, true), "BUILT", ""},
	{"X13CavityFilled", tetrahedron(0, 3, 1) + tetrahedron(0, 0.5, 5), "inverted", "cavity"},
	{"X16AllVerticesEqual", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", "zero volume", "same place"},
	{"X16Flat", "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0.5 0.5 0\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n", "zero volume",
	 "volume"},
	{"X17FarAndTiny",
	 "v 1000000 0 0\nv 1000000.0000009 0 0\nv 1000000 0.0000009 0\nv 1000000 0 0.0000009\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf "
	 "2 3 4\n",
	 "BUILT", ""},
	{"X20Dialects",
	 "# comment\r\nmtllib none.mtl\r\no cube\r\nv\t0 0 0\r\nv 1 0 0 1.0\r\nv +1 1.0e0 0 0.1 0.2 0.3\r\nv 0 1 0\r\nv 0 "
	 "0 1\r\n"
	 "v 1 0 1\r\nv 1 1 1\r\nv 0 1 1\r\nvn 0 0 1\r\nvt 0 0\r\ng a b\r\nusemtl x\r\ns off\r\nf 1/1/1 4/1/1 3/1/1 "
	 "2/1/1\r\n"
	 "f 5//1 6//1 7//1 8//1\r\nf 1/1 2/1 6/1 5/1\r\n\r\nf 2 3 \\\r\n 7 6 # tail\r\nf 3 4 8 7\r\nf 4 1 5 8",
	 "BUILT", ""},
	{"X20LocaleComma", replaced(kCube, "v 1 1 0", "v 1,0 1,0 0"), "syntax", "line 3"},
	{"X20MissingCoordinate", replaced(kCube, "v 1 1 0", "v 1 1"), "syntax", "line 3"},
	{"X20UnknownKeyword", kCube + "curv 0 1 2 3\n", "syntax", "line 15"},
	{"X20LinesThatGoOn",
	 "\\\n" + replaced(replaced(kCube, "v 1 1 0",
							   "vn 0 0 \\\n1\nl 1 2 \\\r\n3 4\n\\\nv 1\\\n 1 \\ # tail\n\\\n0 # C:\\"),
					  "f 5 6 7 8", "f\\\n5 6\\ \n7 8\\\n"),
	 "BUILT", ""},
	{"X20LineThatGoesOnAtTheEnd", kCube + "l 1 2 \\", "BUILT", ""},
	{"X20BackslashWithinALine", replaced(kCube, "f 5 6 7 8", "f 5 6\\ 7 8"), "syntax", "line 10: '6\\'"},
	{"X20WordOnALineThatGoesOn", replaced(kCube, "v 1 1 0", "v 1\\\n1\\\nx"), "syntax", "line 5: 'x'"},
	{"X20CornerOnALineThatGoesOn", replaced(kCube, "f 5 6 7 8", "f 5 6 \\\n7 99"), "index out of range", ""},
	{"X20UnknownAfterLinesThatGoOn", replaced(kCube, "v 1 1 0", "v 1\\\n1\\\n0") + "curv\\\n0 1\n", "syntax",
	 "line 17: keyword 'curv'"},
	{"X20TwoCorners", kCube + "f 1 2\n", "syntax", "line 15"},
};

class IntakeCase : public ::testing::TestWithParam<Case>
{
};

std::string outcome(const std::string& obj)
{
	try
	{
		builder::intake(builder::parseObj(obj));
		return "BUILT";
	}
	catch (const builder::Refused& refused)
	{
		return refused.what();
	}
}
}  // namespace

TEST_P(IntakeCase, HasTheStatedOutcome)
{
	const std::string found = outcome(GetParam().obj);
	EXPECT_EQ(found.substr(0, std::string(GetParam().expected).size()), GetParam().expected) << found;
	EXPECT_NE(found.find(GetParam().element), std::string::npos) << found;
}

INSTANTIATE_TEST_SUITE_P(Intake, IntakeCase, ::testing::ValuesIn(kCases),
						 [](const auto& entry) { return std::string(entry.param.name); });

TEST(Intake, BodyFrameIsCentredOnTheCentreOfMass)
{
	const builder::Intake cube = builder::intake(builder::parseObj(kCube));
	EXPECT_EQ(cube.mesh.triangles.size(), 12u);
	EXPECT_NEAR(length(cube.meshFromBody - Vec3{0.5, 0.5, 0.5}), 0, 1e-15);
	for (const Vec3& v : cube.mesh.vertices) EXPECT_NEAR(length(v), std::sqrt(0.75), 1e-6);
}

TEST(Intake, FarOffsetChangesNothing)
{
	const builder::Soup soup = builder::parseObj(kCube);
	builder::Soup moved = soup;
	for (Vec3& v : moved.vertices) v += Vec3{1048576, -2097152, 4194304};
	EXPECT_EQ(builder::intake(soup).mesh.vertices, builder::intake(moved).mesh.vertices);
}

TEST(Intake, LineOfAMegabyteIsRead)
{
	EXPECT_EQ(outcome(kCube + "# " + std::string(1 << 20, 'x') + "\n"), "BUILT");
	EXPECT_EQ(outcome(replaced(kCube, "v 1 1 0", "v " + std::string(1 << 20, ' ') + "1 1 0")), "BUILT");
}

TEST(Intake, PolygonBeyondTheLimitIsRefused)
{
	std::string text;
	for (int i = 0; i < 300; ++i)
		text += "v " + std::to_string(std::cos(i * 0.02)) + " " + std::to_string(std::sin(i * 0.02)) + " 0\n";
	text += "f";
	for (int i = 1; i <= 300; ++i) text += " " + std::to_string(i);
	EXPECT_EQ(outcome(text).substr(0, 5), "limit");
}

TEST(Intake, NamesEveryKindOfDefectWithItsCount)
{
	const std::string found = outcome(kVertices + kBottom + kSides + "f 1 4 3 2\nf 1 4 3 2\nv 2 0 0\nf 6 5 9\n");
	EXPECT_EQ(found.find("duplicate face: face 5"), 0u) << found;
	EXPECT_NE(found.find("(4 such)"), std::string::npos) << found;
	EXPECT_NE(found.find("; also non-manifold edge: "), std::string::npos) << found;
	EXPECT_NE(found.find("; also inconsistent orientation: edge (5, 4) of face 1"), std::string::npos) << found;
	EXPECT_NE(found.find("; also open boundary: "), std::string::npos) << found;
}

TEST(Intake, CountsComponentsAndCavities)
{
	const builder::Intake two =
		builder::intake(builder::parseObj(tetrahedron(0, 3, 1) + tetrahedron(0, 0.5, 5, true) + tetrahedron(9, 1, 9)));
	EXPECT_EQ(two.componentCount, 3u);
	EXPECT_EQ(two.cavityCount, 1u);
}

Vec3 converted(const builder::FileFrame& frame)
{
	builder::Soup soup;
	soup.vertices = {{1, 2, 3}};
	builder::convert(frame, soup);
	return soup.vertices[0];
}

TEST(FileFrame, ConvertsUnitsAxesAndScale)
{
	EXPECT_EQ(converted({}), (Vec3{1, 2, 3}));
	EXPECT_EQ(converted({"mm", "y", 1}), (Vec3{0.001, 0.002, 0.003}));
	EXPECT_EQ(converted({"in", "y", 1}), (Vec3{0.0254, 0.0508, 0.0762}));
	EXPECT_EQ(converted({"ft", "y", 10}), (Vec3{3.048, 6.096, 9.144}));
	EXPECT_EQ(converted({"", "z", 1}), (Vec3{1, 3, -2}));
	EXPECT_EQ(converted({"", "x", 2}), (Vec3{-4, 2, 6}));
}

// No mirror: a solid stays one, whatever axis points up.
TEST(FileFrame, KeepsHandedness)
{
	for (const std::string& up : builder::upNames())
	{
		builder::Soup soup = builder::parseObj(tetrahedron(0, 1, 1));
		builder::convert({"cm", up, 3}, soup);
		EXPECT_NO_THROW(builder::intake(soup)) << up;
	}
}

// Any bytes end in one of the three outcomes, quickly, in every reader.
TEST(Intake, GarbageIsRefused)
{
	std::mt19937 random(20031);
	const std::string good = kCube;
	for (int trial = 0; trial < 4000; ++trial)
	{
		std::string bytes = good;
		for (int change = 0; change < 1 + trial % 8; ++change) bytes[random() % bytes.size()] = char(random());
		for (const auto parse : {builder::parseObj, builder::parseOff, builder::parsePly, builder::parseStl}) try
			{
				builder::intake(parse(bytes));
			}
			catch (const builder::Refused&)
			{
			}
	}
}

TEST(Intake, RandomBitsAsCoordinatesAreRefused)
{
	std::mt19937 random(1);
	for (int trial = 0; trial < 2000; ++trial)
	{
		builder::Soup soup = builder::parseObj(kCube);
		for (Vec3& v : soup.vertices)
			for (int i = 0; i < 3; ++i)
			{
				const std::uint32_t bits = std::uint32_t(random());
				float value;
				std::memcpy(&value, &bits, sizeof(value));
				v[i] = double(value);
			}
		EXPECT_THROW(builder::intake(soup), builder::Refused);
	}
}
}  // namespace clod::test
