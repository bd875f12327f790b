// SPDX-License-Identifier: GPL-3.0-or-later
// What clod-bench reports, against what is known beforehand: scripted poses whose gaps, speeds, levels and changes of
// the contact list are known, read back through csv, json and text; and times against a clock outside the program.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "demos/models/Models.h"
#include "demos/runner/InputSurface.h"
#include "demos/runner/Replay.h"
#include "demos/runner/Statistics.h"
#include "tests/demos/RunnerCommand.h"
#include "tests/demos/BuiltBody.h"
#include "tests/query/TriangleGap.h"

namespace
{
using namespace clod;
using namespace clod::test;
using demo::PoseRow;

constexpr double kDt = 1.0 / 240;

double sum(const std::vector<double>& values)
{
	return std::accumulate(values.begin(), values.end(), 0.0);
}

// A spread of a report against the csv column that it is of. Times have three decimals there.
void expectSpread(const json& spread, const std::vector<double>& values, const char* name, double slack = 1e-12)
{
	EXPECT_EQ(spread["count"], values.size()) << name;
	for (const auto& [figure, p] : {std::pair("min", 0.0), {"q1", 0.25}, {"median", 0.5}, {"p95", 0.95}, {"max", 1.0}})
		EXPECT_NEAR(spread[figure].get<double>(), demo::quantile(values, p), slack) << name << " " << figure;
	EXPECT_NEAR(spread["mean"].get<double>(), sum(values) / double(values.size()), slack) << name;
}

struct Recording
{
	std::string csv, out;
	json report;
	double seconds = 0;  // from before the program began until after it ended
};

class Scripted : public RunnerCommand
{
protected:
	static Recording record(const std::string& words, int code = 0)
	{
		const auto start = std::chrono::steady_clock::now();
		const Outcome outcome =
			bench(words + " --quiet --csv " + path("rows.csv") + " --json " + path("report.json") + cache());
		const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
		EXPECT_EQ(outcome.code, code) << outcome.err;
		return {readText(path("rows.csv")), outcome.out, report("report.json"), seconds};
	}
	static std::string fileOf(const Body& body)
	{
		return s_folder->fileOf(body.name + ".clod", body.hierarchy->bytes());
	}
	static Recording replayed(const Body& a, const Body& b, const std::vector<PoseRow>& poses, const std::string& words)
	{
		return record("replay " + fileOf(a) + " " + fileOf(b) + " " + file("script.csv", demo::formatPoses(poses)) +
					  words);
	}
};

// What is said to have been spent was spent within the program's life, and was no unmeasurable part of it.
void expectWithin(double microseconds, const Recording& run, const char* what)
{
	EXPECT_LT(1e-6 * microseconds, run.seconds) << what;
	EXPECT_GT(1e-6 * microseconds, run.seconds / 500) << what;
}

// B's box at a distance along x from A's, turned about x: faces stay parallel.
PoseRow boxes(std::int64_t step, double gap, double turn = 0)
{
	PoseRow row;
	row.step = step;
	row.b = {{0.02 + gap, 0, 0}, {std::sin(turn / 2), 0, 0, std::cos(turn / 2)}};
	return row;
}

TEST_F(Scripted, GapsDepthsAndSpeedsOfBoxesAreThoseOfTheScript)
{
	const Body& box = builtBody("box", 12);
	const double radius = box.hierarchy->asset().radius;
	const double gaps[] = {0.003, 0.003, 0.0001, 0.0001, -0.001, -0.0011, 0.004, 0.004};
	std::vector<PoseRow> poses;
	for (int i = 0; i < 8; ++i) poses.push_back(boxes(i, gaps[i], i == 7 ? 0.1 : 0));
	const Recording run = replayed(box, box, poses, " --exact --distance");
	const auto gap = column(run.csv, "min_distance"), bound = column(run.csv, "error_bound"),
			   speed = column(run.csv, "speed_radii_per_s");
	ASSERT_EQ(gap.size(), 8u);
	for (std::size_t i = 0; i < 8; ++i)
	{
		EXPECT_NEAR(gap[i], gaps[i], 2e-5 * radius) << i;
		EXPECT_LE(std::fabs(gap[i] - gaps[i]), bound[i] + 1e-8) << i;
		const double moved = i == 0 ? 0 : i == 7 ? 2 * std::sin(0.05) * radius : std::fabs(gaps[i] - gaps[i - 1]);
		EXPECT_NEAR(speed[i], moved / (kDt * radius), 1e-4 * (1 + speed[i])) << i;
	}
	std::vector<std::string> motions;
	std::istringstream lines(run.csv);
	for (std::string line; std::getline(lines, line);)
		for (const char* motion : {",moving,", ",between,", ",rest,"})
			if (line.find(motion) != std::string::npos) motions.push_back(motion);
	const std::vector<std::string> expected = {",rest,",   ",rest,",   ",moving,", ",rest,",
											   ",moving,", ",moving,", ",moving,", ",moving,"};
	EXPECT_EQ(motions, expected);
	const json summary = run.report["summary"];
	expectSpread(summary["all_rows"]["min_distance"], gap, "min_distance");
	expectSpread(summary["all_rows"]["error_bound"], bound, "error_bound");
	EXPECT_EQ(summary["contact_rows"]["rows"], 4);         // 2 to 5, within 1 % of the radius
	EXPECT_EQ(summary["moving_contact_rows"]["rows"], 3);  // without 3
}

// Two tori, B passing A's flank: levels and changes are counted here from the contact lists themselves.
TEST_F(Scripted, LevelsAndChurnAreThoseOfTheContactLists)
{
	const Body& torus = builtBody("torus", 300);
	const Hierarchy& h = *torus.hierarchy;
	std::vector<PoseRow> poses;
	for (int i = 0; i < 12; ++i)
	{
		poses.emplace_back();
		poses.back().step = i;
		// Rows 4 and 5 are one pose, 8 is far away.
		poses.back().b.position = {0.0005 * (i == 5 ? 4 : i), i == 8 ? 0.1 : 0.0121, 0.0003 * (i == 5 ? 4 : i)};
	}
	const Recording run = replayed(torus, torus, poses, " --size 4 --tolerance 5%");
	const auto finest = column(run.csv, "finest_level"), coarsest = column(run.csv, "coarsest_level"),
			   contacts = column(run.csv, "contacts"), churn = column(run.csv, "churn");
	ASSERT_EQ(churn.size(), 12u);
	demo::ReplayOptions asked;
	asked.metric = ContactMetric::deviationShare(0.04);
	asked.tolerance = {0.05, true, ""};
	asked.contactsOnly = true;
	std::set<std::pair<std::uint32_t, std::uint32_t>> before;
	int mixed = 0, changed = 0;
	for (std::size_t i = 0; i < poses.size(); ++i)
	{
		PairCache fresh;
		ContactResult result;
		clod::contacts(h, h, demo::relativePose(poses[i], demo::meshFromBody(h), demo::meshFromBody(h)),
					   demo::settingsOf(asked, h, h, poses[i], {}), fresh, result);
		std::set<std::uint32_t> levels;
		std::set<std::pair<std::uint32_t, std::uint32_t>> now, both;
		for (const Contact& c : result.contacts)
		{
			levels.insert({h.node(c.nodeA).level, h.node(c.nodeB).level});
			now.insert({c.nodeA, c.nodeB});
		}
		std::set_intersection(now.begin(), now.end(), before.begin(), before.end(), std::inserter(both, both.end()));
		EXPECT_EQ(contacts[i], now.size()) << i;
		EXPECT_EQ(churn[i], now.size() + before.size() - 2 * both.size()) << i;
		if (!levels.empty())
		{
			EXPECT_EQ(finest[i], *levels.begin()) << i;
			EXPECT_EQ(coarsest[i], *levels.rbegin()) << i;
		}
		mixed += levels.size() > 1;
		changed += churn[i] > 0;
		before = now;
	}
	EXPECT_GT(mixed, 3);
	EXPECT_GT(changed, 3);
	EXPECT_GT(contacts[4], 0);
	EXPECT_EQ(churn[5], 0);
	EXPECT_EQ(churn[8], contacts[7]);
	EXPECT_EQ(churn[9], contacts[9]);
}

TEST_F(Scripted, TimesOfQueriesFitInTheProgramsLife)
{
	const Body& torus = builtBody("torus", 300);
	std::vector<PoseRow> poses(300);
	for (std::size_t i = 0; i < poses.size(); ++i)
	{
		poses[i].step = std::int64_t(i);
		poses[i].b.position = {1e-5 * double(i), 0.0121, 0};
	}
	const Recording run = replayed(torus, torus, poses, " --exact --fresh --tolerance 5% --gap-error 0");
	const auto query = column(run.csv, "query_us"), gap = column(run.csv, "gap_us");
	expectWithin(sum(query), run, "queries");
	expectWithin(sum(query) + sum(gap), run, "queries and gaps");
	const json figures = run.report["summary"]["all_rows"];
	expectSpread(figures["query_us"], query, "query_us", 6e-4);
	expectSpread(figures["gap_us"], gap, "gap_us", 6e-4);
	// And the line for people.
	std::istringstream line(run.out.substr(run.out.find("all_rows") + 8));
	double count = 0, median = 0, p95 = 0;
	line >> count >> median >> p95;
	EXPECT_EQ(count, 300);
	EXPECT_NEAR(median, demo::quantile(query, 0.5), 0.051);
	EXPECT_NEAR(p95, demo::quantile(query, 0.95), 0.051);
}

// The deepest vertex of either mesh in the other by winding numbers and every triangle.
double deepestVertex(const demo::ModelMesh& mesh, const demo::ModelMesh& other, const Transform& meshFromOther)
{
	TriangleSoup soup;
	for (const auto& t : mesh.triangles)
		soup.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
	double deepest = 0;
	for (const Vec3& vertex : other.vertices)
	{
		const Vec3 p = meshFromOther * vertex;
		if (std::fabs(windingNumber(soup, p)) < 0.5) continue;
		double nearest = std::numeric_limits<double>::infinity();
		for (const auto& t : soup) nearest = std::min(nearest, pointTriangleDistance(p, t));
		deepest = std::max(deepest, nearest);
	}
	return deepest;
}

PoseRow poseIn(const std::string& csv, std::size_t row)
{
	const auto at = [&](const char* name) { return column(csv, name)[row]; };
	return {std::int64_t(at("step")),
			{{at("ax"), at("ay"), at("az")}, {at("aqx"), at("aqy"), at("aqz"), at("aqw")}},
			{{at("bx"), at("by"), at("bz")}, {at("bqx"), at("bqy"), at("bqz"), at("bqw")}}};
}

// One step of 0.04 s takes a box that hangs over the floor by 2 mm and its corners' room into it.
TEST_F(Scripted, ABoxDroppedIntoTheFloorIsAsDeepAsItFell)
{
	const double edge = 0.02, fallen = 9.81 * 0.04 * 0.04, room = 0.002 + (std::sqrt(3.0) - 1) * edge / 2;
	const std::string words = "run drop --exact --steps 1 --dt 0.04 --verify-penetration --model ";
	const Recording run = record(words + fileOf(builtBody("box", 12)), 4);
	const json depth = run.report["interpenetration"];
	EXPECT_NEAR(depth["deepest"].get<double>(), fallen - room, 1e-7);
	EXPECT_EQ(depth["step"], 1);
	EXPECT_DOUBLE_EQ(depth["limit"], 0.01 * 0.00125);  // of the wall that the scene names
	EXPECT_EQ(depth["within_limit"], false);
	EXPECT_DOUBLE_EQ(run.report["constants"]["thinner_wall"]["value"], 0.00125);
	EXPECT_TRUE(run.report["constants"].contains("start_room"));  // the scene's own come with those of every scene
	EXPECT_NE(run.out.find("deepest interpenetration of the full meshes 6.37549"), std::string::npos) << run.out;
	EXPECT_NE(run.out.find("mm at step 1 (limit 0.012500 mm)"), std::string::npos) << run.out;
}

// A ball of 300 triangles falls freely for some steps and rolls over its facets. One run, all that it says of itself.
TEST_F(Scripted, ARunsSpeedsLevelsTimesAndDepthAreThoseOfItsPoses)
{
	constexpr std::size_t steps = 300, last = 24;
	const Body& ball = builtBody("sphere", 300);
	const Recording run =
		record("run drop --steps 300 --dt 0.004166666666666667 --size 28 --verify-penetration --model " + fileOf(ball));
	const auto of = [&](const char* name) { return column(run.csv, name); };
	const auto linear = of("speed_m_per_s"), angular = of("turning_rad_per_s"), radii = of("speed_radii_per_s");
	const auto dispatch = of("dispatch_us"), step = of("step_us"), query = of("query_us"), gap = of("gap_us");
	const auto points = of("points"), contacts = of("contacts"), finest = of("finest_level"),
			   coarsest = of("coarsest_level"), bound = of("error_bound");
	ASSERT_EQ(linear.size(), steps);
	const double radius = ball.hierarchy->asset().radius;
	std::size_t falling = 0, turning = 0, mixed = 0;
	for (; points[falling] == 0; ++falling)
	{
		const double fallen = 9.81 * kDt * double(falling + 1);
		EXPECT_NEAR(linear[falling], fallen, 1e-4 * fallen) << falling;
		EXPECT_NEAR(radii[falling], falling == 0 ? 0 : fallen / radius, 1e-3 * fallen / radius) << falling;
	}
	EXPECT_GE(falling, 4u);
	for (std::size_t i = falling; i < steps; ++i)
	{
		// Pushing bodies apart turns them, too, without a velocity.
		const auto velocity = demo::velocityBetween(poseIn(run.csv, i - 1).b, poseIn(run.csv, i).b, {}, kDt);
		EXPECT_NEAR(length(velocity.angular), angular[i], 0.1 + 0.15 * angular[i]) << i;
		turning += angular[i] > 1;
		EXPECT_LE(finest[i], coarsest[i]) << i;
		mixed += contacts[i] > 0 && finest[i] < coarsest[i];
	}
	EXPECT_GT(turning, 20u);
	EXPECT_GT(mixed, 20u);

	const json summary = run.report["summary"];
	const auto fastestAtEnd = [&](const std::vector<double>& speeds)
	{ return *std::max_element(speeds.end() - last, speeds.end()); };
	EXPECT_NEAR(summary["end"]["largest_speed_m_per_s"].get<double>(), fastestAtEnd(linear), 1e-5);
	EXPECT_NEAR(summary["end"]["largest_speed_radii_per_s"].get<double>(), fastestAtEnd(radii), 1e-4);
	for (std::size_t i = 0; i < steps; ++i) EXPECT_LT(dispatch[i], step[i]) << i;
	EXPECT_GT(sum(dispatch), sum(step) / 100);
	expectWithin(sum(step) + sum(query) + sum(gap), run, "steps and queries");
	expectSpread(summary["dispatch_us"], dispatch, "dispatch_us", 6e-4);
	expectSpread(summary["step_us"], step, "step_us", 6e-4);
	expectSpread(summary["queries"]["all_rows"]["query_us"], query, "query_us", 6e-4);
	char line[200];
	std::snprintf(line, sizeof line, "median over 300 steps: query %.1f us, dispatch %.1f us, whole step %.1f us",
				  summary["queries"]["all_rows"]["query_us"]["median"].get<double>(),
				  summary["dispatch_us"]["median"].get<double>(), summary["step_us"]["median"].get<double>());
	EXPECT_NE(run.out.find(line), std::string::npos) << run.out << line;

	const json depth = run.report["interpenetration"];
	const double deepest = depth["deepest"], limit = depth["limit"];
	EXPECT_GT(deepest, 1e-5);
	const demo::ModelMesh floor = demo::makeModel("floor").value(), mesh = demo::inputSurface(*ball.hierarchy);
	const Transform aFromB = demo::relativePose(poseIn(run.csv, depth["step"].get<std::size_t>() - 1), {}, {});
	EXPECT_NEAR(deepest, std::max(deepestVertex(floor, mesh, aFromB), deepestVertex(mesh, floor, inverse(aFromB))),
				1e-9);
	double largestBound = 0;
	for (const double b : bound) largestBound = std::max(largestBound, std::isinf(b) ? 0 : b);
	EXPECT_DOUBLE_EQ(depth["certified_bound_in_use"], largestBound);
	EXPECT_DOUBLE_EQ(limit, 0.01 * 0.00125 + largestBound);
	EXPECT_DOUBLE_EQ(depth["share_of_thinner_wall"], deepest / 0.00125);
	EXPECT_EQ(depth["within_limit"], true);
	std::snprintf(line, sizeof line, "deepest interpenetration of the full meshes %.6f mm at step %d (limit %.6f mm)",
				  1000 * deepest, depth["step"].get<int>(), 1000 * limit);
	EXPECT_NE(run.out.find(line), std::string::npos) << run.out << line;
}
}  // namespace
