// SPDX-License-Identifier: GPL-3.0-or-later
// clod-bench from outside, as users and scripts run it: a folder, a cache and a small recording for tests of commands.
#pragma once
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "tests/demos/KeptHierarchies.h"
#include "tests/support/Files.h"

namespace clod::test
{
namespace fs = std::filesystem;
using nlohmann::json;

// A scene that builds and runs in seconds.
inline const std::string kSmallScene = "run spoon-cup --resolution 0.03 --steps 40 --quiet";

struct Outcome
{
	int code;
	std::string out, err;
};

// A named column of a csv.
inline std::vector<double> column(const std::string& csv, const std::string& name)
{
	std::istringstream lines(csv);
	std::string header, line, field;
	std::getline(lines, header);
	std::istringstream names(header);
	int wanted = 0;
	while (std::getline(names, field, ',') && field != name) ++wanted;
	std::vector<double> values;
	if (field != name) return values;
	while (std::getline(lines, line))
	{
		std::istringstream fields(line);
		for (int i = 0; i <= wanted; ++i) std::getline(fields, field, ',');
		values.push_back(std::strtod(field.c_str(), nullptr));
	}
	return values;
}

// One folder for the whole program.
class RunnerCommand : public testing::Test
{
protected:
	static void SetUpTestSuite() { s_folder.emplace(); }
	static void TearDownTestSuite() { s_folder.reset(); }

	static std::string path(const std::string& name) { return s_folder->file(name); }
	static std::string file(const std::string& name, const std::string& text) { return s_folder->file(name, text); }
	static std::string cache() { return std::string(" --cache-dir ") + kKeptHierarchies; }
	static std::string ownCache() { return " --cache-dir " + path("cache"); }
	static Outcome runProgram(const std::string& program, const std::string& words)
	{
		const std::string command = program + " " + words + " >" + path("out") + " 2>" + path("err");
		const int status = std::system(command.c_str());
		return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readText(path("out")), readText(path("err"))};
	}
	static Outcome bench(const std::string& words) { return runProgram(CLOD_BENCH, words); }
	static json report(const std::string& name) { return json::parse(readText(path(name))); }

	// A recorded run of the small scene and its meshes, made once.
	static void needRecording()
	{
		if (fs::exists(path("poses.csv"))) return;
		const Outcome run = bench(kSmallScene + " --exact --poses " + path("poses.csv") + cache());
		ASSERT_EQ(run.code, 0) << run.err;
		ASSERT_EQ(bench("model cup --triangles 1920 --quiet -o " + path("cup.obj")).code, 0);
		ASSERT_EQ(bench("model spoon --triangles 2580 --quiet -o " + path("spoon.obj")).code, 0);
	}
	static std::string replayWords()
	{
		return "replay " + path("cup.obj") + " " + path("spoon.obj") + " " + path("poses.csv");
	}

	static inline std::optional<TemporaryFolder> s_folder;
};
}  // namespace clod::test
