// SPDX-License-Identifier: GPL-3.0-or-later
// What --repair and --wrap make of spoilt solids: what they say, how far the surface moves, and that the result is the
// solid a person would expect (its volume is known).
#include <gtest/gtest.h>

#include <cmath>

#include "builder/intake/ReadMesh.h"
#include "builder/repair/Repair.h"
#include "tests/builder/ObjText.h"
#include "tests/support/Meshes.h"

namespace clod::test
{
namespace
{
using builder::Reason;
using builder::Repaired;

constexpr double kNoLimit = 1e9;

double volumeOf(const builder::Mesh& mesh)
{
	double sixfold = 0;
	for (const auto& t : mesh.triangles)
		sixfold += dot(mesh.vertices[t[0]], cross(mesh.vertices[t[1]], mesh.vertices[t[2]]));
	return sixfold / 6;
}

std::string joined(const std::vector<std::string>& sentences)
{
	std::string text;
	for (const std::string& sentence : sentences) text += sentence + "; ";
	return text;
}

// A second unit cube beside the first, sharing the vertices of `shared` as given; its other four are new.
std::string cubeFaces(const int (&v)[8])
{
	const int quads[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
	std::string text;
	for (const auto& q : quads)
	{
		text += "f";
		for (const int corner : q) text += " " + std::to_string(v[corner]);
		text += "\n";
	}
	return text;
}

// On the first cube's face x = 1, and on its edge x = y = 1.
const std::string kBeside = kCube + "v 2 0 0\nv 2 1 0\nv 2 0 1\nv 2 1 1\n" + cubeFaces({2, 9, 10, 3, 6, 11, 12, 7});
const std::string kAcross =
	kCube + "v 2 1 0\nv 2 2 0\nv 1 2 0\nv 2 1 1\nv 2 2 1\nv 1 2 1\n" + cubeFaces({3, 9, 10, 11, 7, 12, 13, 14});

// Each face with vertices of its own, those of the later ones a little off.
std::string cracked()
{
	std::string text;
	const double corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
								 {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
	const int quads[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
	for (int face = 0; face < 6; ++face)
		for (const int c : quads[face])
			text += "v " + std::to_string(corner[c][0] + 1e-6 * face) + " " + std::to_string(corner[c][1]) + " " +
					std::to_string(corner[c][2]) + "\n";
	for (int face = 0; face < 6; ++face)
	{
		text += "f";
		for (int k = 1; k <= 4; ++k) text += " " + std::to_string(4 * face + k);
		text += "\n";
	}
	return text;
}

struct Case
{
	const char* name;
	std::string obj;
	const char* says;  // part of what is told
	double volume;     // of the result
	double moved;      // at most, certified
};

const double kTetrahedron = 8.0 / 3;  // of tetrahedron(x, 1, ...)
const Case kCases[] = {
	{"Sound", kCube, "", 1, 0},
	{"FaceWithoutArea", kCube + "f 1 1 2\n", "1 face dropped, without area (the first: face 6)", 1, 1e-6},
	{"RepeatedFace", kCube + "f 1 4 3 2\n", "2 faces dropped that repeat another one (the first: face 6)", 1, 1e-6},
	{"EveryFaceTwice", kCube + kBottom + kTop + kSides, "12 faces dropped that repeat", 1, 1e-6},
	{"EveryFaceBothWays", kCube + "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2\nf 7 8 4 3\nf 8 5 1 4\n",
	 "12 faces dropped that repeat", 1, 1e-6},
	{"WallBetweenTwo", kBeside, "4 faces dropped that face both ways", 2, 0.51},
	{"EdgeInCommon", kAcross, "moved apart", 2, 2e-3},
	{"OneFaceTurned", replaced(kCube, "f 5 6 7 8", "f 8 7 6 5"), "2 faces turned to agree", 1, 1e-6},
	{"InsideOut", tetrahedron(0, 1, 1, true), "turned outward", kTetrahedron, 1e-6},
	{"OneComponentInsideOut", tetrahedron(0, 1, 1) + tetrahedron(5, 0.5, 5, true), "1 component turned outward",
	 1.125 * kTetrahedron, 1e-6},
	{"FilledCavity", tetrahedron(0, 3, 1) + tetrahedron(0, 0.5, 5), "turned to bound cavities", 26.875 * kTetrahedron,
	 1e-5},
	{"FilledCavityAndAnotherSolid", tetrahedron(0, 3, 1) + tetrahedron(0, 0.5, 5) + tetrahedron(9, 1, 9),
	 "1 component inside others turned", 27.875 * kTetrahedron, 1e-5},
	{"NoLid", kVertices + kBottom + kSides, "1 hole closed with 2 faces (the longest: 4 edges, 4 around)", 1, 0.52},
	{"Cracks", cracked(), "sewn", 1, 2e-5},
	{"TJunction", "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nv 1 0 0\nf 1 3 2\nf 1 4 3\nf 2 3 4\nf 1 5 4\nf 5 2 4\n",
	 "1 face split", 4.0 / 3, 1e-4},
	{"BowTie", tetrahedron(0, 1, 1) + "v 3 1 1\nv 3 3 1\nv 3 1 3\nf 1 6 5\nf 1 5 7\nf 1 7 6\nf 5 6 7\n", "moved apart",
	 kTetrahedron + 4.0 / 3, 2e-3},
	{"TwoThatCross",
	 kCube +
		 "v .5 .5 .5\nv 1.5 .5 .5\nv 1.5 1.5 .5\nv .5 1.5 .5\nv .5 .5 1.5\nv 1.5 .5 1.5\nv 1.5 1.5 "
		 "1.5\nv .5 1.5 1.5\n" +
		 cubeFaces({9, 10, 11, 12, 13, 14, 15, 16}),
	 "1 component united", 1.875, 0.51},
	{"LooseTriangle", kCube + "v 3 0 0\nv 4 0 0\nv 3 1 0\nf 9 10 11\n", "1 component (2 faces) of no volume dropped", 1,
	 3.1},
	{"NoNumberInNoFace", kCube + "v 5 nan 5\n", "1 vertex dropped, not finite (the first: vertex 8)", 1, 1e-6},
	{"NoNumber", kCube + "v 5 nan 5\nf 1 2 9\n", "1 face dropped for coordinates", 1, 1e-6},
};

class RepairCase : public ::testing::TestWithParam<Case>
{
};

Repaired repaired(const std::string& obj, double maxMove = kNoLimit)
{
	return builder::repair(builder::parseObj(obj), maxMove);
}

Reason refusal(const std::string& obj, double maxMove = kNoLimit)
{
	try
	{
		repaired(obj, maxMove);
	}
	catch (const builder::Refused& refused)
	{
		return refused.reason();
	}
	ADD_FAILURE() << "nothing was refused";
	return Reason::unreadable;
}
}  // namespace

TEST_P(RepairCase, BecomesTheSolidThatWasMeant)
{
	const Repaired result = repaired(GetParam().obj);
	const std::string told = joined(result.changes);
	EXPECT_NE(told.find(GetParam().says), std::string::npos) << told;
	EXPECT_EQ(told.empty(), std::string(GetParam().says).empty()) << told;
	EXPECT_NEAR(volumeOf(result.solid.mesh), GetParam().volume, 2e-3 * GetParam().volume) << told;
	EXPECT_LE(result.moved(), GetParam().moved) << told;
}

INSTANTIATE_TEST_SUITE_P(Repair, RepairCase, ::testing::ValuesIn(kCases),
						 [](const auto& entry) { return std::string(entry.param.name); });

// A dent in a plate that goes through to the other side.
TEST(Repair, CutsOutCrossingsWithinAComponent)
{
	builder::Mesh plate = boxMesh({0.5, 0.5, 0.05}, 8);
	for (Vec3& v : plate.vertices)
		if (v.x == 0 && v.y == 0 && v.z > 0) v.z = -0.08;
	EXPECT_THROW(builder::intake(builder::parseObj(objText(plate))), builder::Refused);
	const Repaired result = repaired(objText(plate));
	EXPECT_NE(joined(result.changes).find("of faces of one component cut out"), std::string::npos)
		<< joined(result.changes);
	EXPECT_NEAR(volumeOf(result.solid.mesh), 0.1, 0.01);
	EXPECT_LE(result.moved(), 0.13);
}

TEST(Repair, SaysWhatIsLeftWhereItFails)
{
	EXPECT_EQ(refusal(replaced(kCube, "v 1 1 1", "v -0.3 -0.2 -0.4")), Reason::selfIntersection);
}

TEST(Repair, MovesNoFartherThanAllowed)
{
	const std::string noLid = kVertices + kBottom + kSides;
	const double moved = repaired(noLid).moved();
	EXPECT_GT(moved, 0.4);
	EXPECT_NO_THROW(repaired(noLid, 1.01 * moved));
	EXPECT_EQ(refusal(noLid, 0.99 * moved), Reason::limit);
}

TEST(Repair, RefusesWhatIsNoSolidAtAll)
{
	// A wrap makes a solid of the first, nothing of the second.
	EXPECT_EQ(refusal("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), Reason::zeroVolume);
	EXPECT_EQ(refusal("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), Reason::empty);
	EXPECT_EQ(refusal(kVertices + "f 1 2 9\n"), Reason::indexOutOfRange);
}

TEST(Repair, GivesTheSameTwice)
{
	for (const Case& entry : kCases)
	{
		const Repaired a = repaired(entry.obj), b = repaired(entry.obj);
		EXPECT_EQ(a.solid.mesh.vertices, b.solid.mesh.vertices) << entry.name;
		EXPECT_EQ(a.solid.mesh.triangles, b.solid.mesh.triangles) << entry.name;
		EXPECT_EQ(a.changes, b.changes) << entry.name;
	}
}

// A wrap of an open, cracked box: closed, outside, near.
TEST(Wrap, EnclosesAtACertifiedDistance)
{
	constexpr double kLength = 1.5;  // the hole of side 1 is bridged
	const Repaired wrap = builder::wrapAround(builder::parseObj(kVertices + kBottom + kSides), kLength);
	EXPECT_EQ(wrap.solid.componentCount, 1u);
	EXPECT_GT(volumeOf(wrap.solid.mesh), 1);
	EXPECT_LT(volumeOf(wrap.solid.mesh), std::pow(1 + 2 * kLength / 30, 3) * 1.05);
	EXPECT_LE(wrap.lost.upper, 1.5 * kLength / 30);
	EXPECT_GT(wrap.added.lower, 0.3);  // the lid
	EXPECT_NE(joined(wrap.changes).find("wrapped by"), std::string::npos);
}

// Faces that the wrap goes round on both sides, as a hole is wider than its length, are no solid but a shell: told.
TEST(Wrap, TellsOfAShell)
{
	const builder::Soup open = builder::parseObj(kVertices + kBottom + kSides), closed = builder::parseObj(kCube);
	const auto told = [](const builder::Soup& soup, double length)
	{
		const std::string text = joined(builder::wrapAround(soup, length).changes);
		const std::size_t at = text.find(" % of the wrap bound a shell only ");
		return at == std::string::npos ? 0 : std::stoi(text.substr(text.rfind(' ', at - 1) + 1));
	};
	EXPECT_GT(told(open, 0.1), 50);
	EXPECT_GT(told(open, 0.4), 0) << "what is cut into it has coarse facets inside, some distance off";
	EXPECT_EQ(told(open, 1.5), 0) << "the hole is bridged";
	EXPECT_EQ(told(closed, 0.2), 0);

	// What is closed but thin is a solid, a sheet with both its sides in the file is not.
	const std::string blade = "v 0 0 0\nv 0 1 0\nv 1 0 -.026\nv 1 1 -.026\nv 1 0 .026\nv 1 1 .026\n"
							  "f 1 2 4 3\nf 1 5 6 2\nf 3 4 6 5\nf 1 3 5\nf 2 6 4\n";
	ASSERT_NO_THROW(builder::intake(builder::parseObj(blade)));
	EXPECT_EQ(told(builder::parseObj(blade), 0.2), 0);
	EXPECT_EQ(told(builder::parseObj(objText(boxMesh({0.5, 0.5, 0.001}, 1))), 1), 0);
	EXPECT_GT(told(builder::parseObj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nv 0 0 -1e-6\nv 1 0 -1e-6\n"
									 "v 1 1 -1e-6\nv 0 1 -1e-6\nf 8 7 6 5\n"),
				   0.2),
			  50);
}

// Coarser than asked for where it would have too many triangles, and says so.
TEST(Wrap, HasNoMoreTrianglesThanAreWanted)
{
	constexpr double kLength = 0.05;
	constexpr std::size_t kMost = 2000;
	builder::Soup soup;  // a bumpy sheet, whose wrap turns everywhere
	for (std::uint32_t i = 0; i < 20 * 20; ++i)
	{
		const double x = i % 20, y = i / 20;
		soup.vertices.push_back({x / 20, y / 20, 0.03 * std::sin(x * y)});
		if (i % 20 == 0 || i < 20) continue;
		soup.corners.insert(soup.corners.end(), {i, i - 1, i - 21, i - 20});
		soup.endPolygon();
	}
	ASSERT_GT(builder::wrapAround(soup, kLength).solid.mesh.triangles.size(), kMost);
	const Repaired wrap = builder::wrapAround(soup, kLength, kMost);
	EXPECT_LE(wrap.solid.mesh.triangles.size(), kMost);
	EXPECT_GT(wrap.solid.mesh.triangles.size(), kMost / 4) << "no coarser than it has to be";
	EXPECT_NE(joined(wrap.changes).find("closed instead of 0.05"), std::string::npos) << joined(wrap.changes);
	EXPECT_EQ(joined(builder::wrapAround(soup, 1, kMost).changes).find("instead"), std::string::npos);
}

TEST(Wrap, RefusesMillionsOfTriangles)
{
	EXPECT_THROW(builder::wrapAround(builder::parseObj(kCube), 1e-4), builder::Refused);
	EXPECT_THROW(builder::wrapAround(builder::parseObj(kCube), 0), builder::Refused);
}
}  // namespace clod::test
