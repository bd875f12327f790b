// SPDX-License-Identifier: GPL-3.0-or-later
// One-piece hierarchies keep the rules of files, but for cores without area.
#include "clod/hierarchy/ConvexPiece.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/query/Bodies.h"

namespace clod::test
{
TEST(ConvexPiece, KeepsEveryRuleOfAFile)
{
	Random random(5);
	for (int round = 0; round < 30; ++round)
	{
		std::vector<Vec3> points;
		const double scale = std::pow(10.0, round % 7 - 3);
		for (int i = 0; i < 5 + 8 * round; ++i)
			points.push_back(scale * (randomVector(random, 0.2, 1) + Vec3{0, 0.1 * round, 0}));
		const auto piece = convexPiece(convexPolyhedron(points, 65535), 0.1 * scale * (round % 2));
		ASSERT_TRUE(piece) << piece.error();
		EXPECT_EQ(validate(*piece.value()), "") << round;
		EXPECT_TRUE(Hierarchy::fromBytes(piece.value()->bytes()));
		// A planted fault: a corner moved is found.
		std::vector<std::byte> bytes = piece.value()->bytes();
		bytes[bytes.size() - 7] ^= std::byte(1);
		EXPECT_FALSE(Hierarchy::fromBytes(bytes));
	}
}

TEST(ConvexPiece, VolumeAndInertiaAreThoseOfTheSolid)
{
	std::vector<Vec3> points;
	for (int i = 0; i < 8; ++i) points.push_back({2.0 * (i & 1) + 5, 1.0 * (i >> 1 & 1), 4.0 * (i >> 2)});
	const auto piece = convexPiece(convexPolyhedron(points, 65535), 0.25);
	ASSERT_TRUE(piece) << piece.error();
	const Asset& asset = piece.value()->asset();
	EXPECT_NEAR(asset.volume, 8, 1e-9);
	EXPECT_NEAR(asset.inertia[0], 8.0 / 12 * (1 + 16), 1e-3);
	EXPECT_NEAR(asset.inertia[1], 8.0 / 12 * (4 + 16), 1e-3);
	EXPECT_NEAR(double(asset.radius), 0.5 * std::sqrt(4.0 + 1 + 16) + 0.25, 1e-4);
}

TEST(ConvexPiece, CoresWithoutAreaAreOfMemoryOnly)
{
	for (const std::vector<Vec3>& points : {std::vector<Vec3>{{1, 2, 3}}, std::vector<Vec3>{{0, 0, 0}, {0, 1, 0}}})
	{
		const auto core = convexPiece(convexPolyhedron(points, 100), 0.5);
		ASSERT_TRUE(core) << core.error();
		EXPECT_TRUE(core.value()->isThinCore());
		EXPECT_NEAR(double(core.value()->asset().radius), points.size() == 1 ? 0.5 : 1, 1e-5);
		EXPECT_FALSE(Hierarchy::fromBytes(core.value()->bytes()));
	}
}

TEST(ConvexPiece, RefusesWithAReason)
{
	EXPECT_FALSE(convexPiece({}, 0));
	EXPECT_FALSE(convexPiece(convexPolyhedron({{0, 0, 0}}, 4), -1));
	EXPECT_FALSE(convexPiece({{{0, 0, std::numeric_limits<double>::quiet_NaN()}}, {}, 0}, 1));
	const auto flat = convexPiece(convexPolyhedron({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, 4), 0);
	EXPECT_EQ(flat.error(), "a convex piece is flat");
}
}  // namespace clod::test
