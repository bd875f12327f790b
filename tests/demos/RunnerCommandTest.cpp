// SPDX-License-Identifier: GPL-3.0-or-later
// What every command of clod-bench keeps to: exit codes, columns, the cache, and the short scene twice in both
// precisions.
#include <algorithm>
#include <set>
#include <sstream>

#include "demos/scenes/Poses.h"
#include "tests/demos/RunnerCommand.h"

namespace
{
using namespace clod::test;

constexpr const char* kColumns =
	"step,query_us,front,hull_tests,contacts,min_distance,error_bound,finest_level,coarsest_level";

// The rows of a csv without query_us (column 1) and gap_us (column 9).
std::string withoutTimes(const std::string& csv)
{
	std::istringstream lines(csv);
	std::string result;
	for (std::string line; std::getline(lines, line);)
	{
		std::istringstream fields(line);
		std::string field;
		for (int column = 0; std::getline(fields, field, ','); ++column)
			if (column != 1 && column != 9) result += field + ",";
		result += "\n";
	}
	return result;
}

// The first nine columns without the time: what must not depend on caches, but for front and tests.
std::string answers(const std::string& csv)
{
	std::istringstream lines(csv);
	std::string result;
	for (std::string line; std::getline(lines, line);)
	{
		std::istringstream fields(line);
		std::string field;
		for (int column = 0; column < 9 && std::getline(fields, field, ','); ++column)
			if (column == 0 || column >= 4) result += field + ",";
		result += "\n";
	}
	return result;
}

TEST_F(RunnerCommand, EveryCommandHelpsWithAnExample)
{
	std::istringstream help(bench("--help").out);
	std::string line;
	while (std::getline(help, line) && line != "Subcommands:") continue;
	int commands = 0;
	for (; std::getline(help, line) && !line.empty(); ++commands)
	{
		const std::string name = line.substr(2, line.find(' ', 2) - 2);
		EXPECT_NE(bench(name + " --help").out.find("Example: clod-bench " + name), std::string::npos) << name;
	}
	EXPECT_GT(commands, 10);
}

TEST_F(RunnerCommand, ModelWritesTheSameBytesTwice)
{
	ASSERT_EQ(bench("model torus --triangles 800 -o " + path("one.obj")).code, 0);
	ASSERT_EQ(bench("model torus --triangles 800 -o " + path("two.obj")).code, 0);
	EXPECT_FALSE(readText(path("one.obj")).empty());
	EXPECT_EQ(readText(path("one.obj")), readText(path("two.obj")));
	std::filesystem::create_symlink("/dev/full", path("full.obj"));
	const Outcome full = bench("model torus --triangles 800 -o " + path("full.obj"));
	EXPECT_EQ(full.code, 1);
	EXPECT_NE(full.err.find("cannot write " + path("full.obj")), std::string::npos) << full.err;
}

TEST_F(RunnerCommand, ListNamesTheScenes)
{
	const Outcome list = bench("list");
	EXPECT_EQ(list.code, 0);
	EXPECT_EQ(list.out.rfind("spoon-cup", 0), 0u);
	for (const char* scene :
		 {"torus-spiral", "numbers-bowl", "spoons-nested", "bolt-nut", "mixed-needs", "contact-area", "drop"})
		EXPECT_NE(list.out.find(scene), std::string::npos) << scene;
}

TEST_F(RunnerCommand, WhatCannotBeWrittenIsToldBeforeAnythingIsBuilt)
{
	const std::string aside = path("nodir/x");
	for (const std::string& words :
		 {"run spoon-cup --csv " + aside, "run spoon-cup --json " + aside, "run spoon-cup --poses " + aside,
		  "run spoon-cup --csv " + path(""), "tradeoff spoon-cup -o " + path("results") + " --json " + aside,
		  "budget -o " + path("results") + " --json " + aside, "scaling -o " + path("results") + " --json " + aside,
		  "extremes -o " + path("results") + " --json " + aside, "paper -o " + path("results") + " --json " + aside,
		  "idle spoon-cup --json " + aside, "replay spoon-cup p.csv --csv " + aside,
		  "levels x.obj -o " + aside + ".png"})
	{
		const Outcome outcome = bench(words + cache());
		EXPECT_EQ(outcome.code, 1) << words << "\n" << outcome.err;
		EXPECT_EQ(outcome.err.rfind("clod-bench: cannot write ", 0), 0u) << words << "\n" << outcome.err;
	}
}

TEST_F(RunnerCommand, NoResultIsWrittenOverAnotherOrOverWhatIsRead)
{
	const std::string poses = path("p.csv"), scene = path("s.json"), link = path("link.json");
	std::ofstream(poses) << "poses";
	std::ofstream(scene) << "scene";
	std::filesystem::create_symlink(scene, link);
	for (const std::string& words :
		 {std::string("run spoon-cup --steps 1 --csv no.csv --json ./no.csv"), "run " + scene + " --json " + link,
		  "replay spoon-cup " + poses + " --csv " + poses})
	{
		const Outcome outcome = bench(words + cache());
		EXPECT_EQ(outcome.code, 2) << words << "\n" << outcome.err;
	}
	EXPECT_EQ(readText(poses), "poses");
	EXPECT_EQ(readText(scene), "scene");
}

TEST_F(RunnerCommand, UsageErrorsExitWith2AndTheNearestMatch)
{
	const std::pair<const char*, const char*> cases[] = {
		{"model cupp -o x.obj", "did you mean cup"},
		{"model cup", "--output"},
		{"model cup -o ''", "--output: the name to write to is empty"},
		{"tradeoff spoon-cup -o ''", "--output: the name to write to is empty"},
		{"run spoon-cub", "did you mean spoon-cup"},
		{"run spoon-cup --exat", "did you mean --exact"},
		{"rum spoon-cup", "did you mean run"},
		{"run spoon-cup --steps 0", "--steps"},
		{"run spoon-cup --dt nan", "--dt"},
		{"run spoon-cup --model x.obj", "--model is for the scene drop"},
		{"run spoon-cup --velocity -1", "'-1' is not a finite number >= 0"},
		{"run spoon-cup --velocity nan", "'nan' is not a finite number >= 0"},
		{"run spoon-cup --velocity-floor 1mm", "--velocity"},
		{"run spoon-cup --view 2", "--camera"},
		{"run spoon-cup --view inf --camera 0,0,1,0,0,0,40", "'inf' is not a finite number >= 0"},
		{"run spoon-cup --view 2 --camera 0,0,1,0,0,1,40", "eye is its target"},
		{"run spoon-cup --camera-to 0,0,1,0,0,0,40", "--camera"},
		{"run spoon-cup --exact --velocity 1", "excludes"},
		{"run spoon-cup --impacts", "--parts"},
		{"run spoon-cup --combine relax", "did you mean relaxed"},
		{"run spoon-cup --budget-tests -5", "--budget-tests"},
		{"run spoon-cup --budget-us nan", "--budget-us"},
		{"run spoon-cup --size 3mm", "per cent"},
		{"run spoon-cup --max-error -1", "negative"},
		{"run spoon-cup --exact --size 3", "excludes"},
		{"run spoon-cup --frames x --camera 1,2,3", "fovy"},
		{"replay a.obj b.obj", "POSES"},
		{"replay a.obj b.obj p.csv --repeat 0", "--repeat"},
		{"replay a.obj b.obj p.csv --peer coal", "gimpact"},
		{"replay a.obj b.obj p.csv --peer gimpact --fresh", "--paper and --fresh"},
		{"replay a.obj b.obj p.csv --peer gimpact --paper", "--paper and --fresh"},
		{"replay a.obj b.obj p.csv --budget-us 5 --repeat 2", "by the clock"},
		{"replay a.obj b.obj p.csv --camera 0,0,1,0,0,0,40", "--camera has no effect without --view"},
		{"run spoon-cup --camera 0,0,1,0,0,0,40", "--camera has no effect without --view"},
		{"run spoon-cup --paper --budget-tests 100", "have neither"},
		{"run spoon-cup --fresh --budget-us 100", "have neither"},
		{"run spoon-cup --shapes hul", "did you mean hull"},
		{"run spoon-cup --shapes hull --budget-tests 5", "only ours keeps to a budget"},
		{"tradeoff spoon-cup -o x --paper", "--paper and --fresh are for replay"},
		{"tradeoff spoon-cup -o x --fresh", "--paper and --fresh are for replay"},
		{"tradeoff spoon-cup -o x --budget-us 5", "by the clock"},
		{"tradeoff spoon-cup -o x --camera 0,0,1,0,0,0,40", "--camera has no effect without --view"},
		{"tradeoff spoon-cup -o x --size 3.5 --methods gimpact", "names none of them"},
		{"tradeoff spoon-cup -o x --exact --size 3", "excludes"},
		{"tradeoff spoon-cub -o x", "did you mean spoon-cup"},
		{"tradeoff a.obj b.obj --pair a,b -o x", "POSES.csv"},
		{"run spoon-cup --csv - --json -", "stdout"},
		{"run spoon-cup --seed -1", "whole number"},
		{"levels x.clod -o x.jpg", ".png"},
		{"scaling -o x --only worlds,bodys", "did you mean bodies"},
		{"model cup -o x.stl", ".obj"},
		{"try x.obj --wrap 0 -o x", "positive"},
		{"tradeoff spoon-cup", "-o"},
		{"tradeoff spoon-cup -o x --methods gimpakt", "did you mean gimpact"},
		{"tradeoff mixed-needs -o x --pair near-cup,near-spon", "did you mean near-spoon"},
		{"tradeoff mixed-needs -o x --pair near-cup,near-cup", "two different bodies"},
		{"tradeoff mixed-needs -o x --pair near-cup", "--pair"},
		{"tradeoff spoon-cup -o x --stride 0", "--stride"},
		{"tradeoff spoon-cup -o x --rows resting", "moving"}};
	for (const auto& [words, part] : cases)
	{
		const Outcome outcome = bench(words);
		EXPECT_EQ(outcome.code, 2) << words << "\n" << outcome.err;
		EXPECT_NE(outcome.err.find(part), std::string::npos) << words << "\n" << outcome.err;
	}
	const Outcome mesh = bench("run " + file("a.obj", ""));
	EXPECT_EQ(mesh.code, 2) << mesh.err;
	EXPECT_NE(mesh.err.find("clod-bench try"), std::string::npos) << mesh.err;
}

TEST_F(RunnerCommand, BadInputExitsWith3)
{
	needRecording();
	file("bad.csv", std::string(clod::demo::kPosesHeader) + "\n1,2\n");
	file("bad.clod", "not a hierarchy");
	file("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
	const std::string cup = path("cup.obj") + " ", spoon = path("spoon.obj") + " ";
	const Outcome poses = bench("replay --quiet " + cup + spoon + path("bad.csv") + cache());
	EXPECT_EQ(poses.code, 3);
	EXPECT_NE(poses.err.find("line 2: 2 fields"), std::string::npos) << poses.err;
	EXPECT_EQ(bench("replay --quiet " + path("bad.clod ") + spoon + path("poses.csv") + cache()).code, 3);
	EXPECT_EQ(bench("replay --quiet " + path("bad.obj ") + spoon + path("poses.csv") + cache()).code, 3);
	EXPECT_EQ(bench("replay --quiet " + path("none.obj ") + spoon + path("poses.csv") + cache()).code, 3);
}

TEST_F(RunnerCommand, ReplayAnswersTheSameWarmAndFreshAndTwice)
{
	needRecording();
	for (const char* selection : {" --exact", " --size 3.5", ""})
	{
		const std::string words = replayWords() + cache() + " --quiet" + selection;
		ASSERT_EQ(bench(words + " --repeat 2 --csv " + path("warm.csv")).code, 0);
		ASSERT_EQ(bench(words + " --csv " + path("again.csv")).code, 0);
		ASSERT_EQ(bench(words + " --fresh --csv " + path("fresh.csv")).code, 0);
		const std::string warm = readText(path("warm.csv"));
		EXPECT_EQ(warm.rfind(kColumns, 0), 0u) << warm.substr(0, 200);
		EXPECT_EQ(withoutTimes(warm), withoutTimes(readText(path("again.csv")))) << selection;
		EXPECT_EQ(answers(warm), answers(readText(path("fresh.csv")))) << selection;
		EXPECT_NE(answers(warm), answers(warm.substr(0, warm.size() / 2)));
	}
}

// The rack moves farther in a step than its coarse teeth are thick, of which the plugin warns.
TEST_F(RunnerCommand, QuietRunsPrintNoWarningsButReportThem)
{
	const std::string words = "run rack --resolution 0.2 --steps 2 --json -" + cache();
	const Outcome loud = bench(words), quiet = bench(words + " --quiet");
	ASSERT_EQ(quiet.code, 0) << quiet.err;
	EXPECT_NE(loud.err.find("farther than their walls are thick"), std::string::npos) << loud.err;
	EXPECT_EQ(quiet.err, "");
	EXPECT_FALSE(nlohmann::json::parse(quiet.out)["summary"]["warnings"].empty());
}

TEST_F(RunnerCommand, ReplayPrintsTheSelectionInUse)
{
	needRecording();
	const std::string words = replayWords() + cache() + " --quiet --combine relaxed";
	const std::string alone = bench(words).out;
	EXPECT_NE(alone.find("(0.5% of the radius of "), std::string::npos) << alone;
	EXPECT_EQ(alone.find("the largest s0"), std::string::npos) << alone;
	const std::string both = bench(words + " --size 3.5 --velocity 1 --fresh").out;
	EXPECT_NE(both.find("the largest s0"), std::string::npos) << both;
	EXPECT_NE(both.find("without caches"), std::string::npos) << both;
}

// Every figure of a query is in its row, of the query that it belongs to.
TEST_F(RunnerCommand, ReplayWritesAllThatAQueryTells)
{
	needRecording();
	ASSERT_EQ(bench(replayWords() + cache() + " --quiet --gap-error 0 --csv " + path("told.csv")).code, 0);
	const std::string csv = readText(path("told.csv"));
	const std::vector<double> came = column(csv, "front_came"), gone = column(csv, "front_gone"),
							  clear = column(csv, "still_apart"), searches = column(csv, "gap_searches"),
							  contacts = column(csv, "contacts");
	ASSERT_EQ(came.size(), 40u);
	EXPECT_GT(came[0], 0);
	EXPECT_EQ(gone[0], 0);
	double moves = 0, searched = 0, touching = 0, left = 0;
	for (std::size_t i = 0; i < came.size(); ++i)
	{
		moves += came[i] - gone[i];
		EXPECT_GE(moves, 0) << i;
		EXPECT_TRUE(clear[i] == 0 || came[i] + gone[i] == 0) << i;
		searched += searches[i];
		touching += contacts[i] > 0 ? 1 : 0;
		left += clear[i];
	}
	EXPECT_GT(touching, 0);
	EXPECT_GE(searched, touching);  // the exact gap is searched wherever nodes are near
	EXPECT_GT(left, 0);
	for (const char* name : {"cut_short", "touched_finest_level", "front_kept", "depths_cut_short"})
		EXPECT_EQ(column(csv, name).size(), 40u) << name;
}

TEST_F(RunnerCommand, StepsAreDividedAtImpactsOnRequest)
{
	const auto run = [&](const std::string& words)
	{
		const Outcome outcome = bench("run mixed-needs --resolution 0.03 --steps 60 --dt 0.0083333 --parts 4 --quiet" + cache() +
									  words + " --json " + path("impacts.json"));
		EXPECT_EQ(outcome.code, 0) << outcome.err;
		return json::parse(readText(path("impacts.json")));
	};
	const json fixed = run(""), impacts = run(" --impacts");
	EXPECT_EQ(fixed["constants"]["at_impacts"]["value"], 0);
	EXPECT_EQ(impacts["constants"]["at_impacts"]["value"], 1);
	EXPECT_GT(impacts["summary"]["parts"]["max"], 1);
	EXPECT_NE(impacts["summary"]["parts"], fixed["summary"]["parts"]);
}

// A step's tests are those of its dispatch: within the budget that all pairs share.
TEST_F(RunnerCommand, ARunUnderABudgetReportsWhatItsStepsDid)
{
	const auto run = [&](const std::string& words)
	{
		const Outcome outcome = bench("run mixed-needs --resolution 0.03 --steps 60 --quiet" + cache() + words +
									  " --csv " + path("budget.csv"));
		EXPECT_EQ(outcome.code, 0) << outcome.err;
		return readText(path("budget.csv"));
	};
	const auto largest = [](const std::vector<double>& values)
	{ return values.empty() ? -1 : *std::max_element(values.begin(), values.end()); };
	constexpr double tests = 400;
	const std::string limited = run(" --budget-tests 400"), enough = run(" --budget-tests 1e9"), none = run("");
	EXPECT_LE(largest(column(limited, "hull_tests")), tests);
	EXPECT_GT(largest(column(limited, "hull_tests")), tests / 2);
	EXPECT_GT(largest(column(limited, "pending")), 0);
	EXPECT_GT(largest(column(limited, "excess")), 1);
	EXPECT_GT(largest(column(limited, "dispatch_error_bound")), largest(column(enough, "dispatch_error_bound")));
	EXPECT_EQ(largest(column(enough, "pending")), 0);
	EXPECT_EQ(largest(column(enough, "excess")), 0);
	EXPECT_GT(largest(column(enough, "hull_tests")), tests);
	EXPECT_EQ(column(none, "pending").size(), 60u);
	// The gap is of the recorded poses all the same.
	EXPECT_EQ(column(enough, "gap"), column(none, "gap"));
}

TEST_F(RunnerCommand, DistanceReportsAFiniteGapWhereTheToleranceDoesNot)
{
	needRecording();
	file("apart.csv", std::string(clod::demo::kPosesHeader) + "\n0,0,0,0,0,0,0,1,1,0,0,0,0,0,1\n");
	const std::string words =
		"replay " + path("cup.obj ") + path("spoon.obj ") + path("apart.csv") + cache() + " --quiet --csv -";
	EXPECT_NE(bench(words).out.find(",inf,"), std::string::npos);
	const Outcome distance = bench(words + " --distance --exact");
	ASSERT_EQ(distance.code, 0) << distance.err;
	EXPECT_EQ(distance.out.find("inf"), std::string::npos) << distance.out;
}

TEST_F(RunnerCommand, ADamagedCacheEntryIsBuiltAgain)
{
	needRecording();
	const std::string words = replayWords() + ownCache() + " --exact --csv ";
	ASSERT_EQ(bench(words + path("before.csv")).code, 0);
	int damaged = 0;
	for (const auto& entry : fs::directory_iterator(path("cache")))
	{
		std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
		file.seekp(std::streamoff(entry.file_size() / 2));
		file.put('\x5a').put('\x5a').put('\x5a');
		++damaged;
	}
	ASSERT_GT(damaged, 0);
	const Outcome again = bench(words + path("after.csv"));
	EXPECT_EQ(again.code, 0);
	EXPECT_NE(again.err.find("damaged"), std::string::npos) << again.err;
	EXPECT_EQ(withoutTimes(readText(path("before.csv"))), withoutTimes(readText(path("after.csv"))));
	const Outcome third = bench(words + path("after.csv"));
	EXPECT_EQ(third.err.find("damaged"), std::string::npos) << third.err;
	for (const auto& entry : fs::directory_iterator(path("cache")))
		EXPECT_EQ(entry.path().filename().string().find("partial"), std::string::npos);
}

TEST_F(RunnerCommand, ShortSceneTwiceHasOneTrajectoryInEachPrecision)
{
	for (const char* program : {CLOD_BENCH, CLOD_BENCH_FLOAT64})
	{
		std::string hashes[2];
		for (std::string& hash : hashes)
		{
			const Outcome run =
				runProgram(program, kSmallScene + " --json " + path("run.json") + " --csv " + path("steps.csv") +
										" --poses " + path("run-poses.csv") + cache());
			ASSERT_EQ(run.code, 0) << run.err;
			const json summary = report("run.json");
			hash = summary["trajectory_hash"];
			EXPECT_EQ(summary["schema"], 1);
			EXPECT_EQ(summary["constants"]["solver_iterations"]["value"], 40);
			EXPECT_TRUE(summary["summary"]["stays_in_place"].get<bool>());
			EXPECT_EQ(summary["machine"]["precision"], program == std::string(CLOD_BENCH) ? "float32" : "float64");
			const auto poses = clod::demo::readPoses(path("run-poses.csv"));
			ASSERT_TRUE(poses) << poses.error();
			EXPECT_EQ(poses.value().size(), 40u);
			const std::string checksum = summary["poses"]["xxh64"];
			EXPECT_EQ(readText(path("run-poses.csv.xxh64")), checksum + "  run-poses.csv\n");
		}
		EXPECT_EQ(hashes[0], hashes[1]) << program;
	}
}

// Digits that fall on each other turn round each other's ridges: a facet that is dropped there, and none in its place, is
// missed as soon as a third body changes the motion.
TEST_F(RunnerCommand, AFallThatIsSolvedAgainHardlyOverlaps)
{
	const Outcome run = bench("run pile-heap --resolution 0.1 --steps 62 --seed 1 --passes 3 --parts 8 --quiet "
							  "--verify-penetration --json " + path("fall.json") + cache());
	ASSERT_EQ(run.code, 0) << run.err;
	EXPECT_LT(report("fall.json")["interpenetration"]["deepest"].get<double>(), 6e-5);
}

TEST_F(RunnerCommand, ASceneRunsWithWhatBulletUsersHave)
{
	std::set<std::string> hashes;
	for (const std::string shapes : {"clod", "gimpact", "hull", "bvh-hull"})
	{
		const Outcome run = bench(kSmallScene + " --verify-penetration --shapes " + shapes + " --json " +
								  path("shapes.json") + cache());
		ASSERT_EQ(run.code, 0) << shapes << "\n" << run.err;
		const json summary = report("shapes.json");
		hashes.insert(summary["trajectory_hash"].get<std::string>());
		// A cup that is a hull holds no spoon: that starts inside and leaves it.
		EXPECT_EQ(summary["summary"]["stays_in_place"].get<bool>(), shapes != "hull") << shapes;
		const char* part = shapes == "bvh-hull" ? "btBvhTriangleMeshShape" : "bt";
		EXPECT_NE(summary["shapes"].get<std::string>().find(part), std::string::npos) << shapes;
	}
	EXPECT_EQ(hashes.size(), 4u);
	const Outcome absent = bench(kSmallScene + " --shapes vhacd --peers-dir /none" + cache());
	EXPECT_EQ(absent.code, 1);
	EXPECT_NE(absent.err.find("run scripts/peers"), std::string::npos) << absent.err;
}

TEST_F(RunnerCommand, ASceneOfFourBodiesIsRecordedAndReplayedWhole)
{
	// Two cups and two spoons of the small models; cups and spoons of different pairs never come near.
	const std::string words = "mixed-needs --resolution 0.03 --quiet" + cache();
	const Outcome run = bench("run " + words + " --steps 30 --poses " + path("four.csv") + " --csv " +
							  path("four-steps.csv") + " --json " + path("four.json"));
	ASSERT_EQ(run.code, 0) << run.err;
	const auto poses = clod::demo::readPoses(path("four.csv"), 4);
	ASSERT_TRUE(poses) << poses.error();
	EXPECT_EQ(poses.value().size(), 60u);
	for (const auto& row : poses.value()) EXPECT_EQ(row.bodyA + 1, row.bodyB);
	EXPECT_EQ(report("four.json")["bodies"], 4);
	const std::string replayed = "replay mixed-needs " + path("four.csv") + " --resolution 0.03 --quiet" + cache();
	ASSERT_EQ(bench(replayed + " --csv " + path("four-warm.csv") + " --json " + path("four-replay.json")).code, 0);
	ASSERT_EQ(bench(replayed + " --fresh --csv " + path("four-fresh.csv")).code, 0);
	EXPECT_EQ(answers(readText(path("four-warm.csv"))), answers(readText(path("four-fresh.csv"))));
	const json replay = report("four-replay.json");
	EXPECT_EQ(replay["poses"]["trajectory_hash"], report("four.json")["poses"]["trajectory_hash"]);
	EXPECT_EQ(replay["summary"]["all_rows"]["rows"], 60);
	EXPECT_EQ(replay["summary"]["steps_all_rows"]["rows"], 30);
	// The file does not fit a scene of two bodies, nor two models.
	EXPECT_EQ(bench("replay spoon-cup " + path("four.csv") + " --resolution 0.03 --quiet" + cache()).code, 3);
}

// A thousandth of its radius at most; what stands still stands where it stood.
TEST_F(RunnerCommand, ASeedPutsWhatIsFreeALittleAside)
{
	const auto first = [this](const std::string& seed)
	{
		const Outcome run = bench(kSmallScene + " --seed " + seed + " --poses " + path(seed + ".csv") + cache());
		EXPECT_EQ(run.code, 0) << run.err;
		return clod::demo::readPoses(path(seed + ".csv"), 2).value().front();
	};
	const auto scene = first("0"), other = first("7");
	const double moved = clod::length(scene.a.position - other.a.position);
	const double stood = clod::length(scene.b.position - other.b.position);
	EXPECT_GT(std::max(moved, stood), 1e-6);
	EXPECT_LT(std::max(moved, stood), 1e-4);
	EXPECT_EQ(std::min(moved, stood), 0);
}

TEST_F(RunnerCommand, GivenMeshesFallOnEachOther)
{
	ASSERT_EQ(bench("model number3 --triangles 600 -o " + path("three.obj")).code, 0);
	ASSERT_EQ(bench("model torus --triangles 800 -o " + path("ring.obj")).code, 0);
	ASSERT_EQ(bench("model spoon --triangles 500 -o " + path("large.obj")).code, 0);
	const std::string ring = " --model " + path("ring.obj"), cache = " --quiet" + RunnerCommand::cache();
	const Outcome run = bench("run drop --size 3.5 --verify-penetration --steps 1400 --model " + path("three.obj") +
							  ring + ring + cache + " --csv " + path("steps.csv"));
	EXPECT_EQ(run.code, 0) << run.err;
	EXPECT_NE(run.out.find("at the end in place"), std::string::npos) << run.out;
	EXPECT_EQ(run.out.find("within the tolerance 0.0 %"), std::string::npos) << run.out;
	const Outcome large = bench("run drop --model " + path("large.obj") + cache);
	EXPECT_EQ(large.code, 2);
	EXPECT_NE(large.err.find("build it with --scale"), std::string::npos) << large.err;
	EXPECT_EQ(bench("run drop --model " + path("missing.obj") + cache).code, 3);
}
}  // namespace
