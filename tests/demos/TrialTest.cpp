// SPDX-License-Identifier: GPL-3.0-or-later
// `clod-bench try`: its page, the poses and settings behind its recommendations, and the command from outside.
#include <gtest/gtest.h>

#include <cmath>

#include "cli/Files.h"
#include "clod/distance/SignedGap.h"
#include "demos/models/Models.h"
#include "demos/runner/HierarchyCache.h"
#include "demos/runner/Penetration.h"
#include "demos/runner/Replay.h"
#include "demos/trial/Html.h"
#include "demos/trial/Recommendation.h"
#include "demos/trial/TrialRuns.h"
#include "tests/demos/RunnerCommand.h"
#include "tests/support/Files.h"

namespace clod::test
{
namespace
{
using namespace demo;

const auto kNoProgress = [](double) {};

TEST(TrialPage, TextIsEscapedAndFilesBecomeData)
{
	EXPECT_EQ(escaped("<a href='x'>&\""), "&lt;a href=&#39;x&#39;&gt;&amp;&quot;");
	const TemporaryFolder folder;
	EXPECT_EQ(dataAddress(folder.file("one", "M"), "a/b"), "data:a/b;base64,TQ==");
	EXPECT_EQ(dataAddress(folder.file("two", "Ma"), "a/b"), "data:a/b;base64,TWE=");
	EXPECT_EQ(dataAddress(folder.file("three", "Man"), "a/b"), "data:a/b;base64,TWFu");
	EXPECT_EQ(dataAddress(folder.file("four", "\xff\xfe\xfd"), "a/b"), "data:a/b;base64,//79");
	EXPECT_EQ(dataAddress(folder.file("none"), "a/b"), "");
}

TEST(TrialPage, ATableHasItsRowsAndCells)
{
	EXPECT_EQ(toHtml({"c", {"h", "i"}, {{"1", "2"}, {"3", "4"}}}),
			  "<div class='scroll'><table><caption>c</caption><thead><tr><th scope='col'>h</th><th "
			  "scope='col'>i</th></tr></thead>"
			  "<tbody>\n<tr><th scope='row'>1</th><td>2</td></tr>\n<tr><th scope='row'>3</th><td>4</td></tr>\n"
			  "</tbody></table></div>\n");
}

// x, y of every mark.
std::vector<std::pair<double, double>> marks(const std::string& svg)
{
	std::vector<std::pair<double, double>> found;
	std::size_t at = 0;
	while ((at = svg.find("cx='", at)) != std::string::npos)
	{
		const double x = std::strtod(svg.c_str() + at + 4, nullptr);
		at = svg.find("cy='", at);
		found.emplace_back(x, std::strtod(svg.c_str() + at + 4, nullptr));
	}
	return found;
}

TEST(TrialPage, MarksLieWhereTheirValuesAre)
{
	Plot plot;
	plot.title = "t";
	plot.isXLogarithmic = true;
	plot.series = {
		{"s", "#000000", {{1, 0, "first"}, {10, 5, "<second>"}, {100, 10, "third"}, {std::nan(""), 1, "no"}}, false}};
	const std::string svg = toSvg(plot);
	const auto found = marks(svg);
	ASSERT_EQ(found.size(), 3u);
	EXPECT_NEAR(found[1].first - found[0].first, found[2].first - found[1].first, 0.2);
	EXPECT_GT(found[1].first, found[0].first + 50);
	EXPECT_NEAR(found[0].second - found[1].second, found[1].second - found[2].second, 0.2);
	EXPECT_GT(found[0].second, found[2].second + 50);  // SVG's y points down
	EXPECT_NE(svg.find("<title>&lt;second&gt;</title>"), std::string::npos);
}

// A cost of 5 looks half as large as one of 10, not like nothing.
TEST(TrialPage, LinearAxesBeginAtZero)
{
	Plot plot;
	plot.series = {{"s", "#000000", {{5, 5, "a"}, {10, 10, "b"}, {5, 10, "c"}}, false}};
	const auto found = marks(toSvg(plot));
	ASSERT_EQ(found.size(), 3u);
	const double left = found[0].first - (found[1].first - found[0].first), zeroY = found[0].second + (found[0].second - found[1].second);
	Plot withZero = plot;
	withZero.series[0].points.push_back({0, 0, "zero"});
	const auto all = marks(toSvg(withZero));
	EXPECT_NEAR(all.back().first, left, 0.3);
	EXPECT_NEAR(all.back().second, zeroY, 0.3);
	EXPECT_NEAR(all.front().second, found.front().second, 0.1);
}

TEST(TrialRun, TheWorstMomentIsTheDeepestElseTheFarthestOff)
{
	std::vector<TrialFrame> frames(4);
	frames[0].offSurface = std::nan("");
	frames[1].offSurface = 0.1;
	frames[2].offSurface = 0.3;
	frames[3].offSurface = 0.2;
	EXPECT_EQ(worstFrame(frames), 2u);
	frames[0].deepest = 1e-3;
	frames[1].deepest = 2e-3;
	EXPECT_EQ(worstFrame(frames), 1u);
}

TEST(TrialRecommendation, TheCheapestWithinAnAccuracyAndTheMostAccurateWithinACost)
{
	std::vector<LimitRow> limits(4);
	const double shares[] = {0.05, 0.01, 0.005, 0}, tests[] = {10, 60, 40, 90}, times[] = {1, 6, 4, 9};
	for (int i = 0; i < 4; ++i)
		limits[i].share = shares[i], limits[i].tests = tests[i], limits[i].microseconds = times[i];
	EXPECT_EQ(cheapestWithin(limits, 0.02), &limits[2]) << "finer, and cheaper all the same";
	EXPECT_EQ(cheapestWithin(limits, 0.001), &limits[3]);
	EXPECT_EQ(cheapestWithin(limits, 1), &limits[0]);
	EXPECT_EQ(mostAccurateWithin(limits, 5), &limits[2]);
	EXPECT_EQ(mostAccurateWithin(limits, 0.5), nullptr);
	limits[3].tests = limits[2].tests;
	EXPECT_EQ(cheapestWithin(limits, 0.02), &limits[3]) << "of equals the finest";
}

TEST(TrialRecommendation, SaysWhenItIsNotKept)
{
	Recommendation r;
	r.chosen.share = 0.01;
	r.chosen.tests = r.fresh.tests = 100;
	r.fresh.certified = r.fresh.error = 0.01;
	EXPECT_TRUE(r.keepsAccuracy() && r.keepsCost());
	r.fresh.tests = 131;
	EXPECT_FALSE(r.keepsCost());
	r.fresh.tests = 69;
	EXPECT_FALSE(r.keepsCost());
	r.fresh.certified = 0.0101;
	EXPECT_FALSE(r.keepsAccuracy());
	r.fresh.certified = 0.005;
	r.fresh.broken = 1;
	EXPECT_FALSE(r.keepsAccuracy());
	r.fresh.broken = 0;
	r.fresh.certified = INFINITY;
	EXPECT_FALSE(r.keepsAccuracy());
	r.chosen.share = 0;
	r.fresh.certified = r.fresh.error = 1e-5;  // exact: what rounding comes to
	EXPECT_TRUE(r.keepsAccuracy());
	r.fresh.certified = r.fresh.error = 1e-3;
	EXPECT_FALSE(r.keepsAccuracy());
	r.fresh.error = 0;  // a gap that is right, and known to be so to a thousandth
	EXPECT_TRUE(r.keepsAccuracy());
	r.accuracy = 1e-3 / 2;
	EXPECT_FALSE(r.keepsAccuracy());
}

class TrialPoses : public testing::Test
{
protected:
	static HierarchyPointer build(const char* name, std::size_t triangles)
	{
		const TemporaryFolder folder;
		CacheOptions none;
		none.enabled = false;
		HierarchyCache cache(none, true);
		const std::string path = folder.file("mesh.obj");
		EXPECT_EQ(cli::writeFile(path, toObj(makeModel(name, triangles).value())), "");
		return cache.open(path, {});
	}
};

// Bodies that fell through a floor at once had the cheapest steps of all.
TEST_F(TrialPoses, ARunEndsWithItsLastBody)
{
	Trial trial;
	for (const char* name : {"floor", "sphere"})
	{
		const std::size_t triangles = name == std::string("sphere") ? 320 : 0;
		trial.models.push_back(build(name, triangles));
		trial.surfaces.push_back(makeModel(name, triangles).value());
	}
	const double radius = trial.radius = trial.smallest = double(trial.models[1]->asset().radius);
	trial.scene = demo::trial({{"sphere", ""}}, radius, radius);
	Solids solids;
	for (const ModelMesh& mesh : trial.surfaces) solids.push_back(std::make_shared<SignedDistance>(mesh));
	const Contender ours{"CLOD", "", "", {}, {}};
	const TrialRules rules{48, 12, 1.0 / 240, 600};
	TrialRun run = runContender(trial, ours, solids, rules, [](double) {});
	EXPECT_EQ(run.frames.size(), 4u);
	EXPECT_EQ(run.ending, "");
	trial.scene.inPlace = [](std::size_t, const Vec3&) { return false; };
	run = runContender(trial, ours, solids, rules, [](double) {});
	EXPECT_EQ(run.frames.size(), 1u);
	EXPECT_EQ(run.gone, int(trial.scene.bodies.size()) - 1);
	EXPECT_NE(run.ending.find("all bodies fell through"), std::string::npos) << run.ending;
}

// The gap of the recorded pose, by code that shares nothing with the query: vertices against the other's triangles. Of
// balls of many triangles it is the gap to what their facets differ by.
TEST_F(TrialPoses, TouchAndTheirGapsAreTrue)
{
	const HierarchyPointer ball = build("sphere", 1200);
	const ModelMesh mesh = makeModel("sphere", 1200).value();
	const double radius = double(ball->asset().radius), tolerance = 0.05 * radius;
	const TouchingPoses poses = touchingPoses(*ball, *ball, tolerance, 120, 3, kNoProgress);
	ASSERT_EQ(poses.rows.size(), 120u);
	const SignedDistance solid(mesh);
	std::size_t deep = 0;
	for (std::size_t i = 0; i < poses.rows.size(); ++i)
	{
		double least = INFINITY;
		for (const Vec3& vertex : mesh.vertices)
			least = std::min(least, solid(relativePose(poses.rows[i], {}, {}) * vertex));
		EXPECT_NEAR(poses.gaps[i], least, 0.01 * radius) << i;
		EXPECT_LE(poses.gaps[i], 1.2 * tolerance);
		EXPECT_GE(poses.gaps[i], -0.25 * tolerance);
		deep += poses.gaps[i] < 0;
	}
	EXPECT_GT(deep, 5u);
	EXPECT_LT(deep, 60u);
	// Rows follow each other; where B starts anew time goes by, or it would have come in one step.
	const RowClock clock{1.0 / 240, true};
	for (const double speed : relativeSpeeds(*ball, *ball, poses.rows, clock)) EXPECT_LT(speed, 100);
	const TouchingPoses again = touchingPoses(*ball, *ball, tolerance, 120, 3, kNoProgress),
						other = touchingPoses(*ball, *ball, tolerance, 120, 4, kNoProgress);
	EXPECT_EQ(trajectoryHash(again.rows), trajectoryHash(poses.rows));
	EXPECT_NE(trajectoryHash(other.rows), trajectoryHash(poses.rows));
}

TEST_F(TrialPoses, ALimitIsMeasuredAgainstTheExactGaps)
{
	const HierarchyPointer torus = build("torus", 2000);
	const double tolerance = 0.01 * double(torus->asset().radius);
	TouchingPoses poses = touchingPoses(*torus, *torus, tolerance, 80, 5, kNoProgress);
	const LimitRow exact = measureLimit(*torus, *torus, 0, tolerance, poses),
				   coarse = measureLimit(*torus, *torus, 0.05, tolerance, poses);
	EXPECT_EQ(exact.broken + coarse.broken, 0u);
	EXPECT_LE(coarse.certified, 0.05 + 1e-6);
	EXPECT_LT(exact.error, 3e-6);
	EXPECT_LT(exact.certified, 3e-5);
	EXPECT_LT(coarse.tests, exact.tests);
	poses.gaps[7] += 0.2 * double(torus->asset().radius);  // a wrong truth has to be seen
	EXPECT_EQ(measureLimit(*torus, *torus, 0.05, tolerance, poses).broken, 1u);
}

// Answers with the times that it is told, and remembers what it was asked.
class KnownTimes : public Peer
{
public:
	explicit KnownTimes(std::vector<double> times) : Peer({}), m_times(std::move(times)) {}
	std::vector<PeerAnswer> pass(const PoseSample& sample) override
	{
		asked = sample;
		std::vector<PeerAnswer> answers(m_times.size());
		for (std::size_t i = 0; i < answers.size(); ++i) answers[i].microseconds = m_times[i];
		return answers;
	}
	PoseSample asked;

private:
	std::vector<double> m_times;
};

TEST(TrialLimit, IsTimedOnceAtEveryPoseInMotion)
{
	TouchingPoses poses;
	poses.rows.resize(3);
	for (int i = 0; i < 3; ++i) poses.rows[std::size_t(i)].step = i == 2 ? 1000 : i;
	poses.rows[1].b.position = {1, 0, 0};
	KnownTimes dispatch({7, 1, 3});
	LimitRow limit;
	timeLimit(limit, dispatch, 0.5, poses, {0.25, true});
	EXPECT_EQ(limit.microseconds, 3);
	EXPECT_NEAR(limit.p95, 6.6, 0.41);
	ASSERT_EQ(dispatch.asked.measured(), 3u);
	EXPECT_EQ(dispatch.asked.tolerance, 0.5);
	EXPECT_EQ(dispatch.asked.dt, 0.25);
	EXPECT_EQ(dispatch.asked.rows[1].before.b.position, Vec3{});
	EXPECT_EQ(dispatch.asked.rows[1].seconds, 0.25);
	EXPECT_GT(dispatch.asked.rows[2].seconds, 100) << "elsewhere, not fast";
}

class TryCommand : public RunnerCommand
{
protected:
	static std::string tryWords(const std::string& meshes, const std::string& folder)
	{
		return "try " + meshes + " --quick --no-film --quiet --peers-dir /none -o " + path(folder) + cache();
	}
	static json runOf(const json& report, const std::string& method)
	{
		for (const json& run : report["runs"])
			if (run["method"] == method) return run;
		return {};
	}
};

TEST_F(TryCommand, ReportsOnMeshesOfAnyUnit)
{
	ASSERT_EQ(bench("model torus --triangles 800 --quiet -o " + path("torus.obj")).code, 0);
	ASSERT_EQ(bench("model cup --triangles 1200 --quiet -o " + path("cup.obj")).code, 0);
	const Outcome run = bench(tryWords(path("cup.obj") + " " + path("torus.obj"), "metres"));
	ASSERT_EQ(run.code, 0) << run.err;
	const json report = RunnerCommand::report("metres/report.json");
	const json ours = runOf(report, "CLOD"), hull = runOf(report, "convex hull");
	EXPECT_EQ(ours["bodies_gone"], 0);
	EXPECT_GT(report["seconds"].get<double>(), 0.1);
	// The torus falls into the cup, onto whose hull it otherwise falls: that hull's top is far off the surface.
	EXPECT_LE(ours["points_off_share"]["p95"].get<double>(), 0.005) << "what its limit certifies";
	EXPECT_GT(hull["points_off_share"]["p95"].get<double>(), 0.2);
	EXPECT_LT(ours["deepest"].get<double>(), 0.02 * 0.0215);
	for (const char* kind : {"for_accuracy", "for_cost"})
	{
		EXPECT_TRUE(report[kind]["keeps_accuracy"]) << report[kind];
		EXPECT_TRUE(report[kind]["keeps_cost"]) << report[kind];
		EXPECT_GT(report[kind]["fresh"]["dispatch_us"]["median"].get<double>(), 0.1);
	}
	const std::string page = readText(path("metres/report.html"));
	EXPECT_EQ(page.find("http"), std::string::npos) << "the page must need nothing else";
	EXPECT_EQ(page.find("<script"), std::string::npos);
	EXPECT_EQ(page.find("<title></title>"), std::string::npos) << "every plot says what it shows";
	EXPECT_NE(page.find("setMetric(clod::ContactMetric::"), std::string::npos);
	EXPECT_NE(page.find("poses of cup and torus"), std::string::npos) << "the trade-off is of these two";
	EXPECT_NE(page.find(">one hull<"), std::string::npos) << "what it is beside in the trade-off";
	EXPECT_NE(page.find("V-HACD"), std::string::npos) << "where it is missing, the page says what to do";

	// The same in thousandths, the torus in inches: what differs is rounding, which chaos makes grow.
	ModelMesh cup = makeModel("cup", 1200).value();
	for (Vec3& vertex : cup.vertices) vertex = 1000 * vertex;
	ASSERT_EQ(cli::writeFile(path("cup-mm.obj"), toObj(cup)), "");
	const Outcome mixed = bench(tryWords(path("cup-mm.obj") + " " + path("torus.obj"), "mixed"));
	ASSERT_EQ(mixed.code, 0) << mixed.err;
	EXPECT_EQ(runOf(RunnerCommand::report("mixed/report.json"), "CLOD")["bodies_gone"], 0);
}

// What the builder did to a mesh is told, found in the cache, too.
TEST_F(TryCommand, TellsWhatWasMended)
{
	ModelMesh torus = makeModel("torus", 400).value();
	torus.triangles.pop_back();
	ASSERT_EQ(cli::writeFile(path("torn.obj"), toObj(torus)), "");
	for (const char* folder : {"built", "found"})
	{
		const Outcome run = bench(tryWords(path("torn.obj") + " --repair", folder));
		ASSERT_EQ(run.code, 0) << run.err;
		const std::string page = readText(path(std::string(folder) + "/report.html"));
		EXPECT_NE(page.find("1 hole closed with 1 face"), std::string::npos) << folder;
		EXPECT_NE(page.find("certified errors are to the surface as it is now"), std::string::npos) << folder;
	}
}

TEST_F(TryCommand, NamesTheNextStep)
{
	EXPECT_EQ(bench(tryWords(path("none.obj"), "none")).code, 3);
	const Outcome open = bench(tryWords(file("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "open"));
	EXPECT_EQ(open.code, 3);
	EXPECT_NE(open.err.find("--repair"), std::string::npos) << open.err;
	// What no repair helps is not sent there.
	for (const char* content : {"", "hello"})
	{
		const Outcome hopeless = bench(tryWords(file("hopeless.obj", content), "hopeless"));
		EXPECT_EQ(hopeless.code, 3);
		EXPECT_EQ(hopeless.err.find("--repair"), std::string::npos) << hopeless.err;
		EXPECT_NE(hopeless.err.find(*content ? "assimp" : "export the file again"), std::string::npos) << hopeless.err;
	}
	ModelMesh giant = makeModel("torus", 400).value();
	for (Vec3& vertex : giant.vertices) vertex = 1e11 * vertex;
	ASSERT_EQ(cli::writeFile(path("giant.obj"), toObj(giant)), "");
	const Outcome large = bench(tryWords(path("giant.obj"), "giant"));
	EXPECT_EQ(large.code, 5);
	EXPECT_NE(large.err.find("--scale"), std::string::npos) << large.err;
	ASSERT_EQ(cli::writeFile(path("torus.obj"), toObj(makeModel("torus", 400).value())), "");
	EXPECT_EQ(bench("try " + path("torus.obj") + " --quick --quiet -o /proc/none").code, 1);
	// What is not the mesh's fault is not said to be.
	const Outcome cache =
		bench("try " + path("torus.obj") + " --quick --quiet --cache-dir /proc/none -o " + path("cacheless"));
	EXPECT_EQ(cache.code, 1);
	EXPECT_EQ(cache.err.find("refused"), std::string::npos) << cache.err;
}
}  // namespace
}  // namespace clod::test
