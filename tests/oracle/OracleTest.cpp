// SPDX-License-Identifier: GPL-3.0-or-later
// The oracle itself: it measures depth as it is, holds right contacts for right, and sees each planted fault.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/oracle/BoxOverFloor.h"

namespace clod::oracle
{
namespace
{
constexpr double kPi = 3.14159265358979323846;
constexpr std::size_t kPoses = 150;

// What is true of that pair: every corner against the plane. With faults to be planted.
struct Faults
{
	bool ghost = false, missing = false, wrongSide = false, sideways = false;
	double depth = 1;
};
class CornersOverPlane : public Subject
{
public:
	CornersOverPlane(const BodyPair& pair, const Faults& faults) : m_a{pair.a}, m_b{pair.b}, m_faults(faults) {}
	const std::vector<TriangleMesh>& surfacesA() const override { return m_a; }
	const std::vector<TriangleMesh>& surfacesB() const override { return m_b; }
	double skin() const override { return 5e-4 * std::sqrt(0.77); }
	Answer answer(const Transform& aFromB, const RelativeMotion&) override
	{
		Answer answer;
		const Vec3 normal = aFromB.rotation.column(1);
		const double plane = dot(normal, aFromB.translation) + kHalfOfB.y;
		for (const Vec3& corner : m_a[0].vertices)
		{
			const double distance = dot(normal, corner) - plane;
			answer.constraints.push_back({corner, normal, distance < 0 ? m_faults.depth * distance : distance});
		}
		const auto lower = [](const Constraint& l, const Constraint& r) { return l.distance < r.distance; };
		std::sort(answer.constraints.begin(), answer.constraints.end(), lower);
		if (m_faults.missing) answer.constraints.erase(answer.constraints.begin());
		if (m_faults.wrongSide) answer.constraints[0].normal = -answer.constraints[0].normal;
		if (m_faults.sideways) answer.constraints[0].normal = aFromB.rotation.column(0);
		if (m_faults.ghost) answer.constraints.push_back({{}, aFromB.rotation.column(0), -0.01});
		return answer;
	}

private:
	std::vector<TriangleMesh> m_a, m_b;
	Faults m_faults;
};

FamilyResult judged(const Family& family, const MakeSubject& make)
{
	return FamilyTrials(family, make, TrialRules()).runAll(kPoses);
}
FamilyResult judged(const Faults& faults)
{
	return judged(boxOverFloor(0.3), [faults](const BodyPair& pair)
				  { return std::make_unique<CornersOverPlane>(pair, faults); });
}
int faultsOf(const FamilyResult& result)
{
	int faults = result.ghosts + result.unanswered;
	for (const Tally& tally : result.kinds) faults += tally.faults();
	return faults;
}

TEST(Overlap, MeasuresTheDepthOfSimplePoses)
{
	const Solid cube(box({1, 1, 1}));
	for (const double depth : {0.3, 0.01, 1e-5})
	{
		Overlap overlap(cube, cube, {{}, {0.31, -2 + depth, 0.17}}, 0.1);
		EXPECT_FALSE(overlap.isApart());
		EXPECT_NEAR(overlap.depth({}), depth, 1e-12);
	}
	EXPECT_TRUE(Overlap(cube, cube, {{}, {0.31, -2.00001, 0.17}}, 0.1).isApart());
	const Solid small(box({0.2, 0.2, 0.2}));
	EXPECT_FALSE(Overlap(cube, small, {{}, {0.1, 0.2, 0.3}}, 0.1).isApart()) << "one inside the other";
}

TEST(Overlap, MeasuresCrossedEdgesByTheWayOutOverBoth)
{
	for (const double degrees : {20.0, 60.0, 90.0, 150.0})
	{
		const Solid below(wedge(degrees * kPi / 180, 0.5, 1));
		// Upside down, and turned by a right angle about y: rows are the axes of A in B.
		const Transform pose{{{{0, 0, 1}, {0, -1, 0}, {1, 0, 0}}}, {0.05, -0.01, 0.1}};
		Overlap overlap(below, below, pose, 0.1);
		EXPECT_FALSE(overlap.isApart());
		EXPECT_NEAR(overlap.depth({}), 0.01, 1e-9) << degrees;
		EXPECT_NEAR(overlap.depth({{}, {0, -0.006, 0}}), 0.004, 1e-9) << degrees;
		EXPECT_EQ(overlap.depth({{}, {0, -0.0101, 0}}), 0) << degrees;
	}
}

TEST(MotionSpace, LengthIsTheKineticEnergy)
{
	const Solid cube(box({0.5, 0.5, 0.5})), heavy(box({50, 50, 50}));
	const MotionSpace space(cube, heavy, {{}, {0, -60, 0}});
	// Unit mass against a million: the energy of the small one.
	const Vec6 y = space.coordinates({{3, 0, 0}, {0, 2, 0}, 1});
	EXPECT_NEAR(dot(y, y), 9 + 4.0 / 6, 1e-3);
	const RelativeMotion back = space.motion(y, 1);
	EXPECT_NEAR(back.linear.x, 3, 1e-9);
	EXPECT_NEAR(back.angular.y, 2, 1e-9);
	const Vec3 point{0.1, -0.2, 0.4}, n{0, 0.6, 0.8};
	EXPECT_NEAR(dot(space.gradient(point, n), y), dot(n, back.velocity(point)), 1e-9);
}

TEST(MotionSpace, LeastChangeIsTheNearestPointOfTheIntersection)
{
	// x >= 1, x + y >= 3: from the origin the nearest is (1.5, 1.5); from (4, -3) it is (5, -2).
	const std::vector<HalfSpace> set = {{{1, 0}, -1}, {{1, 1}, -3}};
	const Vec6 first = leastChange(set, {}), second = leastChange(set, {4, -3});
	EXPECT_NEAR(first[0], 1.5, 1e-6);
	EXPECT_NEAR(first[1], 1.5, 1e-6);
	EXPECT_NEAR(second[0], 5, 1e-6);
	EXPECT_NEAR(second[1], -2, 1e-6);
}

TEST(BestHalfSpace, SeparatesWhatCanBeSeparated)
{
	Random random(3);
	std::vector<Labelled> apart, corner;
	for (int i = 0; i < 300; ++i)
	{
		Vec6 y;
		for (double& x : y) x = normal(random);
		const double side = 0.6 * y[0] + 0.8 * y[4];
		if (std::fabs(side) > 0.1) apart.push_back({y, side > 0, side < 0});
		corner.push_back({y, y[0] > 0 && y[4] > 0, y[0] < -0.1 || y[4] < -0.1});
	}
	EXPECT_EQ(bestHalfSpaceFaults(apart, 0, random), 0);
	EXPECT_GT(bestHalfSpaceFaults(corner, 0, random), 5) << "two half spaces are not one";
}

TEST(Oracle, HoldsRightContactsForRight)
{
	const FamilyResult result = judged(Faults());
	EXPECT_EQ(faultsOf(result), 0) << result.worstPose;
	EXPECT_EQ(result.unmade, 0);
	EXPECT_GT(result.of(Kind::near5).free, 1000);
	EXPECT_GT(result.of(Kind::near5).admitted, 1000);
	EXPECT_GT(result.overlapping, 10);
	EXPECT_GT(result.apart, 50);
}

TEST(Oracle, SeesAGhost)
{
	Faults faults;
	faults.ghost = true;
	const FamilyResult result = judged(faults);
	EXPECT_EQ(result.ghosts, result.apart);
	EXPECT_GT(result.of(Kind::near5).changed, 100);
}

TEST(Oracle, SeesAMissingContact)
{
	Faults faults;
	faults.missing = true;
	EXPECT_GT(judged(faults).of(Kind::near5).pierced, 100);
}

TEST(Oracle, SeesANormalOfTheWrongSide)
{
	Faults faults;
	faults.wrongSide = true;
	const FamilyResult result = judged(faults);
	EXPECT_GT(result.of(Kind::near5).pierced, 100);
	EXPECT_GT(result.of(Kind::near5).changed, 100);
	faults = Faults();
	faults.sideways = true;
	EXPECT_GT(judged(faults).of(Kind::near5).faults(), 100);
}

TEST(Oracle, SeesHalfOfTheDepth)
{
	Faults faults;
	faults.depth = 0.5;
	EXPECT_GT(judged(faults).of(Kind::small).pierced, 20);
}

TEST(Oracle, SeesThatAnOverlapIsNotAnswered)
{
	Faults faults;
	faults.depth = 0;
	const FamilyResult result = judged(faults);
	EXPECT_GT(result.overlapping, 10);
	EXPECT_EQ(result.unanswered, result.overlapping);
}

// A box that is a little in a plate, and goes through it: it ends apart, but nothing may let it.
TEST(Oracle, AWayThroughABodyIsNotFree)
{
	const Solid cube(box({0.3, 0.3, 0.3})), plate(box({1, 0.005, 1}));
	Case which;
	which.aFromB = {{}, {0, -0.3045, 0}};
	which.motion = {{0, -0.65, 0}, {}, 1};
	Random random(1);
	for (const bool goesThrough : {true, false})
	{
		if (!goesThrough) which.motion.linear.y = 0.65;
		const Verdict verdict = judge(cube, plate, which, {}, 1e-3, JudgeRules(), random);
		const Tally& tally = verdict.kinds[std::size_t(Kind::near5)];
		EXPECT_GT(verdict.startDepth, 5e-4);
		EXPECT_EQ(tally.free, goesThrough ? 0 : tally.motions);
		EXPECT_EQ(tally.pierced, goesThrough ? tally.motions : 0);
	}
}

TEST(Oracle, RepeatsAPoseByItsIndex)
{
	const auto make = [](const BodyPair& pair) { return std::make_unique<CornersOverPlane>(pair, Faults()); };
	const Family family = boxOverFloor(0.3);
	FamilyTrials first(family, make, TrialRules()), second(family, make, TrialRules());
	for (std::size_t i = 0; i < 5; ++i) first.run(i);
	const auto early = first.run(7), late = second.run(7);
	ASSERT_TRUE(early && late);
	EXPECT_EQ(early->which.aFromB.translation, late->which.aFromB.translation);
	EXPECT_EQ(early->verdict.kinds[0].depths, late->verdict.kinds[0].depths);
}

TEST(Families, AllMeet)
{
	for (const Family& family : families())
	{
		const std::vector<BodyPair> pairs = family.pairs();
		std::vector<Solid> solids;
		for (const BodyPair& pair : pairs)
		{
			solids.emplace_back(pair.a);
			solids.emplace_back(pair.b);
		}
		int made = 0;
		for (std::size_t i = 0; i < 6; ++i)
		{
			const CaseChoice choice = chooseCase(family, pairs.size(), 1, i);
			made += makeCase(family, pairs[choice.pair], choice, solids[2 * choice.pair], solids[2 * choice.pair + 1])
						.has_value();
		}
		EXPECT_GE(made, 5) << family.name;
	}
}
}  // namespace
}  // namespace clod::oracle
