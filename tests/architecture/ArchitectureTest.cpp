// SPDX-License-Identifier: GPL-3.0-or-later
// The rules on the sources as they are, and each shown to find what it is for.
#include <gtest/gtest.h>

#include "tests/architecture/Rules.h"

namespace clod::test
{
namespace
{
const Sources& product()
{
	static const Sources sources = readProduct(CLOD_SOURCE_FOLDER);
	return sources;
}

std::string lines(const Faults& faults)
{
	std::string text;
	for (const std::string& fault : faults) text += fault + "\n";
	return text;
}

constexpr const char* kZlib = "// SPDX-License-Identifier: Zlib\n";
constexpr const char* kGpl = "// SPDX-License-Identifier: GPL-3.0-or-later\n";

// A small product without a fault, with what a test plants in it: files besides, or in place of those of their names.
Sources planted(const Sources& faulty)
{
	Sources sources = {
		{"plugin/clod/collide/Box.h", "#pragma once\n"},
		{"plugin/clod/collide/Box.cpp", "#include \"clod/collide/Box.h\"\n#include <cmath>\n"},
		{"plugin/clod/query/Query.h", "#include \"clod/collide/Box.h\"\n"},
		{"plugin/clod/query/Query.cpp", "#include \"clod/query/Query.h\"\n#include \"clod/query/Rule.h\"\n"},
		{"plugin/clod/query/Rule.h", "#pragma once\n"},
		{"plugin/clod/query/Front.cpp", "#include \"clod/query/Rule.h\"\n"},
		{"plugin/clod/bullet/Shape.cpp", "#include <LinearMath/btVector3.h>\n#include \"clod/query/Query.h\"\n"},
		{"builder/Hull.cpp", "#include <CGAL/Surface_mesh.h>\n#include \"builder/Lod.h\"\n"},
		{"demos/Main.cpp", "#include \"clod/query/Query.h\"\n"},
	};
	for (Source& source : sources)
	{
		const bool isOfBuilder = source.path.compare(0, 8, "builder/") == 0;
		source.text.insert(0, isOfBuilder ? kGpl : kZlib);
	}
	for (const Source& source : faulty)
	{
		bool replaced = false;
		for (Source& there : sources)
			if (there.path == source.path) there = source, replaced = true;
		if (!replaced) sources.push_back(source);
	}
	return sources;
}

using Rule = Faults (*)(const Sources&);
void expectFault(Rule rule, const Sources& faulty, const std::string& fault)
{
	EXPECT_EQ(lines(rule(planted({}))), "");
	EXPECT_EQ(lines(rule(planted(faulty))), fault + "\n");
}
}  // namespace

TEST(Architecture, ReadsTheSources)
{
	std::size_t ofPlugin = 0;
	for (const Source& source : product())
	{
		EXPECT_FALSE(source.text.empty()) << source.path;
		if (source.path.compare(0, 12, "plugin/clod/") == 0) ++ofPlugin;
	}
	EXPECT_GT(ofPlugin, 80U);
	EXPECT_GT(product().size(), 2 * ofPlugin);
}

TEST(Architecture, NoIncludeRunsUpward)
{
	EXPECT_EQ(lines(upwardIncludes(product())), "");
}

TEST(Architecture, LibrariesStayInTheirPlaces)
{
	EXPECT_EQ(lines(foreignIncludes(product())), "");
}

TEST(Architecture, OnlyTheBuilderIncludesTheBuilder)
{
	EXPECT_EQ(lines(builderIncludes(product())), "");
}

TEST(Architecture, TestsOfThePluginNeedNoBuilder)
{
	EXPECT_EQ(lines(buildersInPluginTests(readTests(CLOD_SOURCE_FOLDER))), "");
}

TEST(Architecture, FoldersAndSourcesAreSmall)
{
	EXPECT_EQ(lines(crowdedFolders(product())), "");
	EXPECT_EQ(lines(longSources(product())), "");
}

TEST(Architecture, NoHeaderServesOneForeignSource)
{
	EXPECT_EQ(lines(headersOfOneSource(product())), "");
}

TEST(Architecture, NoConstantIsDefinedTwice)
{
	EXPECT_EQ(lines(constantsDefinedTwice(product())), "");
}

TEST(Architecture, EachSourceBeginsWithItsLicence)
{
	EXPECT_EQ(lines(wrongLicences(product())), "");
}

TEST(ArchitectureRules, FindAWrongLicence)
{
	const std::string fault = " does not begin with '// SPDX-License-Identifier: ";
	for (const char* text : {"", "// SPDX-License-Identifier: Zlib What the file is for.\n", kGpl, "#pragma once\n"})
		expectFault(wrongLicences, {{"plugin/clod/query/Rule.h", text}}, "plugin/clod/query/Rule.h" + fault + "Zlib'");
	expectFault(wrongLicences, {{"builder/Hull.cpp", kZlib}}, "builder/Hull.cpp" + fault + "GPL-3.0-or-later'");
	EXPECT_EQ(lines(wrongLicences(planted({{"builder/Part.cpp", kGpl}, {"demos/Cup.cpp", kZlib}}))), "");
}

TEST(ArchitectureRules, FindAConstantDefinedTwice)
{
	const std::string constant = "inline constexpr double kShare = 0.2;\n";
	expectFault(constantsDefinedTwice, {{"plugin/clod/collide/Box.h", constant}, {"plugin/clod/query/Rule.h", "\n" + constant}},
				"kShare is defined in plugin/clod/collide/Box.h and in plugin/clod/query/Rule.h");
}

TEST(ArchitectureRules, FindAnUpwardInclude)
{
	expectFault(upwardIncludes, {{"plugin/clod/collide/Box.h", "  #  include <clod/query/Query.h>\n"}},
				"plugin/clod/collide/Box.h includes clod/query/Query.h, which lies above it");
	expectFault(upwardIncludes, {{"plugin/clod/collide/Box.h", "#include \"../query/Query.h\"\n"}},
				"plugin/clod/collide/Box.h includes ../query/Query.h, not named from plugin/");
	expectFault(upwardIncludes, {{"plugin/clod/collide/Box.h", "#include \"clod/collide/Bax.h\"\n"}},
				"plugin/clod/collide/Box.h includes clod/collide/Bax.h, which is no file");
	expectFault(upwardIncludes, {{"plugin/clod/spare/Part.h", ""}},
				"plugin/clod/spare/Part.h lies in no folder of the order");
}

TEST(ArchitectureRules, FindTheEngineWhereItIsNotKnown)
{
	for (const char* header : {"LinearMath/btVector3.h", "BulletCollision/CollisionShapes/btBoxShape.h",
							   "btBulletDynamicsCommon.h", "bullet/btBulletCollisionCommon.h"})
		expectFault(foreignIncludes,
					{{"plugin/clod/manifold/Points.cpp", "#include <" + std::string(header) + ">\n"}},
					"plugin/clod/manifold/Points.cpp includes " + std::string(header) + ", but knows no engine");
}

TEST(ArchitectureRules, FindTheBuildersLibraries)
{
	for (const char* header : {"CGAL/Surface_mesh.h", "Eigen/Dense"})
		expectFault(foreignIncludes, {{"plugin/clod/bullet/Shape.cpp", "#include <" + std::string(header) + ">\n"}},
					"plugin/clod/bullet/Shape.cpp includes " + std::string(header) +
						", of a library of the builder's");
}

TEST(ArchitectureRules, FindTheBuilderOutsideItself)
{
	for (const char* path : {"demos/models/Cup.cpp", "cli/Program.cpp", "plugin/clod/query/Rule.h"})
		expectFault(builderIncludes, {{path, "#include \"builder/Lod.h\"\n"}},
					std::string(path) + " includes builder/Lod.h, of the builder");
}

TEST(ArchitectureRules, FindTheBuilderInATestOfThePlugin)
{
	const Sources leaf = {{"tests/support/Leaf.h", "#include \"builder/Lod.h\"\n"},
						  {"tests/builder/PartsTest.cpp", "#include \"tests/support/Leaf.h\"\n"}};
	EXPECT_EQ(lines(buildersInPluginTests(leaf)), "");
	Sources faulty = leaf;
	faulty.push_back({"tests/manifold/DeepTest.cpp", "#include \"tests/support/Leaf.h\"\n"});
	EXPECT_EQ(lines(buildersInPluginTests(faulty)),
			  "tests/manifold/DeepTest.cpp reaches builder/Lod.h, of the builder\n");
}

TEST(ArchitectureRules, FindACrowdedFolder)
{
	Sources many;  // beside query's four
	for (std::size_t i = 0; i < kMostSourcesOfFolder - 4; ++i)
		many.push_back({"plugin/clod/query/Part" + std::to_string(i) + ".cpp", ""});
	EXPECT_EQ(lines(crowdedFolders(planted(many))), "");
	many.push_back({"plugin/clod/query/Last.h", ""});
	expectFault(crowdedFolders, many, "plugin/clod/query holds 37 sources");
}

TEST(ArchitectureRules, FindALongSource)
{
	EXPECT_EQ(lines(longSources(planted({{"plugin/clod/query/Rule.h", std::string(500, '\n')}}))), "");
	expectFault(longSources, {{"plugin/clod/query/Rule.h", std::string(501, '\n')}},
				"plugin/clod/query/Rule.h has 501 lines");
}

TEST(ArchitectureRules, FindAHeaderOfOneForeignSource)
{
	expectFault(headersOfOneSource, {{"plugin/clod/query/Front.cpp", ""}},
				"plugin/clod/query/Rule.h serves plugin/clod/query/Query.cpp alone");
	expectFault(headersOfOneSource, {{"plugin/clod/query/Spare.h", ""}}, "plugin/clod/query/Spare.h serves no source");
	// Through another header of that source, too.
	expectFault(headersOfOneSource,
				{{"plugin/clod/collide/Box.h", "#include \"clod/collide/Side.h\"\n"},
				 {"plugin/clod/collide/Side.h", ""},
				 {"plugin/clod/query/Query.h", ""}},
				"plugin/clod/collide/Side.h serves plugin/clod/collide/Box.cpp alone");
	// A header's own source may be its only one, and kernels have one by nature.
	EXPECT_EQ(lines(headersOfOneSource(planted({{"plugin/clod/query/Query.cpp", "#include \"clod/query/Own.h\"\n"
																				 "#include \"clod/query/Rule.h\"\n"},
												{"plugin/clod/query/Own.h", ""},
												{"plugin/clod/query/Own.cpp", "#include \"clod/query/Own.h\"\n"},
												{"plugin/clod/query/FastKernel.h", ""}}))),
			  "");
}
}  // namespace clod::test
