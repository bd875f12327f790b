// SPDX-License-Identifier: GPL-3.0-or-later
// clod-oracle: the motion oracle over families of poses.
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cstdio>
#include <fstream>

#include "demos/cli/Files.h"
#include "demos/cli/Program.h"
#include "tests/oracle/BulletSubject.h"
#include "tests/oracle/Report.h"
#include "tests/query/Bodies.h"

namespace clod::oracle
{
namespace
{
struct Options
{
	cli::CommonOptions common;
	std::string family = "all", setting = "exact", csv;
	std::size_t poses = 300;
	int samples = 48;
	std::optional<std::size_t> pose;
};

HierarchyPointer built(const TriangleMesh& mesh)
{
	builder::Mesh input;
	input.vertices = mesh.vertices;
	input.triangles = mesh.triangles;
	return test::bodyOf("body of a family", input).hierarchy;
}

MakeSubject subjectOf(const std::string& setting)
{
	if (setting == "gimpact") return [](const BodyPair& pair) { return gimpactSubject(pair.a, pair.b); };
	ContactMetric metric = ContactMetric::exactly();
	if (setting == "default") metric = Context().worldMetric;
	if (setting == "3.5%") metric = ContactMetric::deviationShare(0.035);
	return [metric](const BodyPair& pair) { return clodSubject(built(pair.a), built(pair.b), metric); };
}

void checked(const std::string& error)
{
	if (!error.empty()) throw cli::Failure(cli::ExitCode::failure, error);
}

void runPose(const Family& family, const Options& options, const TrialRules& rules)
{
	const std::optional<Trial> trial = FamilyTrials(family, subjectOf(options.setting), rules).run(*options.pose);
	fmt::print("{} pose {}: {}", family.name, *options.pose, trial ? described(*trial) : "the bodies do not meet\n");
}

void run(const Options& options)
{
	TrialRules rules;
	rules.seed = options.common.seed;
	rules.judge.samples = options.samples;
	nlohmann::ordered_json rows = nlohmann::ordered_json::array();
	if (!options.pose && options.common.textOnStdout()) fmt::print("{}", tableHead());
	for (const Family& family : families())
	{
		if (options.family != "all" && options.family != family.name) continue;
		if (options.pose)
		{
			runPose(family, options, rules);
			continue;
		}
		FamilyResult result = FamilyTrials(family, subjectOf(options.setting), rules).runAll(options.poses);
		if (options.common.textOnStdout()) fmt::print("{}", tableLine(result));
		std::fflush(stdout);
		for (const auto& row : rowsOf(result, options.setting)) rows.push_back(row);
	}
	if (options.pose) return;
	if (!options.csv.empty()) checked(cli::writeFile(options.csv, csvOf(rows)));
	if (!options.common.json.empty()) checked(cli::writeJson(options.common.json, rows));
}
}  // namespace
}  // namespace clod::oracle

int main(int argc, char** argv)
{
	using namespace clod;
	CLI::App app("What motions do contacts allow? Families of poses against brute force on the meshes", "clod-oracle");
	oracle::Options options;
	std::vector<std::string> names = {"all"};
	for (const oracle::Family& family : oracle::families()) names.push_back(family.name);
	cli::addChoice(app, "--family", options.family, names, "Family of poses");
	cli::addChoice(app, "--setting", options.setting, {"exact", "default", "3.5%", "gimpact"},
				   "Contact levels, or Bullet's GImpact");
	app.add_option("--poses", options.poses, "Poses a family")->capture_default_str();
	app.add_option("--samples", options.samples, "Motions a pose and cone")->capture_default_str();
	app.add_option("--pose", options.pose, "Describe this pose instead");
	app.add_option("--csv", options.csv, "File for the rows");
	cli::addJson(app, options.common);
	cli::addSeed(app, options.common);
	app.footer("Example: clod-oracle --family wedges-crossed --poses 1000 --setting exact");
	app.callback([&options] { oracle::run(options); });
	return cli::runProgram(app, argc, argv);
}
