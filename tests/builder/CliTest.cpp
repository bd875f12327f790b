// SPDX-License-Identifier: GPL-3.0-or-later
// clod-build as people and scripts use it: exit codes, streams, nothing half written; and the helpers both programs
// share.
#include <CLI/CLI.hpp>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "cli/Files.h"
#include "cli/Length.h"
#include "cli/MeshPath.h"
#include "cli/Program.h"
#include "cli/Progress.h"
#include "cli/Suggestion.h"
#include "tests/builder/ObjText.h"
#include "tests/support/ChildProgram.h"
#include "tests/support/Files.h"
#include "tests/support/Meshes.h"

namespace clod::test
{
namespace
{
namespace fs = std::filesystem;

// A folder of its own for each test.
class Cli : public ::testing::Test
{
protected:
	void SetUp() override { writeMesh("torus.obj", torusMesh(1, 0.4, 24, 12)); }

	std::string path(const std::string& name) const { return m_folder.file(name); }
	void writeText(const std::string& name, const std::string& text) const { m_folder.file(name, text); }
	void writeMesh(const std::string& name, const builder::Mesh& mesh) const { writeText(name, objText(mesh)); }
	pid_t start(std::vector<std::string> arguments)
	{
		arguments.insert(arguments.begin(), CLOD_BUILD_PROGRAM);
		return startProgram(std::move(arguments), path("stdout"), path("stderr"));
	}
	static bool isRunning(pid_t child)
	{
		siginfo_t info{};
		return waitid(P_PID, id_t(child), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == 0;
	}
	static int exitCode(pid_t child) { return waitForProgram(child); }
	int run(std::vector<std::string> arguments) { return exitCode(start(std::move(arguments))); }
	std::string out() const { return readText(path("stdout")); }
	std::string err() const { return readText(path("stderr")); }
	std::size_t filesBesides(const std::string& prefix) const
	{
		std::size_t count = 0;
		for (const auto& entry : fs::directory_iterator(m_folder.path()))
			count += entry.path().filename().string().rfind(prefix, 0) == 0 ? 1 : 0;
		return count;
	}
	const TemporaryFolder m_folder;
};
}  // namespace

TEST_F(Cli, BuildInfoCheckExport)
{
	ASSERT_EQ(run({"build", path("torus.obj"), "-o", path("a.clod"), "--quiet", "--json", path("build.json")}), 0)
		<< err();
	EXPECT_EQ(err(), "");
	const auto built = nlohmann::json::parse(readText(path("build.json")));
	EXPECT_GT(built["build_seconds"].get<double>(), 0);
	ASSERT_EQ(run({"info", path("a.clod"), "--json", "-"}), 0);
	const auto info = nlohmann::json::parse(out());
	for (const char* key : {"schema", "triangles", "levels", "clods", "lods", "bytes", "volume", "center_of_mass",
							"inertia", "build_seconds"})
		EXPECT_TRUE(info.contains(key)) << key;
	for (const char* key : {"level", "triangles", "patches", "max_h", "max_s", "max_cover", "max_protrude", "clod"})
		EXPECT_TRUE(info["levels"][0].contains(key)) << key;
	EXPECT_EQ(info["triangles"], 576);
	EXPECT_EQ(info["bytes"], fs::file_size(path("a.clod")));
	ASSERT_EQ(info["pieces_within"].size(), 5u);
	for (const auto& count : info["pieces_within"])
	{
		nlohmann::json level;
		for (const auto& candidate : info["levels"])
			if (candidate["clod"] &&
				candidate["max_s"].get<double>() <= count["error"].get<double>() * info["radius"].get<double>())
				level = candidate;
		EXPECT_EQ(count["level"], level["level"]) << count;
		EXPECT_EQ(count["pieces"], level["patches"]) << count;
		EXPECT_GT(count["mixed_levels"], 0) << count;
		EXPECT_LE(count["mixed_levels"], info["levels"][0]["patches"]) << count;
	}
	EXPECT_LT(info["pieces_within"][4]["mixed_levels"], info["pieces_within"][0]["mixed_levels"]);
	EXPECT_EQ(run({"check", path("a.clod"), "--mesh", path("torus.obj"), "--quiet", "--json", path("check.json")}), 0)
		<< err();
	const auto check = nlohmann::json::parse(readText(path("check.json")));
	for (const auto& invariant : check["invariants"]) EXPECT_EQ(invariant["violations"], 0) << invariant;
}

TEST_F(Cli, SameBytesForAnyNumberOfThreads)
{
	ASSERT_EQ(run({"build", path("torus.obj"), "-o", path("1.clod"), "--threads", "1", "--quiet"}), 0) << err();
	ASSERT_EQ(run({"build", path("torus.obj"), "-o", path("3.clod"), "--threads", "3", "--quiet"}), 0) << err();
	EXPECT_EQ(readText(path("1.clod")), readText(path("3.clod")));
}

// The paper's filter beside what it is compared with: three hierarchies of their own, each proved.
TEST_F(Cli, PlacementsOfThePaperModeDiffer)
{
	const auto build = [this](const std::string& name, std::vector<std::string> options)
	{
		options.insert(options.begin(), {"build", path("torus.obj"), "-o", path(name), "--quiet"});
		return run(options);
	};
	ASSERT_EQ(build("paper.clod", {"--paper"}), 0) << err();
	std::set<std::string> contents;
	for (const std::string placement : {"filter", "quadric", "probabilistic"})
	{
		ASSERT_EQ(build(placement + ".clod", {"--paper", "--placement", placement}), 0) << err();
		EXPECT_EQ(run({"check", path(placement + ".clod"), "--quiet"}), 0) << placement << err();
		contents.insert(readText(path(placement + ".clod")));
	}
	EXPECT_EQ(contents.size(), 3u);
	EXPECT_EQ(readText(path("paper.clod")), readText(path("filter.clod")));
	EXPECT_EQ(build("x.clod", {"--paper", "--placement", "quadrics"}), 2);
	EXPECT_NE(err().find("'quadrics' is not one of filter, quadric, probabilistic; did you mean quadric?"),
			  std::string::npos)
		<< err();
	EXPECT_EQ(build("x.clod", {"--placement", "quadric"}), 2);
	EXPECT_NE(err().find("--paper"), std::string::npos) << err();
	EXPECT_FALSE(fs::exists(path("x.clod")));
}

// What is exported of level 0 builds the same file again.
TEST_F(Cli, ExportedSurfaceBuildsAgain)
{
	ASSERT_EQ(run({"build", path("torus.obj"), "-o", path("a.clod"), "--quiet"}), 0) << err();
	for (const char* format : {"e.ply", "e.obj", "e.glb"})
	{
		ASSERT_EQ(run({"export", path("a.clod"), "--level", "0", "-o", path(format)}), 0) << err();
		EXPECT_EQ(run({"check", path("a.clod"), "--mesh", path(format), "--quiet"}), 0) << format << err();
	}
	EXPECT_EQ(run({"export", path("a.clod"), "--all-levels", "-o", path("all.ply"), "--json", path("all.json")}), 0)
		<< err();
	EXPECT_GT(nlohmann::json::parse(readText(path("all.json")))["levels"].size(), 1u);
	EXPECT_TRUE(fs::exists(path("all.0.ply")));
}

TEST(MeshPath, APartStandsBehindAGltfFileOnly)
{
	using namespace cli;
	EXPECT_EQ(meshPath("a/b.GLB#Big wheel").file, "a/b.GLB");
	EXPECT_EQ(meshPath("a/b.GLB#Big wheel").part, "Big wheel");
	EXPECT_EQ(meshPath("a/part#3.obj").file, "a/part#3.obj");
	EXPECT_EQ(meshPath("a.gltf").part, "");
	EXPECT_EQ(nameOf(meshPath("x.y/cup.final.stl")), "cup.final");
	EXPECT_EQ(nameOf(meshPath("x.y/cup")), "cup");
	EXPECT_EQ(nameOf(meshPath("a.glb#wheel")), "wheel");
	EXPECT_EQ(shellWord("a/b-1.2_c.obj"), "a/b-1.2_c.obj");
	EXPECT_EQ(shellWord("a b#c"), "'a b#c'");
	EXPECT_EQ(shellWord("it's"), "'it'\\''s'");
	EXPECT_EQ(shellWord(""), "''");
}

TEST_F(Cli, InfoCountsOneAsOne)
{
	writeMesh("box.obj", boxMesh({1, 1, 1}, 1));
	ASSERT_EQ(run({"build", path("box.obj"), "-o", path("box.clod"), "--quiet"}), 0) << err();
	ASSERT_EQ(run({"info", path("box.clod")}), 0) << err();
	EXPECT_NE(out().find("1 level, 1 of them"), std::string::npos) << out();
	EXPECT_NE(out().find(" 1 node, "), std::string::npos) << out();
}

// A glTF scene of two tetrahedra of one mesh and name, the second moved by (10, 0, 0), and a lone triangle.
TEST_F(Cli, PartsOfASceneAreBuiltByThemselves)
{
	std::string buffer;
	const auto append = [&](auto value) { buffer.append(reinterpret_cast<const char*>(&value), sizeof value); };
	for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f}) append(x);
	for (const int i : {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}) append(std::uint16_t(i));
	writeText("scene.bin", buffer);
	const auto accessor = [](int view, int type, int count, const char* shape) -> nlohmann::json {
		return {{"bufferView", view}, {"componentType", type}, {"count", count}, {"type", shape}};
	};
	const auto mesh = [](int indices) -> nlohmann::json {
		return {{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", indices}}}}};
	};
	const nlohmann::json scene = {
		{"asset", {{"version", "2.0"}}},
		{"scene", 0},
		{"scenes", {{{"nodes", {0, 1, 2}}}}},
		{"nodes",
		 {{{"mesh", 0}, {"name", "Big wheel"}},
		  {{"mesh", 0}, {"name", "Big wheel"}, {"translation", {10, 0, 0}}},
		  {{"mesh", 1}, {"name", "flag"}}}},
		{"meshes", {mesh(1), mesh(2)}},
		{"accessors", {accessor(0, 5126, 4, "VEC3"), accessor(1, 5123, 12, "SCALAR"), accessor(1, 5123, 3, "SCALAR")}},
		{"bufferViews",
		 {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", 48}},
		  {{"buffer", 0}, {"byteOffset", 48}, {"byteLength", 24}}}},
		{"buffers", {{{"uri", "scene.bin"}, {"byteLength", 72}}}}};
	writeText("scene.gltf", scene.dump());
	const std::string file = path("scene.gltf");

	ASSERT_EQ(run({"parts", file, "--json", "-"}), 0) << err();
	const auto parts = nlohmann::json::parse(out())["parts"];
	ASSERT_EQ(parts.size(), 3u);
	EXPECT_EQ(parts[0]["name"], "Big_wheel");
	EXPECT_EQ(parts[1]["name"], "Big_wheel_2");
	EXPECT_EQ(parts[2]["name"], "flag");
	EXPECT_EQ(parts[1]["faces"], 4);

	ASSERT_EQ(run({"build", file + "#Big_wheel_2", "-o", path("one.clod"), "--quiet", "--json", path("one.json")}), 0)
		<< err();
	EXPECT_NEAR(nlohmann::json::parse(readText(path("one.json")))["center_of_mass"][0].get<double>(), 10.25, 1e-6);
	EXPECT_EQ(run({"check", path("one.clod"), "--mesh", file + "#Big_wheel_2", "--quiet"}), 0) << err();
	EXPECT_EQ(run({"check", path("one.clod"), "--mesh", file + "#Big_wheel", "--quiet"}), 4);
	EXPECT_EQ(run({"build", file + "#wheel", "-o", path("a.clod"), "--quiet"}), 3);
	EXPECT_NE(err().find("Try: clod-build parts"), std::string::npos) << err();

	// What is refused does not keep the others from being built.
	EXPECT_EQ(run({"build", file, "--parts", "-o", path("all"), "--quiet", "--json", path("all.json")}), 3);
	EXPECT_NE(err().find("part flag: open boundary"), std::string::npos) << err();
	EXPECT_NE(err().find("1 of 3 parts are refused"), std::string::npos) << err();
	EXPECT_NE(err().find("--parts --repair"), std::string::npos) << err();
	EXPECT_EQ(readText(path("all/Big_wheel_2.clod")), readText(path("one.clod")));
	EXPECT_TRUE(fs::exists(path("all/Big_wheel.clod")));
	EXPECT_FALSE(fs::exists(path("all/flag.clod")));
	const auto all = nlohmann::json::parse(readText(path("all.json")))["parts"];
	EXPECT_EQ(all[0]["triangles"], 4);
	EXPECT_TRUE(all[2].contains("refused"));

	EXPECT_EQ(run({"parts", path("torus.obj")}), 3);
	EXPECT_NE(err().find("Try: clod-build build"), std::string::npos) << err();
}

TEST_F(Cli, UsageErrorsNameTheNearestMatch)
{
	EXPECT_EQ(run({"biuld"}), 2);
	EXPECT_NE(err().find("did you mean build?"), std::string::npos) << err();
	EXPECT_EQ(run({"build", path("torus.obj"), "-o", path("a.clod"), "--papr"}), 2);
	EXPECT_NE(err().find("did you mean --paper?"), std::string::npos) << err();
	EXPECT_EQ(run({"build", path("torus.obj"), "-o", path("a.clod"), "--threads", "many"}), 2);
	EXPECT_EQ(run({"build", path("torus.obj"), "-o", path("a.clod"), "--seed", "-1"}), 2);
	EXPECT_NE(err().find("not a whole number"), std::string::npos) << err();
	EXPECT_EQ(run({"build", path("torus.obj"), "-o", path("a.clod"), "--wrap", "0"}), 2);
	EXPECT_EQ(run({"check", path("a.clod"), "--unit", "mm"}), 2);
	EXPECT_NE(err().find("--mesh"), std::string::npos) << err();
	EXPECT_EQ(run({"build", path("torus.obj")}), 2);
	EXPECT_EQ(run({"build", path("torus.obj"), "-o", ""}), 2);
	EXPECT_NE(err().find("--output: the name to write to is empty"), std::string::npos) << err();
	EXPECT_EQ(run({}), 2);
	EXPECT_FALSE(fs::exists(path("a.clod")));
	EXPECT_EQ(run({"build", path("torus.obj"), "-o", path("./torus.obj")}), 2) << "the mesh itself";
	EXPECT_EQ(run({"--help"}) + run({"build", "--help"}), 0);
	EXPECT_NE(out().find("Example:"), std::string::npos);
	EXPECT_EQ(run({"--version"}), 0);
	EXPECT_NE(out().find("GPL-3.0-or-later"), std::string::npos);
	for (const char* told : {"(commit ", "precision double", "kernels ", "file format 3", "compiler "})
		EXPECT_NE(out().find(told), std::string::npos) << told << " in\n" << out();
	setenv("CLOD_NO_AVX2", "1", 1);
	EXPECT_EQ(run({"--version"}), 0);
	unsetenv("CLOD_NO_AVX2");
	EXPECT_NE(out().find("kernels plain"), std::string::npos) << out();
}

TEST_F(Cli, BadInputIsExitCode3AndWritesNothing)
{
	writeText("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
	EXPECT_EQ(run({"build", path("open.obj"), "-o", path("a.clod")}), 3);
	EXPECT_NE(err().find("open boundary: edge (0, 1) of face 0"), std::string::npos) << err();
	EXPECT_EQ(run({"build", path("none.obj"), "-o", path("a.clod")}), 3);
	// A format that is not read: what converts it, into another file.
	writeText("part.dae", "<COLLADA/>");
	EXPECT_EQ(run({"build", path("part.dae"), "-o", path("a.clod")}), 3);
	EXPECT_NE(err().find("Try: assimp export " + path("part.dae") + " part-exported.obj"), std::string::npos) << err();
	EXPECT_EQ(run({"build", m_folder.path().string(), "-o", path("a.clod")}), 3);
	writeText("bad.clod", "not a hierarchy");
	EXPECT_EQ(run({"info", path("bad.clod")}), 3);
	EXPECT_EQ(run({"check", path("bad.clod")}), 3);
	EXPECT_EQ(run({"export", path("bad.clod"), "--level", "0", "-o", path("a.ply")}), 3);
	EXPECT_EQ(filesBesides("a."), 0u);
}

TEST_F(Cli, RepairSaysWhatItDidAndHowFarItMoved)
{
	writeText("open.obj", kVertices + kBottom + kSides);
	ASSERT_EQ(run({"build", path("open.obj"), "-o", path("a.clod"), "--repair", "--max-move", "70%", "--quiet",
				   "--json", path("a.json")}),
			  0)
		<< err();
	EXPECT_NE(out().find("repair: 1 hole closed with 2 faces"), std::string::npos) << out();
	EXPECT_NE(out().find("certified"), std::string::npos) << out();
	const auto repair = nlohmann::json::parse(readText(path("a.json")))["repair"];
	EXPECT_EQ(repair["changes"].size(), 1u) << repair;
	EXPECT_GE(repair["added"]["upper"], 0.4) << repair;
	EXPECT_EQ(run({"check", path("a.clod"), "--quiet"}), 0);
	EXPECT_EQ(run({"build", path("open.obj"), "-o", path("b.clod"), "--repair", "--max-move", "1%"}), 5);
	EXPECT_NE(err().find("would move the surface by"), std::string::npos) << err();
	EXPECT_EQ(filesBesides("b."), 0u);
	ASSERT_EQ(run({"build", path("torus.obj"), "-o", path("c.clod"), "--repair", "--quiet"}), 0);
	EXPECT_NE(out().find("repair: nothing to do"), std::string::npos) << out();
}

TEST_F(Cli, WrapBuildsAStandIn)
{
	writeText("open.obj", kVertices + kBottom + kSides);
	ASSERT_EQ(run({"build", path("open.obj"), "-o", path("a.clod"), "--wrap", "150%", "--quiet"}), 0) << err();
	EXPECT_NE(out().find("wrapped by"), std::string::npos) << out();
	EXPECT_EQ(run({"check", path("a.clod"), "--quiet"}), 0);
	EXPECT_EQ(run({"build", path("open.obj"), "-o", path("b.clod"), "--wrap", "150%", "--repair"}), 2);
	EXPECT_EQ(run({"build", path("open.obj"), "-o", path("b.clod"), "--wrap", "0.0001%"}), 5);
	EXPECT_EQ(run({"build", path("open.obj"), "-o", path("b.clod"), "--most-triangles", "2000"}), 2);
	EXPECT_EQ(filesBesides("b."), 0u);
}

TEST_F(Cli, UnitsAxesAndScaleAreConverted)
{
	ASSERT_EQ(
		run({"build", path("torus.obj"), "-o", path("a.clod"), "--unit", "mm", "--up", "z", "--scale", "2", "--quiet"}),
		0)
		<< err();
	ASSERT_EQ(run({"info", path("a.clod"), "--json", "-"}), 0);
	EXPECT_NEAR(nlohmann::json::parse(out())["radius"].get<double>(), 0.0028, 1e-6);
	EXPECT_EQ(run({"check", path("a.clod"), "--mesh", path("torus.obj"), "--unit", "mm", "--up", "z", "--scale", "2",
				   "--quiet"}),
			  0);
	EXPECT_EQ(run({"check", path("a.clod"), "--mesh", path("torus.obj"), "--quiet"}), 4);
	for (const std::vector<std::string>& bad : {std::vector<std::string>{"--unit", "mmm"},
												{"--up", "w"},
												{"--scale", "0"},
												{"--scale", "nan"},
												{"--scale", "-1"}})
		EXPECT_EQ(run({"build", path("torus.obj"), "-o", path("b.clod"), bad[0], bad[1]}), 2) << bad[0] << bad[1];
	EXPECT_EQ(filesBesides("b."), 0u);
}

TEST_F(Cli, TooLargeIsExitCode5)
{
	writeText("huge.obj", "v 0 0 0\nv 1e30 0 0\nv 0 1e30 0\nv 0 0 1e30\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
	EXPECT_EQ(run({"build", path("huge.obj"), "-o", path("a.clod")}), 5);
}

TEST_F(Cli, UnwritableOutputIsExitCode1)
{
	EXPECT_EQ(run({"build", path("torus.obj"), "-o", path("no/such/folder/a.clod"), "--quiet"}), 1);
	EXPECT_EQ(run({"build", path("torus.obj"), "-o", path("a.clod"), "--json", path("no/such/folder/a.json")}), 1);
	EXPECT_EQ(run({"build", path("torus.obj"), "-o", path("")}), 1);
	EXPECT_NE(err().find("is a directory"), std::string::npos) << err();
	EXPECT_FALSE(fs::exists(path("a.clod")));
}

TEST_F(Cli, ExportRefusesLevelsWithoutASurface)
{
	ASSERT_EQ(run({"build", path("torus.obj"), "-o", path("a.clod"), "--quiet"}), 0) << err();
	EXPECT_EQ(run({"export", path("a.clod"), "--level", "99", "-o", path("e.ply")}), 2);
	EXPECT_EQ(run({"export", path("a.clod"), "--level", "0", "-o", path("e.xyz")}), 2);
	EXPECT_EQ(filesBesides("e."), 0u);
}

TEST_F(Cli, WrongMeshIsExitCode4)
{
	ASSERT_EQ(run({"build", path("torus.obj"), "-o", path("a.clod"), "--quiet"}), 0) << err();
	writeMesh("other.obj", torusMesh(1, 0.41, 24, 12));
	EXPECT_EQ(run({"check", path("a.clod"), "--mesh", path("other.obj"), "--quiet"}), 4);
	EXPECT_NE(err().find("equals-mesh"), std::string::npos) << err();
}

// In every phase of a build: the exit code, no file beside, and what lay at the output's place is untouched.
TEST_F(Cli, InterruptionLeavesNothing)
{
	writeMesh("large.obj", wrinkledTorusMesh(1, 0.35, 0.05, 15, 60, 30));
	writeText("a.clod", "what was there before");
	// Levels are certified while coarser ones are made; bridging comes after all of them.
	for (const char* phase : {"decompose: ", "simplify: ", "bridge: "})
	{
		const pid_t child = start({"build", path("large.obj"), "-o", path("a.clod"), "--threads", "2"});
		while (err().find(phase) == std::string::npos && isRunning(child))
			std::this_thread::sleep_for(std::chrono::milliseconds(2));
		kill(child, SIGINT);
		EXPECT_EQ(exitCode(child), 130) << phase << err();
		EXPECT_EQ(filesBesides("a."), 1u) << phase;
		EXPECT_EQ(readText(path("a.clod")), "what was there before") << phase;
	}
}

// Here half of a file is written when the signal comes. SIGXFSZ says that it may not grow: an error as on a full disk.
TEST_F(Cli, InterruptionRemovesWhatIsHalfWritten)
{
	for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGXCPU, SIGXFSZ})
	{
		const pid_t child = fork();
		if (child == 0)
		{
			CLI::App app;
			const auto write = [&]
			{
				const cli::PartialFile partial(path("a.txt"));
				std::ofstream(partial.temporaryPath()) << "half";
				kill(getpid(), signal);
			};
			app.add_subcommand("write")->callback(write);
			char program[] = "program", command[] = "write", *words[] = {program, command};
			::signal(SIGHUP, SIG_DFL);
			_exit(cli::runProgram(app, 2, words));
		}
		EXPECT_EQ(exitCode(child), signal == SIGXFSZ ? 0 : 130) << signal;
		EXPECT_EQ(filesBesides("a."), 0u) << signal;
	}
}

TEST_F(Cli, FilesAppearWholeOrNotAtAll)
{
	{
		const cli::PartialFile partial(path("p.txt"));
		std::ofstream(partial.temporaryPath()) << "half";
	}
	EXPECT_EQ(filesBesides("p"), 0u);
	EXPECT_EQ(cli::writeFile(path("p.txt"), std::string("whole")), "");
	EXPECT_EQ(readText(path("p.txt")), "whole");
	EXPECT_EQ(filesBesides("p"), 1u);
	EXPECT_EQ(cli::writeFile("/dev/null", std::string("x")), "");
	EXPECT_TRUE(fs::is_character_file("/dev/null"));
	EXPECT_NE(cli::writeFile("/dev/full", std::string("x")), "") << "no room is left there";
}

TEST(CliLength, IsReadAsWritten)
{
	EXPECT_EQ(cli::parseLength("0.5mm").value().inMeshUnit(7), 0.0005);
	EXPECT_EQ(cli::parseLength("0.0005").value().inMeshUnit(7), 0.0005);
	EXPECT_EQ(cli::parseLength("1%").value().inMeshUnit(7), 0.07);
	for (const char* bad : {"", "mm", "1 mm", "-1mm", "nan", "inf", "1parsec", "1,5mm", "0x1"})
		EXPECT_FALSE(bool(cli::parseLength(bad))) << bad;
}

TEST(CliLength, EveryMendingIsCoarserThanTheOneBefore)
{
	EXPECT_EQ(cli::mendingAfter(false, {}), "--repair");
	EXPECT_EQ(cli::mendingAfter(true, {}), "--wrap 2%");
	EXPECT_EQ(cli::mendingAfter(false, cli::parseLength("2%").value()), "--wrap 5%");
	EXPECT_EQ(cli::mendingAfter(false, cli::parseLength("5%").value()), "--wrap 12.5%");
	EXPECT_EQ(cli::mendingAfter(false, cli::parseLength("2mm").value()), "--wrap 0.005");
}

// What is written where no terminal is: a line a phase, however often it is told.
class CliProgress : public ::testing::Test
{
protected:
	std::string said(bool terminal) const
	{
		std::FILE* const stream = std::fopen(m_folder.file("said").c_str(), "w");
		{
			cli::Progress progress(stream, terminal);
			for (int i = 0; i <= 1000; ++i) progress.update("first", i / 1000.0);
			progress.update("second", 0.3);
			if (!terminal) std::fputs("warning\n", stream);
			progress.finish();
			progress.finish();
			std::fputs("other words\n", stream);
		}
		std::fclose(stream);
		return readText(m_folder.file("said"));
	}

private:
	TemporaryFolder m_folder;
};

TEST_F(CliProgress, IsALineAPhaseInALog)
{
	const std::string text = said(false);
	EXPECT_EQ(text.rfind("first: ", 0), 0u) << text;
	EXPECT_NE(text.find(" s\nwarning\nsecond: "), std::string::npos) << text;
	EXPECT_NE(text.find(" s\nother words\n"), std::string::npos) << text;
	EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4) << text;
}

TEST_F(CliProgress, IsABarOnATerminal)
{
	const std::string text = said(true);
	EXPECT_EQ(text.rfind("\rfirst ", 0), 0u) << text;
	EXPECT_NE(text.find("[##############################] 100 %"), std::string::npos) << text;
	EXPECT_NE(text.find("[#########.....................]  30 %"), std::string::npos) << text;
	EXPECT_NE(text.find("\nother words\n"), std::string::npos) << "it starts at the left margin";
	EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3) << text;
	EXPECT_LE(std::count(text.begin(), text.end(), '\r'), 10) << "drawn at most so often a second";
}

TEST(CliSuggestion, FindsTheNearest)
{
	EXPECT_EQ(cli::nearest("biuld", {"info", "build", "check"}), "build");
	EXPECT_EQ(cli::nearest("entirely-different", {"info", "build"}), "");
}
}  // namespace clod::test
