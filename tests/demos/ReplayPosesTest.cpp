// SPDX-License-Identifier: GPL-3.0-or-later
// POSES.csv: what is written reads back to the same bits, and every fault is refused with its line and column.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "demos/scenes/Poses.h"

namespace
{
using namespace clod;
using namespace clod::demo;

Pose randomPose(std::mt19937_64& random)
{
	std::normal_distribution<double> normal;
	Pose pose{{normal(random), 1e-7 * normal(random), 1e5 * normal(random)}, {}};
	double length = 0;
	for (double& component : pose.quaternion) length += std::pow(component = normal(random), 2);
	for (double& component : pose.quaternion) component /= std::sqrt(length);
	return pose;
}

std::string header()
{
	return std::string(kPosesHeader) + "\n";
}
const std::string kGoodRow = "3,0.1,0,0,0,0,0,1,0,0,-1e-3,0,1,0,0\n";

// The message of a text that must be refused.
std::string refusal(const std::string& text)
{
	const auto rows = parsePoses(text, "poses.csv");
	EXPECT_FALSE(rows) << text;
	return rows.error();
}

TEST(ReplayPoses, ReadBackToTheSameBits)
{
	std::mt19937_64 random(5);
	std::vector<PoseRow> rows;
	for (int i = 0; i < 200; ++i) rows.push_back({i, randomPose(random), randomPose(random)});
	const auto once = parsePoses(formatPoses(rows), "poses.csv");
	ASSERT_TRUE(once) << once.error();
	const auto twice = parsePoses(formatPoses(once.value()), "poses.csv");
	ASSERT_TRUE(twice) << twice.error();
	ASSERT_EQ(once.value().size(), rows.size());
	EXPECT_EQ(trajectoryHash(once.value()), trajectoryHash(twice.value()));
	for (std::size_t i = 0; i < rows.size(); ++i)
	{
		EXPECT_EQ(once.value()[i].a.position, rows[i].a.position);
		EXPECT_EQ(once.value()[i].b.position, rows[i].b.position);
	}
}

TEST(ReplayPoses, AcceptGoodRowsAndWindowsLineEndings)
{
	EXPECT_TRUE(parsePoses(header() + kGoodRow, "x"));
	EXPECT_TRUE(parsePoses(std::string(kPosesHeader) + "\r\n3,0.1,0,0,0,0,0,1,0,0,0,0,1,0,0\r\n", "x"));
}

TEST(ReplayPoses, RefuseFaultsWithLineAndColumn)
{
	EXPECT_NE(refusal("step,ax\n" + kGoodRow).find("poses.csv, line 1: the header"), std::string::npos);
	EXPECT_NE(refusal("").find("line 1"), std::string::npos);
	EXPECT_NE(refusal(header()).find("no poses"), std::string::npos);
	EXPECT_NE(refusal(header() + kGoodRow + "4,0\n").find("line 3: 2 fields, expected 15"), std::string::npos);
	EXPECT_NE(refusal(header() + kGoodRow + "\n" + kGoodRow).find("line 3: 1 fields"), std::string::npos);
	EXPECT_NE(refusal(header() + "1.5,0,0,0,0,0,0,1,0,0,0,0,0,0,1\n").find("column step"), std::string::npos);
	EXPECT_NE(refusal(header() + "-1,0,0,0,0,0,0,1,0,0,0,0,0,0,1\n").find("column step"), std::string::npos);
	EXPECT_NE(refusal(header() + "1,0,0,0,0,0,0,1,0,nan,0,0,0,0,1\n").find("column by"), std::string::npos);
	EXPECT_NE(refusal(header() + "1,0,inf,0,0,0,0,1,0,0,0,0,0,0,1\n").find("column ay"), std::string::npos);
	EXPECT_NE(refusal(header() + "1,0,0,1e999,0,0,0,1,0,0,0,0,0,0,1\n").find("column az"), std::string::npos);
	EXPECT_NE(refusal(header() + "1,0,0,0,0,0,0,1,0,0,0,0,0,0, 1\n").find("column bqw is \" 1\""), std::string::npos);
	EXPECT_NE(refusal(header() + "1,0,0,0,0,0,0,1,0,0,0,0,0,0,1x\n").find("column bqw"), std::string::npos);
	EXPECT_NE(refusal(header() + "1,0,0,0,0,0,0,0.9,0,0,0,0,0,0,1\n").find("quaternion of body a"), std::string::npos);
	EXPECT_NE(refusal(header() + "1,0,0,0,0,0,0,1,0,0,0,0,0,0,0\n").find("quaternion of body b"), std::string::npos);
	EXPECT_FALSE(readPoses("/nonexistent/poses.csv"));
}

TEST(ReplayPoses, OfManyBodiesNameTheirPair)
{
	const std::string good = std::string(kScenePosesHeader) + "\n" + kGoodRow.substr(0, kGoodRow.size() - 1);
	const auto rows = parsePoses(good + ",2,4\n", "x", 5);
	ASSERT_TRUE(rows) << rows.error();
	EXPECT_EQ(rows.value()[0].bodyA, 2u);
	EXPECT_EQ(rows.value()[0].bodyB, 4u);
	const auto again = parsePoses(formatPoses(rows.value(), 5), "x", 5);
	ASSERT_TRUE(again) << again.error();
	EXPECT_EQ(again.value()[0].bodyB, 4u);
	for (const char* bodies : {",2,5", ",4,2", ",3,3", ",-1,2", ",1.5,2", ",2", "", ",2,4,1"})
		EXPECT_FALSE(parsePoses(good + bodies, "x", 5)) << bodies;
	EXPECT_FALSE(parsePoses(good + ",0,1", "x", 2));
	EXPECT_FALSE(parsePoses(header() + kGoodRow, "x", 5));
}

TEST(ReplayPoses, HashChangesWithOneBit)
{
	std::vector<PoseRow> rows(2);
	const std::string before = trajectoryHash(rows);
	rows[1].b.position.x = std::nextafter(0.0, 1.0);
	EXPECT_NE(trajectoryHash(rows), before);
}

TEST(ReplayPoses, RelativePoseMapsBodyFrames)
{
	PoseRow row;
	row.a = {{1, 2, 3}, {0, 0, std::sqrt(0.5), std::sqrt(0.5)}};  // a quarter turn about z
	row.b = {{4, 2, 3}, {0, 0, 0, 1}};
	const Vec3 centerA{0.1, 0, 0}, centerB{0, 0.2, 0};
	// B's centre in the world is (4, 2.2, 3), A's (1, 2.1, 3); the difference (3, 0.1, 0) turned back is (0.1, -3, 0).
	const Vec3 p = relativePose(row, centerA, centerB) * Vec3{};
	EXPECT_NEAR(p.x, 0.1, 1e-12);
	EXPECT_NEAR(p.y, -3, 1e-12);
	EXPECT_NEAR(p.z, 0, 1e-12);
}
}  // namespace
