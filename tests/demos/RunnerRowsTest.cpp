// SPDX-License-Identifier: GPL-3.0-or-later
// Sums over the pairs of a step, and regimes of successive rows, on rows made by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include <nlohmann/json.hpp>

#include "demos/runner/Replay.h"
#include "demos/runner/Statistics.h"
#include "demos/runner/WorldRuns.h"
#include "demos/scenes/SceneDefinition.h"
#include "tests/support/Files.h"

namespace
{
using namespace clod::demo;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kTolerance = 0.5;

ReplayRow rowOf(double gap, double bound, double speed = 0)
{
	ReplayRow row;
	row.minDistance = gap;
	row.errorBound = bound;
	row.speed = speed;
	row.contacts = std::isinf(gap) ? 0 : 1;
	return row;
}

TEST(RunnerRows, GrowthIsTheExponentOfAPower)
{
	std::vector<nlohmann::ordered_json> rows;
	for (const double x : {10.0, 30.0, 1000.0}) rows.push_back({{"bodies", x}, {"step_us", 7 * std::pow(x, 1.5)}, {"bytes", nullptr}});
	EXPECT_NEAR(growthExponent(rows, "bodies", "step_us"), 1.5, 1e-12);
	EXPECT_TRUE(std::isnan(growthExponent(rows, "bodies", "bytes")));
	rows.resize(1);
	EXPECT_TRUE(std::isnan(growthExponent(rows, "bodies", "step_us")));
}

TEST(RunnerRows, AWorldIsInItsFileOnceMeasured)
{
	const clod::test::TemporaryFolder folder;
	const std::string path = folder.file("worlds.csv");
	WorldRecord record(path);
	std::string expected = "sweep,bodies,step_us";
	for (const char* title : {"heap", "field"})
	{
		record.begin(title, "bodies");
		for (const int bodies : {10, 30})
		{
			record.add({{"bodies", bodies}, {"step_us", 5 * bodies}});
			expected += "\n\"" + std::string(title) + "\"," + std::to_string(bodies) + "," + std::to_string(5 * bodies);
			std::ifstream file(path);
			EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), expected + "\n");
		}
	}
}

// In the step that time is up in, measured or not.
TEST(RunnerRows, AWorldEndsInTime)
{
	double last = 0;
	SceneDefinition scene;
	scene.info.name = "turning cube";
	scene.info.models.resize(1);
	scene.info.bodies.resize(1);
	scene.info.dt = 0.5;
	scene.gravity = steadyGravity;
	scene.inPlace = [](std::size_t, const clod::Vec3&) { return true; };
	BodyDefinition body;
	body.course = [&last](double time)
	{
		last = time;
		return turnedAboutY({}, time);
	};
	scene.bodies = {body};
	const auto cube = clod::Hierarchy::load(CLOD_FIXTURES "/cube.clod").value();
	WorldRunOptions run;
	run.from = 20;
	run.to = 40;
	const auto whole = measureWorld(scene, {cube}, {"ours", {}, {}}, run);
	EXPECT_EQ(whole["steps"], 20);
	EXPECT_NEAR(last, 0.5 * run.to, 0.6);
	run.mostSeconds = 0;
	const auto ended = measureWorld(scene, {cube}, {"ours", {}, {}}, run);
	EXPECT_EQ(ended["steps"], 1);
	WorldSweep sweep{"cubes", "bodies", {}};
	for (auto row : {whole, whole, ended})
	{
		row["bodies"] = 10 + 10 * sweep.rows.size();
		row["step_us"] = row["began_only"] ? 1 : 10 * row["bodies"].get<int>();
		sweep.rows.push_back(row);
	}
	EXPECT_NEAR(toJson(sweep)["growth"][0]["step_us"], 1, 1e-9);  // of the two that were measured
	EXPECT_NEAR(last, 0.5, 0.6);
}

// Looked at eight times a swing, trembling, and not about zero.
TEST(RunnerRows, ASwingsAmplitudesAreThoseOfItsPeaks)
{
	for (const double rate : {-0.02, 0.0, 0.02})
	{
		std::vector<double> values;
		for (int i = 0; i < 100; ++i)
			values.push_back(0.3 + 0.5 * std::exp(rate * i) * std::cos(0.39 * i) + (i % 2 == 0 ? 1e-5 : -1e-5));
		const std::vector<double> amplitudes = swingAmplitudes(values, 0.01);
		ASSERT_EQ(amplitudes.size(), 12u);
		const double halfSwing = 3.14159265358979 / 0.39;
		for (std::size_t k = 0; k < amplitudes.size(); ++k)
		{
			const double first = std::exp(rate * halfSwing * double(k)), second = std::exp(rate * halfSwing * double(k + 1));
			EXPECT_NEAR(amplitudes[k] / (0.25 * (first + second)), 1, 0.004) << rate << " " << k;
		}
	}
	EXPECT_TRUE(swingAmplitudes({}, 0.01).empty());
	EXPECT_TRUE(swingAmplitudes({1, 1, 1}, 0.01).empty());
}

TEST(WorldRows, KeepTheirColumnsWhateverTheirNamesHold)
{
	const std::vector<nlohmann::ordered_json> rows = {{{"contender", "hulls, \"16\""}, {"bodies", 10}, {"bytes", nullptr}}};
	EXPECT_EQ(formatWorldCsv({{"stacks, flat", "bodies", rows}}),
			  "sweep,contender,bodies,bytes\n\"stacks, flat\",\"hulls, \"\"16\"\"\",10,\n");
}

