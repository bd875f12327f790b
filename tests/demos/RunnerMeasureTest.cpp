// SPDX-License-Identifier: GPL-3.0-or-later
// The commands that measure: what they write, whom they leave out, and that every row is accounted for.
#include <algorithm>
#include <cstdio>
#include <map>
#include <sstream>

#include "tests/demos/RunnerCommand.h"

namespace
{
using namespace clod::test;

std::vector<std::string> fieldsOf(const std::string& line)
{
	std::istringstream fields(line);
	std::vector<std::string> result;
	for (std::string field; std::getline(fields, field, ',');) result.push_back(field);
	return result;
}

// The column of a csv as numbers, by the row's first two fields.
std::map<std::string, double> csvColumn(const std::string& csv, const std::string& name)
{
	std::istringstream lines(csv);
	std::string header, line;
	std::getline(lines, header);
	std::istringstream names(header);
	int wanted = 0;
	for (std::string field; std::getline(names, field, ',') && field != name;) ++wanted;
	std::map<std::string, double> values;
	while (std::getline(lines, line))
	{
		std::istringstream fields(line);
		std::string key, field;
		for (int column = 0; column <= wanted && std::getline(fields, field, ','); ++column)
			if (column < 2) key += (column ? "," : "") + field;
		values[key] = std::atof(field.c_str());
	}
	return values;
}

// The finest level of a pair's answers with a contact, in the mean over the rows of those steps.
double finestLevel(const std::string& csv, const std::string& bodies, int from, int to)
{
	std::istringstream lines(csv);
	std::string line;
	std::getline(lines, line);
	const std::vector<std::string> names = fieldsOf(line);
	const auto column = [&](const char* name)
	{ return std::size_t(std::find(names.begin(), names.end(), name) - names.begin()); };
	double sum = 0;
	int count = 0;
	while (std::getline(lines, line))
	{
		const std::vector<std::string> fields = fieldsOf(line);
		const auto number = [&](const char* name) { return std::atoi(fields.at(column(name)).c_str()); };
		if (fields.at(column("body_a")) + "," + fields.at(column("body_b")) != bodies) continue;
		if (number("step") < from || number("step") > to || number("contacts") == 0) continue;
		sum += number("finest_level");
		++count;
	}
	EXPECT_GT(count, 5) << bodies << " from step " << from;
	return sum / count;
}

// Twenty steps of 1/240 s a frame are twelve frames a second.
TEST_F(RunnerCommand, FilmsLastAsLongAsWhatTheyShow)
{
	const Outcome run = bench(kSmallScene + " --frame-every 20 --frames " + path("film") + cache());
	ASSERT_EQ(run.code, 0) << run.err;
	if (!fs::exists(path("film/film.mp4"))) GTEST_SKIP() << "without ffmpeg there is no film";
	const Outcome probe = runProgram("ffprobe", "-v error -count_frames -select_streams v:0 -show_entries "
												"stream=r_frame_rate,nb_read_frames -of csv=p=0 " +
													path("film/film.mp4"));
	EXPECT_EQ(probe.out, "12/1,2\n") << probe.err;
}

// From the near cup to the far one, along with the run and at its poses.
TEST_F(RunnerCommand, AMovingCameraAsksForFinerContactsWhereItComesNear)
{
	const std::string scene = " --resolution 0.03 --quiet" + cache(), start = " --camera 0.10,0.16,0.22,0.02,0.06,0,35";
	const std::string moving = start + " --camera-to 0.05,0.1,-0.52,0.04,0.065,-0.6,35", view = " --view 16";
	const std::string poses = path("mixed.csv"), csv = path("levels.csv");
	const Outcome run =
		bench("run mixed-needs --steps 60 --poses " + poses + " --csv " + path("run.csv") + view + moving + scene);
	ASSERT_EQ(run.code, 0) << run.err;
	const auto levels = [&](const std::string& camera)
	{
		const Outcome replay = bench("replay mixed-needs " + poses + " --csv " + csv + view + camera + scene);
		EXPECT_EQ(replay.code, 0) << replay.err;
		return readText(csv);
	};
	const std::string near = "0,1", far = "2,3";
	const std::string followed = levels(moving), stood = levels(start);
	const double before = finestLevel(followed, far, 1, 24), after = finestLevel(followed, far, 45, 60);
	std::printf("far cup: finest level %.2f, then %.2f; near cup %.2f, then %.2f\n", before, after,
				finestLevel(followed, near, 1, 24), finestLevel(followed, near, 45, 60));
	EXPECT_LT(after, before - 0.5);
	EXPECT_LT(after, finestLevel(stood, far, 45, 60) - 0.5);  // at the same poses, the camera where it was
}

TEST_F(RunnerCommand, TradeoffMeasuresOursAndWhatBulletHas)
{
	needRecording();
	const std::string inputs = path("cup.obj ") + path("spoon.obj ") + path("poses.csv");
	const Outcome outcome = bench("tradeoff " + inputs + cache() +
								  " --rows contact --tolerance 2mm --stride 6 --repeat 2 --quiet --peers-dir " +
								  path("no-peers") + " -o " + path("tradeoff"));
	ASSERT_EQ(outcome.code, 0) << outcome.err;
	const std::string csv = readText(path("tradeoff/tradeoff.csv"));
	const auto gap = csvColumn(csv, "gap_error_p95"), covered = csvColumn(csv, "covered_mean"),
			   time = csvColumn(csv, "us_median");
	ASSERT_TRUE(gap.count("clod,exact") && gap.count("clod-dispatch,exact") && gap.count("gimpact,full") &&
				gap.count("bvh-gimpact,full") && gap.count("clod,size 3.5 %"))
		<< csv;
	EXPECT_LT(gap.at("clod,exact"), 1e-7);  // the reference is this query
	EXPECT_EQ(covered.at("clod,exact"), 1);
	EXPECT_GT(gap.at("clod,size 7 %"), gap.at("clod,exact"));
	EXPECT_LT(gap.at("clod,max-error 0.1 %"), 0.001 * 0.072);  // the smaller radius, rounded up
	// Dispatches are timed once more with the bodies at rest, and as new pairs that no cache knows.
	const auto rest = csvColumn(csv, "us_rest_median"), cold = csvColumn(csv, "us_cold_median"),
			   bytes = csvColumn(csv, "pair_bytes"), rows = csvColumn(csv, "rows");
	for (const auto& [method, microseconds] : time)
	{
		const bool isQuery = method.rfind("clod,", 0) == 0 || method.rfind("clod-gap,", 0) == 0 ||
							 method.rfind("decimated-exact,", 0) == 0;
		EXPECT_GT(microseconds, 0) << method;
		EXPECT_EQ(rest.at(method) > 0, !isQuery) << method;
		EXPECT_EQ(cold.at(method) > 0, !isQuery) << method;
		EXPECT_EQ(bytes.at(method) > 500, !isQuery) << method;  // a manifold at least
		EXPECT_GT(rows.at(method), 0) << method;
	}
	EXPECT_NE(outcome.out.find(" rows only, "), std::string::npos) << outcome.out;
	for (const json& row : report("tradeoff/tradeoff.json")["tradeoff"]["pareto"])
		EXPECT_EQ(row["factor_at_rest"].is_number() && row["factor_at_rest"].get<double>() > 0, row["factor"] != 0)
			<< row;
	const json left = report("tradeoff/tradeoff.json")["tradeoff"]["left_out"];
	EXPECT_NE(left.dump().find("scripts/peers"), std::string::npos) << left;
	EXPECT_NE(readText(path("tradeoff/pareto.csv")).find("gimpact,full"), std::string::npos);
}

// Once a family, under the ladder's name where the ladder has it.
TEST_F(RunnerCommand, TradeoffMeasuresTheSelectionGiven)
{
	needRecording();
	const std::string words = "tradeoff " + path("cup.obj ") + path("spoon.obj ") + path("poses.csv") + cache() +
							  " --rows contact --tolerance 2mm --most-rows 1 --repeat 1 --quiet --methods "
							  "clod,clod-gap,clod-dispatch --decimations 1 -o " +
							  path("own");
	const auto rows = [&](const std::string& selection)
	{
		const Outcome outcome = bench(words + selection);
		EXPECT_EQ(outcome.code, 0) << outcome.err;
		return readText(path("own/tradeoff.csv"));
	};
	const auto count = [](const std::string& csv, const std::string& label)
	{
		int found = 0;
		for (std::size_t at = csv.find(label); at != std::string::npos; at = csv.find(label, at + 1)) ++found;
		return found;
	};
	const std::string plain = rows("");
	const auto lines = [&](const std::string& csv) { return count(csv, "\n"); };
	for (const char* known : {" --s0 3.5%", " --max-error 0.5%", " --combine relaxed"})
		EXPECT_EQ(lines(rows(known)), lines(plain)) << known;
	const std::pair<const char*, const char*> others[] = {
		{" --size 5 --max-error 3%", ",size 5 % + max-error 3 %,"},
		{" --exact --budget-tests 50", ",exact + at most 50 tests,"},
		{" --velocity 1", ",velocity 1,"},
		{" --size 5 --view 3 --camera 0,0.2,0.2,0,0,0,40 --combine relaxed", ",size 5 % or view 3 px,"}};
	for (const auto& [selection, label] : others)
	{
		const std::string csv = rows(selection);
		EXPECT_EQ(lines(csv), lines(plain) + 3) << selection;
		EXPECT_EQ(count(csv, label), 3) << selection << csv;
	}
	// The settings reach all three: few tests are a coarse answer, no pixels an exact one.
	const auto contacts = csvColumn(rows(" --exact --budget-tests 0"), "contacts_median"),
			   sharp = csvColumn(rows(" --view 1e-6 --camera 0,0.2,0.2,0,0,0,40"), "contacts_median");
	for (const std::string family : {"clod", "clod-gap", "clod-dispatch"})
	{
		EXPECT_LT(contacts.at(family + ",exact + at most 0 tests"), contacts.at(family + ",exact")) << family;
		EXPECT_EQ(sharp.at(family + ",view 1e-06 px"), sharp.at(family + ",exact")) << family;
	}
}

TEST_F(RunnerCommand, ThePeersDispatchIsOfTheSelection)
{
	needRecording();
	const auto points = [&](const std::string& selection)
	{
		const Outcome outcome = bench(replayWords() + cache() + " --tolerance 2mm --quiet --peer gimpact --json " +
									  path("peer.json") + selection);
		EXPECT_EQ(outcome.code, 0) << outcome.err;
		const json rows = report("peer.json")["peer"]["all_rows"];
		const auto median = [&](const char* key) { return rows[key]["median"].get<double>(); };
		EXPECT_DOUBLE_EQ(rows["ratio_of_medians"], median("clod_dispatch_us") / median("gimpact_dispatch_us"));
		EXPECT_DOUBLE_EQ(rows["ratio_of_medians_at_rest"],
						 median("clod_dispatch_at_rest_us") / median("gimpact_dispatch_at_rest_us"));
		EXPECT_NE(outcome.out.find("bodies moving as recorded, and the same poses at rest"), std::string::npos);
		return rows["clod_points"]["mean"].get<double>();
	};
	const std::string camera = " --camera 0,0.2,0.2,0,0,0,40";
	const double exact = points(" --exact"), coarsest = points(" --exact --budget-tests 0");
	EXPECT_LT(coarsest, exact);
	EXPECT_EQ(points(" --view 1e-6" + camera), exact);
	EXPECT_EQ(points(" --view 1e6" + camera), points(" --size 1e6"));
	EXPECT_EQ(points(" --view 1e-6 --size 1e6 --combine relaxed" + camera), points(" --size 1e6"));
	EXPECT_LT(points(" --velocity 1e6 --velocity-floor 0"), exact);  // the bodies move
}

// The first of the rows that are not moving or do not touch do not make a sample empty.
TEST_F(RunnerCommand, ASampleOfOneRowIsOneThatTouches)
{
	needRecording();
	const Outcome outcome =
		bench("tradeoff " + path("cup.obj ") + path("spoon.obj ") + path("poses.csv") + cache() +
			  " --rows contact --most-rows 1 --repeat 1 --quiet --methods clod --decimations 1 -o " + path("one"));
	ASSERT_EQ(outcome.code, 0) << outcome.err;
	EXPECT_EQ(report("one/tradeoff.json")["tradeoff"]["rows"], 1);
}

TEST_F(RunnerCommand, TradeoffLeavesABrokenPeerOutAndSaysSo)
{
	needRecording();
	fs::create_directories(path("peers"));
	fs::permissions(file("peers/clod-coal", "#!/bin/sh\nprintf short > \"$4\"\n"), fs::perms::owner_all);
	const std::string inputs = path("cup.obj ") + path("spoon.obj ") + path("poses.csv");
	const Outcome outcome = bench(
		"tradeoff " + inputs + cache() +
		" --rows contact --tolerance 2mm --stride 20 --repeat 1 --quiet --methods clod,coal-distance --peers-dir " +
		path("peers") + " -o " + path("broken"));
	ASSERT_EQ(outcome.code, 0) << outcome.err;
	EXPECT_NE(outcome.out.find("left out: coal-distance full: clod-coal answered too little"), std::string::npos)
		<< outcome.out;
	EXPECT_EQ(readText(path("broken/tradeoff.csv")).find("coal-distance"), std::string::npos);
}

TEST_F(RunnerCommand, LevelsArePlottedWhereGnuplotIs)
{
	ASSERT_EQ(bench("model bowl --triangles 800 --quiet -o " + path("bowl.obj")).code, 0);
	EXPECT_EQ(bench("levels " + path("bowl.obj") + cache()).code, 2);
	const Outcome plot = bench("levels " + path("bowl.obj") + " --plot " + path("plot.png") + " --quiet" + cache());
	const bool hasGnuplot = std::system("command -v gnuplot >/dev/null") == 0;
	if (hasGnuplot)
	{
		EXPECT_EQ(plot.err, "");  // not even of the builder, which ran
	}
	EXPECT_EQ(plot.code, hasGnuplot ? 0 : 1) << plot.err;
	EXPECT_EQ(fs::exists(path("plot.png")), hasGnuplot);
	EXPECT_EQ(plot.err.find("gnuplot is missing") == std::string::npos, hasGnuplot) << plot.err;
	EXPECT_EQ(bench("levels " + path("bowl.obj") + " --errors " + path("heat.png") + " --quiet" + cache()).code, 0);
	EXPECT_TRUE(fs::exists(path("heat.png")));
}

TEST_F(RunnerCommand, FigureFourHasARowAStepAndEveryRowARegime)
{
	const Outcome paper = bench("paper --only figure4 --resolution 0.03 --steps 40 --quiet -o " + path("figures") +
								cache() + " --json " + path("figures.json"));
	ASSERT_EQ(paper.code, 0) << paper.err;
	std::istringstream lines(readText(path("figures/figure4.csv")));
	std::string line;
	std::getline(lines, line);
	EXPECT_EQ(line.rfind("step,time,regime,ours_exact_us,ours_exact_front,ours_exact_churn", 0), 0u) << line;
	int rows = 0;
	while (std::getline(lines, line)) ++rows;
	EXPECT_EQ(rows, 40);
	if (std::system("command -v gnuplot >/dev/null") == 0)
	{
		EXPECT_GT(fs::file_size(path("figures/figure4.png")), 150000u) << "all curves are drawn";
	}
	const json curves = report("figures.json")["figure4"]["curves"];
	ASSERT_EQ(curves.size(), 8u);
	for (const json& curve : curves)
	{
		int sum = 0;
		for (const json& regime : curve["regimes"]) sum += regime["rows"].get<int>();
		EXPECT_EQ(sum, 40) << curve["mode"] << curve["selection"];
	}
}

TEST_F(RunnerCommand, CostOverContactAreaHasItsPartsAndGrowth)
{
	const Outcome paper = bench("paper --only area --resolution 0.02 --quiet -o " + path("area") + cache() +
								" --json " + path("area.json"));
	ASSERT_EQ(paper.code, 0) << paper.err;
	const json area = report("area.json")["area"];
	const auto exact = csvColumn(readText(path("area/area.csv")), "area");  // keys: step and area
	EXPECT_EQ(exact.size(), 240u);
	double largest = 0;
	for (const auto& [row, contacts] : exact) largest = std::max(largest, contacts);
	EXPECT_EQ(area["largest_area"], largest);
	ASSERT_EQ(area["curves"].size(), 4u);
	for (const json& curve : area["curves"])
		for (const char* figure : {"query_us", "tests", "contacts"})
		{
			ASSERT_EQ(curve[figure].size(), 6u);
			EXPECT_DOUBLE_EQ(curve["growth"][figure], curve[figure][5].get<double>() / curve[figure][0].get<double>());
		}
	// By its own measure the area grows from within the first sixth to within the last.
	const json contacts = area["curves"][0]["contacts"];
	for (int part = 0; part < 6; ++part)
	{
		EXPECT_GT(contacts[part], largest * part / 6);
		EXPECT_LE(contacts[part], largest * (part + 1) / 6);
	}
	EXPECT_NE(readText(path("area/area.txt")).find("s0 = 3.5 %"), std::string::npos);
	EXPECT_EQ(bench("paper --only area --steps 5 --resolution 0.02 --quiet -o " + path("area") + cache()).code, 3);
}

TEST_F(RunnerCommand, IdlePairsAreMeasuredBesideHullsInEveryState)
{
	needRecording();
	const std::string inputs = path("cup.obj ") + path("spoon.obj ") + path("poses.csv");
	const Outcome idle = bench("idle " + inputs + cache() +
							   " --tolerance 2mm --poses 3 --dispatches 20 --quiet --json " + path("idle.json"));
	ASSERT_EQ(idle.code, 0) << idle.err;
	const json rows = report("idle.json")["rows"];
	ASSERT_EQ(rows.size(), 12u);  // three states; three metrics of ours and the hulls
	for (const json& row : rows)
	{
		const bool touches = row["state"] == "touching, unchanged";
		EXPECT_EQ(row["points"].get<double>() > 0, touches) << row;
		EXPECT_GT(row["dispatch_us"]["median"].get<double>(), 0) << row;
		EXPECT_EQ(row["dispatch_us"]["count"], 3) << "a median a pose" << row;
		if (row["who"] == "two hulls of 32 vertices")
		{
			EXPECT_EQ(row["ratio_to_hulls"], 1) << row;
		}
	}
	// Poses that nobody recorded: of B tumbling over A.
	const Outcome tumbling = bench("idle " + path("cup.obj ") + path("spoon.obj") + cache() +
								   " --poses 2 --dispatches 5 --quiet --json " + path("tumbling.json"));
	EXPECT_EQ(tumbling.code, 0) << tumbling.err;
	EXPECT_NE(report("tumbling.json")["subject"].get<std::string>().find("tumbling"), std::string::npos);
	EXPECT_GT(report("tumbling.json")["rows"].size(), 0u);
	EXPECT_EQ(bench("idle spoon-cub" + cache()).code, 2);
}
TEST_F(RunnerCommand, BudgetsAreRunAtTheSamePosesAndLargerOnesLeaveSmallerErrors)
{
	const std::string words = "budget spoon-cup --resolution 0.03 --steps 40 --size 3.5 --quiet" + cache();
	ASSERT_EQ(bench(words + " --budgets 0,1000000 -o " + path("budget")).code, 0);
	const json runs = report("budget/budget.json")["scenes"][0]["runs"];
	ASSERT_EQ(runs.size(), 3u);  // nothing, more than enough, no budget
	for (const json& run : runs) ASSERT_GT(run["steps"].get<int>(), 0) << run;
	EXPECT_GT(runs[0]["excess"]["max"].get<double>(), 1);
	EXPECT_EQ(runs[1]["excess"]["max"], 0);
	EXPECT_GT(runs[0]["error_percent"]["median"].get<double>(), runs[1]["error_percent"]["median"].get<double>());
	// Enough is as good as no budget: the same contacts at the same poses.
	EXPECT_EQ(runs[1]["steps"], runs[2]["steps"]);
	EXPECT_EQ(runs[1]["error_percent"], runs[2]["error_percent"]);
	EXPECT_EQ(runs[0]["share_over"], 1);
	EXPECT_EQ(runs[1]["share_over"], 0);
	// Counted, too.
	ASSERT_EQ(bench(words + " --in-tests --budgets 0,200,1000000 -o " + path("counted")).code, 0);
	const json counted = report("counted/budget.json")["scenes"][0]["runs"];
	ASSERT_EQ(counted.size(), 4u);
	EXPECT_LE(counted[1]["tests"]["median"].get<double>(), 200);
	EXPECT_LE(counted[1]["error_percent"]["median"].get<double>(), counted[0]["error_percent"]["median"].get<double>());
	EXPECT_EQ(counted[2]["error_percent"], counted[3]["error_percent"]);
	// The same answers, and besides what the coarsest ones take found first.
	const auto tests = [&](std::size_t run) { return counted[run]["tests"]["median"].get<double>(); };
	EXPECT_GE(tests(2), tests(3));
	EXPECT_LE(tests(2), tests(3) + tests(0));
	// Without any given, twelve from what coarsest answers take to twice what all do, where they are dearest.
	ASSERT_EQ(bench(words + " --in-tests -o " + path("chosen")).code, 0);
	const json chosen = report("chosen/budget.json")["scenes"][0]["runs"];
	ASSERT_EQ(chosen.size(), 13u);
	EXPECT_EQ(chosen[0]["budget"], std::floor(std::max(1.0, tests(0))));
	EXPECT_NEAR(chosen[11]["budget"].get<double>(), 2 * counted[3]["tests"]["max"].get<double>(), 1);
	EXPECT_EQ(chosen[11]["error_percent"], chosen[12]["error_percent"]);
	// Where nothing touches there is nothing to plot, which is told.
	const Outcome apart =
		bench("budget spoon-cup --resolution 0.03 --steps 5 --quiet --budgets 1 -o " + path("apart") + cache());
	EXPECT_NE(apart.out.find("(no -spoon-cup.png: nothing touched)"), std::string::npos) << apart.out;
	EXPECT_FALSE(std::filesystem::exists(path("apart/budget-spoon-cup.png")));
	EXPECT_EQ(bench("budget spoon-cub -o " + path("x") + cache()).code, 2);
	EXPECT_EQ(bench("budget spoon-cup --budgets 5,-1 -o " + path("x") + cache()).code, 2);
	EXPECT_EQ(bench("budget spoon-cup --budget-us 5 -o " + path("x") + cache()).code, 2);
}

TEST_F(RunnerCommand, ScalingMeasuresTheSameRowsAtEverySize)
{
	const Outcome scaling =
		bench("scaling --only queries --resolutions 0.06,0.03 --steps 40 --repeat 1 --quiet -o " + path("scaling") + cache());
	ASSERT_EQ(scaling.code, 0) << scaling.err;
	const json selections = report("scaling/scaling.json")["selections"];
	ASSERT_EQ(selections.size(), 3u);
	for (const json& selection : selections)
	{
		const json& sizes = selection["sizes"];
		ASSERT_EQ(sizes.size(), 2u);
		EXPECT_LT(sizes[0]["triangles_a"], sizes[1]["triangles_a"]);
		EXPECT_EQ(sizes[0]["rows"], sizes[1]["rows"]);
		EXPECT_EQ(sizes[0]["growth"], 1);
		EXPECT_EQ(sizes[0]["alike_bytes"], sizes[0]["loaded_bytes"]);
		for (const json& size : sizes)
		{
			EXPECT_LE(size["loaded_bytes"], size["bytes"]) << size;
			EXPECT_LE(size["alike_bytes"], size["bytes"]) << size;
			EXPECT_TRUE(size["alike_bytes"] == size["bytes"] || selection["selection"] != "exact") << size;
			const bool isAll = size["loaded_bytes"] == size["bytes"];
			EXPECT_TRUE(isAll || selection["selection"] != "exact") << size;
		}
		EXPECT_DOUBLE_EQ(sizes[1]["growth"],
						 sizes[1]["query_us"]["median"].get<double>() / sizes[0]["query_us"]["median"].get<double>());
	}
	EXPECT_GT(selections[0]["sizes"][1]["contacts"], selections[2]["sizes"][1]["contacts"]);  // exact, size 3.5 %
	EXPECT_EQ(selections[0]["sizes"][1]["coarsest_level"], 0);
	EXPECT_LT(selections[2]["sizes"][1]["loaded_bytes"], selections[2]["sizes"][1]["bytes"]);
	EXPECT_LT(selections[2]["sizes"][1]["finest_level"], selections[2]["sizes"][1]["coarsest_level"]);
	EXPECT_EQ(bench("scaling mixed-needs -o " + path("x") + cache()).code, 2);
	EXPECT_EQ(bench("scaling --resolutions 0,1 -o " + path("x") + cache()).code, 2);
}

TEST_F(RunnerCommand, ScalingMeasuresConvexBodiesOverALandscape)
{
	const Outcome scaling =
		bench("scaling --only convex --resolutions 0.08 --steps 8 --quiet -o " + path("convex") + cache());
	ASSERT_EQ(scaling.code, 0) << scaling.err;
	const json sweeps = report("convex/scaling.json")["worlds"];
	ASSERT_EQ(sweeps.size(), 4u);  // box, ball, capsule, hull
	for (const json& sweep : sweeps)
	{
		ASSERT_EQ(sweep["rows"].size(), 30u);  // of five sizes and two speeds, Bullet's mesh and two settings of ours
		for (const json& row : sweep["rows"])
		{
			EXPECT_TRUE(row["in_place"]) << row;
			EXPECT_TRUE(row["points"] > 0 || row["contender"].get<std::string>().rfind("bt", 0) == 0) << row;
			EXPECT_EQ(row["steps"], 4) << row;
		}
		EXPECT_NEAR(sweep["rows"][29]["covered"].get<double>() / sweep["rows"][0]["covered"].get<double>(), 225, 1e-9);
	}
	EXPECT_TRUE(std::filesystem::exists(path("convex/scaling-convex.csv")));
}

TEST_F(RunnerCommand, ScalingMeasuresWorldsOfMoreBodies)
{
	const Outcome scaling = bench("scaling --only bodies,worlds --bodies 3,1 --resolutions 0.03 --steps 12 --peers-dir " +
								  path("none") + " --quiet -o " + path("worlds") + cache());
	ASSERT_EQ(scaling.code, 0) << scaling.err;
	const json scaled = report("worlds/scaling.json");
	ASSERT_EQ(scaled["worlds"].size(), 4u);
	EXPECT_EQ(scaled["left_out"].size(), 14u);  // both decompositions, of each world: there are no tools
	for (const json& sweep : scaled["worlds"])
		for (const json& row : sweep["rows"])
		{
			const bool isOurs = !row["finest_level"].is_null();
			EXPECT_EQ(isOurs, row["contender"] != "GImpact") << row;
			EXPECT_EQ(row["steps"], 6) << row;
			EXPECT_GT(row["step_us"], row["dispatch_us"]) << row;
			EXPECT_GT(row["bytes"], 1000) << row;
		}
	const json& field = scaled["worlds"][2];
	EXPECT_EQ(field["title"], "sparse field");
	const auto rowOf = [&](const char* contender, int bodies)
	{
		for (const json& row : field["rows"])
			if (row["contender"] == contender && row["bodies"] == bodies && row["threads"] == 1) return row;
		return json();
	};
	for (const char* ours : {"exact", "0.5 % (default)", "size 3.5 %"})
	{
		EXPECT_EQ(rowOf(ours, 1)["pairs"], 1) << ours;
		EXPECT_EQ(rowOf(ours, 3)["pairs"], 3) << ours;
		EXPECT_GE(rowOf(ours, 3)["points"], 3 * 3) << ours;
		EXPECT_GT(rowOf(ours, 3)["triangles"], rowOf(ours, 1)["triangles"]) << ours;
	}
	EXPECT_EQ(rowOf("exact", 3)["coarsest_level"], 0);
}
}  // namespace
