// SPDX-License-Identifier: GPL-3.0-or-later
// The stability matrix: its verdicts on planted numbers, rows with closed forms computed here once more, and the
// command from outside with what it writes.
#include <algorithm>
#include <cmath>
#include <limits>
#include <regex>
#include <set>

#include "cli/Failure.h"
#include "demos/extremes/MatrixReport.h"
#include "demos/extremes/Solids.h"
#include "tests/demos/RunnerCommand.h"

namespace
{
using namespace clod::demo;
using namespace clod::test;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// One quantity of one run with these errors of primitive, mesh, exact, 0.5 % and 3.5 %.
Matrix matrixOf(const Bound& bound, const std::array<double, kColliders>& errors)
{
	Matrix matrix;
	Row row;
	row.id = "T1";
	row.shows = "a \"test\"";
	row.axis = "size";
	row.cases = {{1, "1 m"}};
	row.rates = {240};
	row.quantities = {{"height", "m", bound}};
	matrix.rows = {row};
	matrix.seconds = {0};
	for (std::size_t i = 0; i < errors.size(); ++i)
	{
		Cell cell;
		cell.caseLabel = "1 m";
		cell.setting = {Collider(i), 240, 1, false};
		cell.reading = {errors[i], 0, errors[i]};
		cell.verdict = Verdict::outside;
		matrix.cells.push_back(cell);
	}
	return matrix;
}

const Cell& cellOf(const Matrix& matrix, Collider collider)
{
	return matrix.cells.at(std::size_t(collider));
}

TEST(ExtremesVerdict, IsOfTheBoundAndOfBulletsMesh)
{
	Matrix matrix = matrixOf({0.1, 2, 0.05}, {0.3, 0.2, 0.1, 0.4, 0.46});
	judge(matrix);
	EXPECT_EQ(cellOf(matrix, Collider::primitive).verdict, Verdict::outside);
	EXPECT_EQ(cellOf(matrix, Collider::mesh).verdict, Verdict::outside);  // what Bullet does is no excuse for Bullet
	EXPECT_EQ(cellOf(matrix, Collider::exact).verdict, Verdict::holds);
	EXPECT_EQ(cellOf(matrix, Collider::standard).verdict, Verdict::asBullet);
	EXPECT_EQ(cellOf(matrix, Collider::coarse).verdict, Verdict::outside);
	EXPECT_DOUBLE_EQ(cellOf(matrix, Collider::standard).bound, 0.45);
	EXPECT_EQ(matrix.count(Verdict::outside), 1);
	const auto told = [&]
	{
		try
		{
			demandBounds(matrix);
		}
		catch (const clod::cli::Failure& failure)
		{
			return std::string(failure.what());
		}
		return std::string();
	};
	EXPECT_EQ(told(), "1 number is outside of the bound, and no known limit");
	matrix.cells.push_back(cellOf(matrix, Collider::coarse));
	EXPECT_EQ(told(), "2 numbers are outside of the bound, and no known limit");
	matrix.cells.pop_back();
	matrix.rows[0].quantities[0].bound.most = 0.5;
	judge(matrix);
	EXPECT_NO_THROW(demandBounds(matrix));
}

TEST(ExtremesVerdict, ALimitIsNamedAndOneThatIsNotMetToo)
{
	Matrix matrix = matrixOf({0.1}, {0, 0, 0.05, 0.2, 0.2});
	matrix.rows[0].limits = {{"it sinks", [](const Setting& s) { return s.collider == Collider::coarse; }, "height"},
							 {"it flies", [](const Setting& s) { return s.collider == Collider::exact; }, ""},
							 {"of another number", [](const Setting&) { return true; }, "speed"}};
	judge(matrix);
	EXPECT_EQ(cellOf(matrix, Collider::coarse).verdict, Verdict::limit);
	EXPECT_EQ(cellOf(matrix, Collider::coarse).note, "it sinks");
	EXPECT_EQ(cellOf(matrix, Collider::exact).verdict, Verdict::holds);
	EXPECT_EQ(cellOf(matrix, Collider::standard).verdict, Verdict::outside);
	EXPECT_EQ(matrix.needlessLimits(), (std::vector<std::string>{"T1: it flies", "T1: of another number"}));
}

// Not a number is outside, whatever Bullet does.
TEST(ExtremesVerdict, WhatIsNotFiniteIsNeverWithin)
{
	Matrix matrix = matrixOf({0.1, 2}, {kInfinite, kInfinite, kInfinite, 1e30, 0});
	judge(matrix);
	EXPECT_EQ(cellOf(matrix, Collider::exact).verdict, Verdict::outside);
	EXPECT_EQ(cellOf(matrix, Collider::standard).verdict, Verdict::asBullet);
	EXPECT_EQ(cellOf(matrix, Collider::coarse).verdict, Verdict::holds);
}

TEST(ExtremesVerdict, WhereBulletDoesBetterItIsSaid)
{
	Matrix matrix = matrixOf({1}, {0.01, 0.3, 0.2, 0.02, 0.011});
	judge(matrix);
	EXPECT_EQ(cellOf(matrix, Collider::exact).better, "primitive");
	EXPECT_EQ(cellOf(matrix, Collider::standard).better, "");  // a hundredth of the bound tells nothing
	EXPECT_EQ(cellOf(matrix, Collider::coarse).better, "");
	matrix = matrixOf({0.1}, {0.01, 0.01, 0.05, 0.01, 0.0101});
	judge(matrix);
	EXPECT_EQ(cellOf(matrix, Collider::exact).better, "primitive, mesh");
	EXPECT_EQ(cellOf(matrix, Collider::coarse).better, "");
}

TEST(ExtremesVerdict, ReadingsKnowTheirError)
{
	EXPECT_DOUBLE_EQ(relativeTo(2, 3).error, 0.5);
	EXPECT_DOUBLE_EQ(relativeTo(-2, -3).error, 0.5);
	EXPECT_DOUBLE_EQ(differenceFrom(2, 1.5).error, 0.5);
	EXPECT_TRUE(std::isnan(relativeTo(2, std::nan("")).error));
}

TEST(ExtremesRows, HaveUniqueIdsBoundsAndAnAxisOnlyWithItsPlaces)
{
	const std::vector<Row> rows = allRows();
	std::set<std::string> ids, axes;
	for (const Row& row : rows)
	{
		EXPECT_TRUE(ids.insert(row.id).second) << row.id;
		EXPECT_FALSE(row.shows.empty() || row.source.empty() || row.rates.empty() || row.quantities.empty()) << row.id;
		for (const Quantity& quantity : row.quantities) EXPECT_GE(quantity.bound.most, 0) << row.id;
		if (row.axis.empty()) continue;
		EXPECT_GT(row.axis == "step" ? row.rates.size() : row.cases.size(), 4u) << row.id;
		EXPECT_TRUE(axes.insert(row.axis).second) << row.axis;
	}
	for (const char* axis : {"step", "speed", "size", "mass ratio", "overlap"}) EXPECT_EQ(axes.count(axis), 1u) << axis;
	// The lists are whole: what is no run is a test.
	for (const TestedElsewhere& row : testedElsewhere()) ids.insert(row.id);
	const auto has = [&](const std::string& id)
	{
		return std::any_of(ids.begin(), ids.end(),
						   [&](const std::string& one)
						   {
							   return one == id || (one.size() == id.size() + 1 && one.compare(0, id.size(), id) == 0 &&
													std::isalpha(static_cast<unsigned char>(one.back())) != 0);
						   });
	};
	for (int i = 1; i <= 32; ++i) EXPECT_TRUE(has("E" + std::to_string(i))) << "E" << i;
	for (int i = 1; i <= 21; ++i) EXPECT_TRUE(has("A" + std::to_string(i))) << "A" << i;
	for (int i = 1; i <= 13; ++i) EXPECT_TRUE(has("C" + std::to_string(i))) << "C" << i;
}

// As "LifecycleTest: ARestingPairSleepsAndWakes, RemovalLeavesNoManifold; CacheTest: CachedEqualsFreshBitForBit".
TEST(ExtremesRows, ThatAreTestedElsewhereNameTestsThatAreThere)
{
	std::map<std::string, std::string> sources;
	for (const auto& entry : fs::recursive_directory_iterator(std::string(CLOD_SOURCE_FOLDER) + "/tests"))
		if (entry.path().extension() == ".cpp")
			sources[entry.path().stem().string()] += readText(entry.path().string());
	int named = 0;
	for (const TestedElsewhere& row : testedElsewhere())
	{
		const std::string text = row.test;
		const std::regex names("(?:(\\w+Test): |, )(\\w+)");
		std::string source;
		for (std::sregex_iterator i(text.begin(), text.end(), names), end; i != end; ++i, ++named)
		{
			if ((*i)[1].matched) source = (*i)[1];
			EXPECT_TRUE(std::regex_search(sources[source], std::regex(", *" + (*i)[2].str() + "\\)")))
				<< row.id << ": " << (*i)[2];
		}
	}
	EXPECT_GT(named, 20);
}

TEST(ExtremesRows, ThatAreChosenAreThoseAskedFor)
{
	MatrixOptions options;
	options.only = "A13";
	ASSERT_EQ(chosenRows(allRows(), options).size(), 1u);
	options.only = "A99";
	EXPECT_THROW(chosenRows(allRows(), options), clod::cli::Failure);
	options = {};
	options.isQuick = true;
	for (const Row& row : chosenRows(allRows(), options))
	{
		EXPECT_LE(row.cases.size(), 1u) << row.id;
		EXPECT_EQ(row.rates.size(), 1u) << row.id;
	}
}

class Extremes : public RunnerCommand
{
protected:
	// One row at 1/240 s, its first case.
	static Matrix run(const std::string& id, double shareOfBounds = 1)
	{
		Workshop workshop(keptHierarchies());
		MatrixOptions options;
		options.only = id;
		options.isQuick = true;
		options.shareOfBounds = shareOfBounds;
		return runMatrix(chosenRows(allRows(), options), workshop, true, [](const std::string&, double) {});
	}
};

// Formulas once more, of constants written here.
TEST_F(Extremes, ClosedFormsAreMet)
{
	struct Expected
	{
		const char* id;
		double value, share;
	};
	const double pi = 3.14159265358979, g = 9.81, dt = 1.0 / 240, slope = 30 * pi / 180, swing = 3 * pi / 180;
	const double period = 2 * pi * std::sqrt((1.04 / 12 + 0.16) / (g * 0.4)) * (1 + swing * swing / 16);
	for (const Expected& expected : {Expected{"A1", g * 2 * (2 + dt) / 2, 1e-5},
									 Expected{"A3", 2 * g * (std::sin(slope) - 0.2 * std::cos(slope)), 0.03},
									 Expected{"A4", 9 / (2 * 0.3 * g), 0.03}, Expected{"A19", period, 0.01}})
	{
		const Matrix matrix = run(expected.id);
		EXPECT_EQ(matrix.count(Verdict::outside), 0) << expected.id;
		for (const Collider collider : {Collider::exact, Collider::standard, Collider::coarse})
		{
			const Reading& reading = cellOf(matrix, collider).reading;
			EXPECT_NEAR(reading.value, expected.value, expected.share * expected.value) << expected.id;
			EXPECT_NEAR(reading.expected, expected.value, 1e-6 * expected.value) << expected.id;
		}
	}
}

// What touches nothing does not depend on the shape: else the harness is wrong.
TEST_F(Extremes, ControlsAreThePrimitivesBits)
{
	for (const char* id : {"A1", "A9", "A19"})
	{
		const Matrix matrix = run(id);
		const std::size_t last = matrix.rows[0].quantities.size() - 1;
		for (const Cell& cell : matrix.cells)
		{
			EXPECT_TRUE(cell.quantity != last || cell.reading.error == 0) << id << ", " << name(cell.setting.collider);
		}
	}
}

// The same run, judged by a bound that nothing keeps.
TEST_F(Extremes, ABoundThatIsNotKeptIsOutside)
{
	EXPECT_NO_THROW(demandBounds(run("A3")));
	try
	{
		demandBounds(run("A3", 1e-9));
		FAIL() << "nothing was thrown";
	}
	catch (const clod::cli::Failure& failure)
	{
		EXPECT_EQ(failure.code(), clod::cli::ExitCode::verificationFailed);
	}
}

std::size_t lines(const std::string& text)
{
	return std::size_t(std::count(text.begin(), text.end(), '\n'));
}

TEST_F(Extremes, TheCommandWritesEverything)
{
	const Outcome first = bench("extremes --quick --quiet -o " + path("first") + cache());
	ASSERT_EQ(first.code, 0) << first.out << first.err;
	const std::string csv = readText(path("first/extremes.csv"));
	EXPECT_EQ(csv.substr(0, csv.find('\n')),
			  "row,quantity,unit,case,rate,collider,value,expected,error,bound,verdict,better,note");

	const json report = RunnerCommand::report("first/extremes.json");
	EXPECT_EQ(report["command"], "extremes");
	EXPECT_TRUE(report["schema"].is_number_integer());
	std::size_t cells = 0;
	std::map<std::string, int> counts;
	for (const json& row : report["rows"])
	{
		for (const char* member : {"id", "shows", "source", "axis", "seconds", "quantities", "cells"})
			EXPECT_TRUE(row.contains(member)) << member;
		cells += row["cells"].size();
		for (const json& cell : row["cells"])
		{
			for (const char* member : {"quantity", "case", "rate", "collider", "value", "expected", "error", "bound",
									   "verdict", "better", "note"})
				ASSERT_TRUE(cell.contains(member)) << member;
			const std::string collider = cell["collider"];
			if (collider == "exact" || collider == "0.5 %" || collider == "3.5 %") ++counts[cell["verdict"]];
		}
	}
	EXPECT_EQ(lines(csv), cells + 1);
	// A number that is nothing for everybody was not taken, but where nothing is what it should be.
	const std::set<std::string> mayBeNothing = {"energy gained", "passed", "overlap left",     "momentum",
												"difference",    "missed", "amplitude gained", "switches missed"};
	for (const json& row : report["rows"])
	{
		std::map<std::string, bool> isSomething;
		for (const json& cell : row["cells"])
			if (cell["verdict"] != "not applicable") isSomething[cell["quantity"]] |= cell["value"] != 0;
		for (const auto& [quantity, is] : isSomething)
			EXPECT_TRUE(is || mayBeNothing.count(quantity)) << row["id"] << ": " << quantity;
		const auto isOfOurs = [](const json& cell)
		{
			const std::string collider = cell["collider"];
			return cell["verdict"] != "not applicable" && (collider == "exact" || collider == "0.5 %" || collider == "3.5 %");
		};
		EXPECT_TRUE(std::any_of(row["cells"].begin(), row["cells"].end(), isOfOurs)) << row["id"] << " says nothing of ours";
	}
	for (const char* verdict : {"holds", "as Bullet", "limit", "outside"})
		EXPECT_EQ(report["counts"][verdict], counts[verdict]) << verdict;
	EXPECT_EQ(report["outside"].size(), 0u);
	EXPECT_GT(report["tested_elsewhere"].size(), 10u);

	const std::string map = readText(path("first/extremes.svg"));
	EXPECT_EQ(map.compare(0, 4, "<svg"), 0);
	EXPECT_NE(map.find("overlap"), std::string::npos);
	const std::regex share(">0[.][0-9][0-9]( [*])?</text>");
	EXPECT_GT(std::distance(std::sregex_iterator(map.begin(), map.end(), share), std::sregex_iterator()), 5)
		<< "cells tell which share of its bound each reading is";
	EXPECT_EQ(map.substr(map.size() - 7), "</svg>\n");
	// Its page holds all of it, with room beside.
	const auto largest = [&map](const char* number)
	{
		double most = 0;
		const std::regex pattern(std::string("[ ]") + number + "=\"([0-9.]+)\"");
		for (std::sregex_iterator i(map.begin(), map.end(), pattern), end; i != end; ++i)
			most = std::max(most, std::stod((*i)[1]));
		return most;
	};
	EXPECT_GT(largest("width"), largest("x"));
	EXPECT_GT(largest("height"), largest("y") + 10);
}

// Alone, again, and after another row of the same process.
TEST_F(Extremes, ARowIsTheSameEveryTime)
{
	const auto csvOf = [&](const std::string& folder)
	{
		EXPECT_EQ(bench("extremes --only J4 --quick --quiet -o " + path(folder) + cache()).code, 0);
		return readText(path(folder + "/extremes.csv"));
	};
	const std::string once = csvOf("once");
	EXPECT_GT(lines(once), 20u);
	EXPECT_EQ(once, csvOf("again"));
	Workshop workshop(keptHierarchies());
	MatrixOptions options;
	options.isQuick = true;
	std::vector<Row> rows;
	for (Row& row : chosenRows(allRows(), options))
		if (row.id == "J3" || row.id == "J4") rows.push_back(std::move(row));
	const std::string both = formatCsv(runMatrix(std::move(rows), workshop, true, [](const std::string&, double) {}));
	EXPECT_NE(both.find(once.substr(once.find('\n') + 1)), std::string::npos);
}

TEST_F(Extremes, TheCommandEndsWith4OutsideABoundAndWith2ForAWrongRow)
{
	const Outcome outside = bench("extremes --only A3 --quick --quiet --bounds 1e-9 -o " + path("outside") + cache());
	EXPECT_EQ(outside.code, 4);
	EXPECT_NE(outside.err.find("outside of the bound"), std::string::npos) << outside.err;
	EXPECT_NE(outside.out.find("OUTSIDE A3"), std::string::npos) << outside.out;
	const Outcome wrong = bench("extremes --only A31 --quick --quiet -o " + path("wrong") + cache());
	EXPECT_EQ(wrong.code, 2);
	EXPECT_NE(wrong.err.find("no row is called 'A31'"), std::string::npos) << wrong.err;
}
}  // namespace
