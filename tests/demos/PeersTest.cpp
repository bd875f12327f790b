// SPDX-License-Identifier: GPL-3.0-or-later
// What the trade-off says of an answer, shown on answers with planted faults; fronts; files of pieces.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

#include "demos/peers/Accuracy.h"
#include "demos/peers/Pareto.h"
#include "demos/peers/PeerMesh.h"
#include "demos/peers/Preparation.h"
#include "demos/peers/Tradeoff.h"
#include "tests/support/Files.h"

namespace
{
using namespace clod;
using namespace clod::demo;
using clod::test::TemporaryFolder;

// Ten contacts along x, 1 apart, normals up, distances 0 to 0.9; asked for up to 1.
ExactRow exactRow()
{
	ExactRow row;
	for (int i = 0; i < 10; ++i) row.contacts.push_back({{double(i), 0, 0}, {0, 1, 0}, 0.1 * i, 0});
	return row;
}

AccuracyRules rules()
{
	AccuracyRules result;
	result.tolerance = 1;
	result.near = 0.2;
	result.place = 0.05;
	result.rounding = 1e-9;
	return result;
}

PeerAnswer answerOf(const ExactRow& exact)
{
	PeerAnswer answer;
	answer.gap = exact.gap;
	answer.contacts = exact.contacts;
	return answer;
}

TEST(Accuracy, ExactAnswerHasNoError)
{
	const RowAccuracy row = compare(exactRow(), answerOf(exactRow()), rules());
	EXPECT_FALSE(row.missed);
	EXPECT_EQ(row.gapError, 0);
	EXPECT_EQ(row.normalError, 0);
	EXPECT_EQ(row.covered, 1);
	EXPECT_EQ(row.founded, 1);
	EXPECT_EQ(row.contacts, 10u);
}

TEST(Accuracy, MissingContactsLowerCoverageOnly)
{
	PeerAnswer answer = answerOf(exactRow());
	answer.contacts.erase(answer.contacts.begin() + 1, answer.contacts.begin() + 4);  // three of the six within 0.5
	const RowAccuracy row = compare(exactRow(), answer, rules());
	EXPECT_DOUBLE_EQ(row.covered, 0.5);
	EXPECT_EQ(row.founded, 1);
}

TEST(Accuracy, TurnedNormalsDoNotCover)
{
	for (const auto& [degrees, covered] : {std::pair(19.0, 1.0), std::pair(21.0, 0.0)})
	{
		PeerAnswer answer = answerOf(exactRow());
		const double angle = degrees * 3.14159265358979323846 / 180;
		for (PeerContact& contact : answer.contacts) contact.normal = {std::sin(angle), std::cos(angle), 0};
		const RowAccuracy row = compare(exactRow(), answer, rules());
		EXPECT_NEAR(row.normalError, degrees, 1e-9);
		EXPECT_EQ(row.covered, covered);
	}
}

// In a corner two directions are right.
TEST(Accuracy, TheNearestOfTheNormalsAtAPlaceCounts)
{
	ExactRow corner;
	corner.contacts = {{{0, 0, 0}, {0, 1, 0}, 0, 0}, {{0, 0, 0}, {1, 0, 0}, 0, 0}};
	for (const PeerContact& contact : corner.contacts)
	{
		PeerAnswer answer;
		answer.contacts = {contact};
		EXPECT_EQ(compare(corner, answer, rules()).normalError, 0);
	}
}

TEST(Accuracy, ContactsWithoutNormalSayNothingOfDirections)
{
	PeerAnswer answer = answerOf(exactRow());
	for (PeerContact& contact : answer.contacts) contact.normal = {};
	const RowAccuracy row = compare(exactRow(), answer, rules());
	EXPECT_EQ(row.normalError, 90);
	EXPECT_EQ(row.covered, 0);
}

TEST(Accuracy, InventedContactsAreUnfounded)
{
	PeerAnswer answer = answerOf(exactRow());
	answer.contacts.push_back({{5, 3, 0}, {0, 1, 0}, 0.1, 0});  // nothing is near
	EXPECT_DOUBLE_EQ(compare(exactRow(), answer, rules()).founded, 10.0 / 11);
	answer = answerOf(exactRow());
	answer.contacts[9].distance = 0.5;  // the truth there is 0.9
	EXPECT_DOUBLE_EQ(compare(exactRow(), answer, rules()).founded, 0.9);
	answer.contacts[9].bound = 0.41;  // and that was promised
	EXPECT_EQ(compare(exactRow(), answer, rules()).founded, 1);
}

TEST(Accuracy, SilenceIsAMissAndClaimsTheTolerance)
{
	const RowAccuracy row = compare(exactRow(), PeerAnswer(), rules());
	EXPECT_TRUE(row.missed);
	EXPECT_EQ(row.gapError, 1);
	EXPECT_EQ(row.covered, 0);
	EXPECT_TRUE(std::isnan(row.normalError));
	EXPECT_EQ(summarize({row, compare(exactRow(), answerOf(exactRow()), rules())}).missedShare, 0.5);
}

TradeoffPoint point(const std::string& family, double time, double median, double p95, Timed timed = Timed::query)
{
	TradeoffPoint result;
	result.info.family = family;
	result.info.timed = timed;
	result.median = time;
	result.accuracy.gapMedian = median;
	result.accuracy.gapP95 = p95;
	return result;
}

TEST(Tradeoff, WhatNoRowHasIsNamedNotANumber)
{
	// Exact contacts, but none within half the tolerance.
	ExactRow far = exactRow();
	far.contacts.erase(far.contacts.begin(), far.contacts.begin() + 6);
	const RowAccuracy row = compare(far, answerOf(far), rules());
	EXPECT_TRUE(std::isnan(row.covered));
	Tradeoff tradeoff;
	tradeoff.radius = 1;
	tradeoff.points.emplace_back();
	tradeoff.points[0].info.family = "clod";
	tradeoff.points[0].info.setting = "exact";
	tradeoff.points[0].accuracy = summarize({row});
	const std::string text = printable(tradeoff, {}), csv = formatPoints(tradeoff);
	EXPECT_EQ(text.find("nan"), std::string::npos) << text;
	EXPECT_NE(text.find(" - "), std::string::npos) << text;
	// Empty: mean and 5 % quantile of what is covered, then what is founded.
	EXPECT_NE(csv.find(",,,1,4,0,"), std::string::npos) << csv;
}

TEST(Pareto, FrontDropsWhatIsSlowerAndNoMoreExact)
{
	const auto front =
		paretoFront({point("x", 3, 1, 1), point("x", 1, 5, 5), point("x", 2, 6, 6), point("x", 4, 1, 1)});
	ASSERT_EQ(front.size(), 2u);
	EXPECT_EQ(front[0].median, 1);
	EXPECT_EQ(front[1].median, 3);
}

TEST(Pareto, AnswerIsTheFastestOfTheSameKindAtNoLargerErrors)
{
	const std::vector<TradeoffPoint> points = {point("clod", 4, 1, 1), point("clod", 2, 2, 3), point("clod", 1, 2, 4),
											   point("clod-dispatch", 0.1, 0, 0, Timed::dispatch),
											   point("peer", 10, 2, 3)};
	const auto rows = comparePareto(points, 0);
	ASSERT_EQ(rows.size(), 1u);
	ASSERT_TRUE(rows[0].ours.has_value());
	EXPECT_EQ(rows[0].ours->median, 2);
	EXPECT_EQ(rows[0].factor, 5);
	// Nothing of ours is so exact, unless the difference is rounding.
	const std::vector<TradeoffPoint> exact = {point("clod", 4, 1e-9, 1e-9), point("peer", 10, 0, 0)};
	EXPECT_FALSE(comparePareto(exact, 0)[0].ours.has_value());
	EXPECT_TRUE(comparePareto(exact, 1e-8)[0].ours.has_value());
}

TEST(Pareto, ARowKeepsItsLeastTime)
{
	TradeoffPoint result;
	setTimes(result, {{4, 5, 9}, {3, 7, 8}}, {{2, 1, 1}, {1, 4, 3}}, {{6, 8, 8}, {9, 7, 9}});
	EXPECT_EQ(result.median, 5);
	EXPECT_EQ(result.passLow, 5);
	EXPECT_EQ(result.passHigh, 7);
	EXPECT_EQ(result.restMedian, 1);
	EXPECT_EQ(result.coldMedian, 7);
	setTimes(result, {{4}}, {}, {});
	EXPECT_TRUE(std::isnan(result.restMedian));
	EXPECT_TRUE(std::isnan(result.coldMedian));
}

Result<PieceFile> piecesOf(const std::string& text)
{
	const TemporaryFolder folder;
	return readPieces(folder.file("pieces.obj", text));
}

TEST(PieceFile, ReadsPiecesAndNotes)
{
	const auto file = piecesOf(
		"# seconds 2.5\no p0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no p1\nv 5 0 0\nv 6 0 0\nv 5 1 "
		"0\nv 5 0 1\nf 4 5 6\n");
	ASSERT_TRUE(file) << file.error();
	ASSERT_EQ(file.value().pieces.size(), 2u);
	EXPECT_EQ(file.value().pieces[1].vertices.size(), 4u);
	EXPECT_EQ(file.value().pieces[1].triangles[0][2], 2u);
	EXPECT_EQ(file.value().note("seconds", -1), 2.5);
	EXPECT_EQ(file.value().note("hours", -1), -1);
}

TEST(PieceFile, RefusesWhatIsNoPiece)
{
	const std::pair<const char*, const char*> cases[] = {{"v 0 0\n", "line 1"},
														 {"v 0 0 nan\n", "line 1"},
														 {"v 0 0 0\nf 1 1 2\n", "line 2"},
														 {"v 0 0 0 1\n", "line 1"},
														 {"v 0 0 0\no a\no b\n", "empty"},
														 {"g x\n", "line 1"},
														 {"", "no piece"},
														 {"v 0 0 0\no a\nv 1 1 1\nf 1 2 2\n", "line 4"}};
	for (const auto& [text, part] : cases)
	{
		const auto file = piecesOf(text);
		ASSERT_FALSE(file) << text;
		EXPECT_NE(file.error().find(part), std::string::npos) << file.error();
	}
}

TEST(Decimation, DeviationOfAScaledBoxIsItsCornersDistance)
{
	const auto box = makeModel("box", 12);
	ASSERT_TRUE(box) << box.error();
	ModelMesh larger = box.value();
	for (Vec3& v : larger.vertices) v = 1.5 * v;
	double corner = 0;
	for (const Vec3& v : box.value().vertices) corner = std::max(corner, length(v));
	EXPECT_NEAR(sampledDeviation(box.value(), larger), 0.5 * corner, 1e-12);
	EXPECT_LT(sampledDeviation(box.value(), box.value()), 1e-15);
}

TEST(Decimation, PairsTakeTheCoarsestPartnerThatDeviatesNoMore)
{
	const auto ladder = [](const std::vector<double>& deviations)
	{
		std::vector<DecimatedMesh> result;
		for (std::size_t i = 0; i < deviations.size(); ++i)
			result.push_back({nullptr, 1.0 / double(i + 1), deviations[i]});
		return result;
	};
	const auto pairs = matchedPairs(ladder({0, 1, 10}), ladder({0, 2, 3}));
	const std::vector<std::array<std::size_t, 2>> expected = {{0, 0}, {1, 0}, {1, 1}, {1, 2}, {2, 2}};
	EXPECT_EQ(pairs, expected);
}
}  // namespace
