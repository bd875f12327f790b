// SPDX-License-Identifier: GPL-3.0-or-later
// What the oracle reads from Bullet.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/bullet/PatchHierarchy.h"
#include "tests/fixtures/Recipes.h"
#include "tests/oracle/BoxOverFloor.h"
#include "tests/oracle/BulletSubject.h"
#include "tests/query/Bodies.h"
#include "tests/support/HierarchyContents.h"

namespace clod::oracle
{
namespace
{
constexpr std::size_t kSubjectPoses = 150;

// Of poses that overlap: no fault of any kind. Returns how many there were.
int expectRightWhereFlat(const MakeSubject& make)
{
	FamilyTrials trials(boxOverFloor(0), make, TrialRules());
	int looked = 0;
	for (std::size_t i = 0; i < kSubjectPoses; ++i)
	{
		const std::optional<Trial> trial = trials.run(i);
		if (!trial || trial->verdict.startDepth < 1e-5) continue;
		++looked;
		EXPECT_TRUE(trial->verdict.isAnswered) << i;
		for (const Tally& tally : trial->verdict.kinds) EXPECT_EQ(tally.faults(), 0) << i;
	}
	return looked;
}

// Only where they overlap: of boxes apart Bullet's say nothing, however near they are.
TEST(Oracle, HoldsBulletsBoxOnBoxForRight)
{
	EXPECT_GT(expectRightWhereFlat([](const BodyPair&) { return boxSubject(kHalfOfA, kHalfOfB); }), 30);
}

TEST(Oracle, HoldsOurFlatBoxForRight)
{
	const auto hierarchyOf = [](const Vec3& half)
	{ return test::patchHierarchy(test::boxMesh(2 * half, {1, 1, 1}, 1)); };
	const auto make = [&](const BodyPair&)
	{ return clodSubject(hierarchyOf(kHalfOfA), hierarchyOf(kHalfOfB), ContactMetric::exactly()); };
	EXPECT_GT(expectRightWhereFlat(make), 30);
}

FamilyResult judgedExactly(const Family& family)
{
	const auto make = [](const BodyPair& pair)
	{
		const auto hierarchyOf = [](const TriangleMesh& mesh)
		{
			builder::Mesh input;
			input.vertices = mesh.vertices;
			input.triangles = mesh.triangles;
			return test::loaded(test::built(input));
		};
		return clodSubject(hierarchyOf(pair.a), hierarchyOf(pair.b), ContactMetric::exactly());
	};
	return FamilyTrials(family, make, TrialRules()).runAll(2 * kSubjectPoses);
}

// Motions up to 30 degrees off the predicted one: what nobody has looked for nothing keeps from.
TEST(Oracle, WhatMeetsLittleIsLookedForAside)
{
	int asked = 0;
	for (const Family& family : families())
	{
		if (family.name != "box-on-seam" && family.name != "corner-in-corner") continue;
		++asked;
		const FamilyResult result = judgedExactly(family);
		const Tally& aside = result.of(Kind::near30);
		EXPECT_GT(aside.bestHalfSpace, 10) << family.name;
		EXPECT_LE(aside.faults(), 1.2 * aside.bestHalfSpace) << family.name;
	}
	EXPECT_EQ(asked, 2);
}

// Edge on edge: the side that the motion leaves to counts where the bodies overlap, too.
TEST(Oracle, EdgesAllButParallelAreLeftToOneSide)
{
	const auto isAsked = [](const Family& family) { return family.name == "wedges-parallel"; };
	const auto family = std::find_if(families().begin(), families().end(), isAsked);
	ASSERT_NE(family, families().end());
	const FamilyResult result = judgedExactly(*family);
	const Tally &near5 = result.of(Kind::near5), &near30 = result.of(Kind::near30);
	EXPECT_LT(near5.faults(), 0.006 * near5.motions);
	EXPECT_LT(near30.faults(), 0.04 * near30.motions);
}

// The surfaces are closed (Solid throws otherwise) and near each other, and a pose is judged by those in use.
TEST(BulletSubject, KnowsTheSurfacesOfItsLevels)
{
	const HierarchyPointer torus = test::body("torus", 900).hierarchy;
	const std::vector<TriangleMesh> surfaces = levelSurfaces(*torus);
	ASSERT_GT(surfaces.size(), 2u);
	EXPECT_EQ(surfaces[0].triangles.size(), torus->asset().triangleCount);
	for (const TriangleMesh& surface : surfaces)
		EXPECT_NEAR(Solid(surface).volume() / torus->asset().volume, 1, 0.15) << surface.triangles.size();
	const double radius = torus->asset().radius;
	const RelativeMotion still{{}, {}, 1.0 / 240};
	const Transform near{{}, {0, 0.78 * radius, 0}}, far{{}, {0, 5 * radius, 0}};
	const auto coarse = clodSubject(torus, torus, ContactMetric::deviationShare(0.035));
	EXPECT_FALSE(coarse->answer(far, still).knowsSurfaces);
	const Answer exact = clodSubject(torus, torus, ContactMetric::exactly())->answer(near, still);
	EXPECT_EQ(exact.surfaceA, 0u);
	EXPECT_EQ(exact.surfaceB, 0u);
}

TEST(BulletSubject, RemembersNothing)
{
	const auto cube = test::cube();
	const auto fresh = clodSubject(cube, cube, ContactMetric::exactly()),
			   used = clodSubject(cube, cube, ContactMetric::exactly());
	const RelativeMotion motion{{0.1, 0.4, 0.2}, {0.5, 0, 0}, 1.0 / 240};
	used->answer({{}, {0.2, -0.999, 0}}, motion);
	used->answer({{}, {0.3, -0.9995, 0.1}}, {{}, {}, 1.0 / 240});
	const Transform pose{{}, {0.25, -1.0005, 0}};
	const Answer first = fresh->answer(pose, motion), again = used->answer(pose, motion);
	ASSERT_FALSE(first.constraints.empty());
	ASSERT_EQ(first.constraints.size(), again.constraints.size());
	for (std::size_t i = 0; i < first.constraints.size(); ++i)
	{
		EXPECT_EQ(first.constraints[i].point, again.constraints[i].point);
		EXPECT_EQ(first.constraints[i].distance, again.constraints[i].distance);
	}
}
}  // namespace
}  // namespace clod::oracle