TEST(RunnerRows, TheSumsBoundHoldsForEveryGapThePairsAllow)
{
	std::mt19937_64 random(7);
	const auto uniform = [&](double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; };
	int apart = 0, loose = 0;
	for (int round = 0; round < 2000; ++round)
	{
		std::vector<ReplayRow> pairs;
		double least = kInfinity;  // of the true gaps
		for (int i = 0; i < 3; ++i)
		{
			const double bound = uniform(0, 0.3), truth = uniform(-0.5, 2);
			const double reported = truth + uniform(-bound, bound);
			pairs.push_back(rowOf(reported <= kTolerance ? reported : kInfinity, bound));
			least = std::min(least, truth);
		}
		const ReplayRow sum = sumOfPairs(pairs, kTolerance);
		if (std::isinf(sum.minDistance))
		{
			++apart;
			EXPECT_GT(least, kTolerance - sum.errorBound - 1e-12);
			continue;
		}
		EXPECT_LE(std::fabs(least - sum.minDistance), sum.errorBound + 1e-12);
		double own = 0;  // the bound of the pair with the least gap alone
		for (const ReplayRow& pair : pairs)
			if (pair.minDistance == sum.minDistance) own = pair.errorBound;
		loose += std::fabs(least - sum.minDistance) > own + 1e-12;
	}
	EXPECT_GT(apart, 10);
	EXPECT_GT(loose, 10) << "taking the least pair's own bound would have passed";
}

TEST(RunnerRows, TheSumTakesTheSpeedOfTouchingPairs)
{
	const std::vector<ReplayRow> pairs = {rowOf(0.1, 0, 0.01), rowOf(kInfinity, 0, 9), rowOf(0.2, 0, 0.03)};
	EXPECT_EQ(sumOfPairs(pairs, kTolerance).speed, 0.03);
	EXPECT_EQ(sumOfPairs(pairs, kTolerance).contacts, 2u);
	EXPECT_EQ(sumOfPairs({pairs[1], pairs[1]}, kTolerance).speed, 9);
	EXPECT_TRUE(std::isinf(sumOfPairs({}, kTolerance).minDistance));
}

TEST(RunnerRows, TheSumAddsCostsAndSpansLevels)
{
	std::vector<ReplayRow> pairs = {rowOf(0.1, 0), rowOf(0.2, 0), rowOf(kInfinity, 0)};
	const std::uint32_t finest[] = {2, 1, 0}, coarsest[] = {3, 5, 9};  // the last has no contact
	for (std::size_t i = 0; i < pairs.size(); ++i)
	{
		pairs[i].queryMicroseconds = 10 * double(i + 1);
		pairs[i].gapMicroseconds = 100 * double(i + 1);
		pairs[i].churn = i + 1;
		pairs[i].stats.finestLevel = finest[i];
		pairs[i].stats.coarsestLevel = coarsest[i];
		pairs[i].stats.hullTests = 7;
		pairs[i].stats.boxTests = 5;
	}
	const ReplayRow sum = sumOfPairs(pairs, kTolerance);
	EXPECT_EQ(sum.queryMicroseconds, 60);
	EXPECT_EQ(sum.gapMicroseconds, 600);
	EXPECT_EQ(sum.churn, 6u);
	EXPECT_EQ(sum.stats.finestLevel, 1u);
	EXPECT_EQ(sum.stats.coarsestLevel, 5u);
	EXPECT_EQ(sum.tests(), 36u);
}

TEST(RunnerRows, RegimesFollowContactAndSpeed)
{
	std::vector<ReplayRow> rows(3, rowOf(kInfinity, 0, 5));
	rows.insert(rows.end(), kImpactRows + 2, rowOf(0.1, 0, 5));
	rows.push_back(rowOf(0.1, 0, 0.5 * kRestSpeed));
	rows.push_back(rowOf(kTolerance * 1.1, 0, 0));
	rows.push_back(rowOf(0.1, 0, 0));
	const std::vector<Regime> regimes = regimesOf(rows, kTolerance);
	ASSERT_EQ(regimes.size(), rows.size());
	EXPECT_EQ(regimes[2], Regime::apart);
	EXPECT_EQ(regimes[3], Regime::impact);
	EXPECT_EQ(regimes[std::size_t(2 + kImpactRows)], Regime::impact);
	EXPECT_EQ(regimes[std::size_t(3 + kImpactRows)], Regime::sliding);
	EXPECT_EQ(regimes[std::size_t(5 + kImpactRows)], Regime::resting);
	EXPECT_EQ(regimes[std::size_t(6 + kImpactRows)], Regime::apart);
	EXPECT_EQ(regimes[std::size_t(7 + kImpactRows)], Regime::impact);
}

TEST(RunnerRows, TheCameraGoesEvenlyAndThenStays)
{
	CameraPath path{{{0, 0, 1}, 0.5, 720, 0.01}, {{4, 0, 3}, 0.7, 720, 0.03}, 8};
	EXPECT_EQ(path.at(0).eye, (clod::Vec3{0, 0, 1}));
	EXPECT_EQ(path.at(2).eye, (clod::Vec3{1, 0, 1.5}));
	EXPECT_DOUBLE_EQ(path.at(4).fieldOfView, 0.6);
	EXPECT_DOUBLE_EQ(path.at(4).nearDistance, 0.02);
	EXPECT_EQ(path.at(99).eye, (clod::Vec3{4, 0, 3}));
	path.steps = 0;
	EXPECT_EQ(path.at(99).eye, (clod::Vec3{0, 0, 1}));
}
}  // namespace
