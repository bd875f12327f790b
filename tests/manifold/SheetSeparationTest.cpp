// SPDX-License-Identifier: GPL-3.0-or-later
// A body apart from a sheet is left alone for as long as comparing the two anew would find nothing, and no longer.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "clod/manifold/SheetSeparation.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
// Waves of a tenth of the size, that wide, round a place.
NearTriangles waves(double size, const Vec3& place)
{
	constexpr int kCells = 12;
	const auto at = [&](int i, int j)
	{
		const double x = 2.0 * i / kCells - 1, z = 2.0 * j / kCells - 1;
		return place + size * Vec3{x, 0.1 * std::sin(7 * x) * std::cos(5 * z), z};
	};
	NearTriangles triangles;
	for (int i = 0; i < kCells; ++i)
		for (int j = 0; j < kCells; ++j)
		{
			triangles.add({at(i, j), at(i, j + 1), at(i + 1, j)});
			triangles.add({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
		}
	return triangles;
}
}  // namespace

TEST(SheetSeparation, HoldsUntilTheBodyCanTouch)
{
	Random random(5);
	int held = 0, near = 0, all = 0;
	for (const char* name : {"cup-3000", "torus-900", "spoon-3000"})
		for (int approach = 0; approach < 12; ++approach)
		{
			const Hierarchy& hierarchy = *body(name).hierarchy;
			const double radius = double(hierarchy.asset().radius), tolerance = 0.01 * radius;
			Metric metric;
			metric.exact = approach % 3 == 0;
			if (approach % 3 == 1) metric.weightedDeviation = 0.1 * radius;
			if (approach % 3 == 2) metric.maxError = 0.05 * radius;
			const Vec3 place = approach % 2 ? 1000 * radius * randomDirection(random) : Vec3{};  // of the mesh, its origin afar
			const NearTriangles triangles = waves(1.5 * radius, place);
			Mat3 turn = randomRotation(random);
			const bool spins = approach % 4 > 1;  // over crests, just above where it is first; or comes down and goes up again
			const double angle = spins ? 0.04 : 0;
			const Mat3 turned = spins ? Mat3{{{std::cos(angle), 0, std::sin(angle)}, {0, 1, 0}, {-std::sin(angle), 0, std::cos(angle)}}}
									  : randomRotation(random, 0.01);
			Vec3 middle{0, (spins ? 0.2 : 1.3) * radius, 0};  // from the waves'
			double speed = -0.01 * radius;
			SheetSeparation separation;
			PartnerContacts partner;
			PartnerStats stats;
			Transform aFromB;
			const auto meets = [&](double within)
			{
				std::vector<Contact> contacts;
				aFromB = inverse(Transform{turn, place + middle});
				partner.withTriangles(hierarchy, triangles, aFromB, [](const Vec3&, double) { return 1; }, 2 * radius, metric, within,
									  contacts, stats);
				return !contacts.empty();
			};
			while (spins && meets(1.2 * tolerance)) middle.y += 0.01 * radius;
			for (int step = 0; step < 150; ++step)
			{
				turn = turned * turn;
				if (!spins) middle += speed * Vec3{0.2 * uniform(random, -1, 1), uniform(random, 0, 1), 0};
				if (middle.y < 0.8 * radius) speed = std::abs(speed);
				const double within = tolerance * uniform(random, 0.9, 1.1);
				const bool isNear = meets(within), isHeld = separation.holds(hierarchy, aFromB, metric, within);
				const bool isApart =
					isHeld || separation.seek(partner, hierarchy, triangles, aFromB, metric, within, radius, stats);
				ASSERT_FALSE(isApart && isNear) << name << " " << approach << " step " << step << " held " << isHeld;
				held += isHeld;
				near += isNear;
				++all;
			}
		}
	std::printf("%d steps, %d held, %d near\n", all, held, near);
	EXPECT_GT(held, all / 6);
	EXPECT_GT(near, all / 5);
}

// Those that came near since, or were edited, are to be compared; neighbours of them are not.
TEST(SheetSeparation, OthersAreNotKnown)
{
	const Hierarchy& hierarchy = *body("torus-900").hierarchy;
	const double radius = double(hierarchy.asset().radius);
	NearTriangles triangles = waves(radius, {}), others;
	SheetSeparation separation;
	PartnerContacts partner;
	PartnerStats stats;
	ASSERT_TRUE(separation.seek(partner, hierarchy, triangles, {{}, {0, -1.4 * radius, 0}}, {}, 0, radius, stats));
	separation.listOthers(triangles, others);
	EXPECT_TRUE(others.corners.empty());
	std::swap(triangles.corners[3], triangles.corners[7]);
	triangles.corners[5][1].y += 1e-12 * radius;
	triangles.add({Vec3{}, Vec3{0, 0, radius}, Vec3{radius, 0, 0}});
	triangles.add({Vec3{}, Vec3{0, 0, 2 * radius}, Vec3{radius, 0, 0}}, false);
	separation.listOthers(triangles, others);
	ASSERT_EQ(others.corners.size(), 2u);
	EXPECT_EQ(others.corners[0], triangles.corners[5]);
	EXPECT_EQ(others.corners[1], triangles.corners[triangles.corners.size() - 2]);
}

// What another metric, or more tolerance than is left, would find is not known.
TEST(SheetSeparation, IsOfOneMetricAndTolerance)
{
	const Hierarchy& hierarchy = *body("torus-900").hierarchy;
	const double radius = double(hierarchy.asset().radius);
	const Transform aFromB{{}, {0, -1.4 * radius, 0}};
	Metric metric, other;
	other.maxError = 0.05 * radius;
	SheetSeparation separation;
	PartnerContacts partner;
	PartnerStats stats;
	ASSERT_TRUE(separation.seek(partner, hierarchy, waves(radius, {}), aFromB, metric, 0, radius, stats));
	EXPECT_TRUE(separation.holds(hierarchy, aFromB, metric, 0));
	EXPECT_TRUE(separation.holds(hierarchy, aFromB, metric, 0.01 * radius));
	EXPECT_FALSE(separation.holds(hierarchy, aFromB, metric, radius));
	EXPECT_FALSE(separation.holds(hierarchy, aFromB, other, 0));
}
}  // namespace clod::test
