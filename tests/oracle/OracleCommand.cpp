// SPDX-License-Identifier: GPL-3.0-or-later
// clod-oracle: the motion oracle over families of poses.
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cstdio>

#include "cli/Files.h"
#include "cli/Program.h"
#include "tests/oracle/BulletSubject.h"
#include "tests/oracle/Report.h"
#include "tests/fixtures/Recipes.h"
#include "tests/support/HierarchyContents.h"

namespace clod::oracle
{
namespace
{
struct Options
{
	cli::CommonOptions common;
	std::string family = "all", setting = "exact", csv, hierarchies;
	std::size_t poses = 300;
	int samples = 48;
	std::optional<std::size_t> pose;
};

void checked(const std::string& error)
{
	if (!error.empty()) throw cli::Failure(cli::ExitCode::failure, error);
}

// The file of a mesh's hierarchy, named by its content (FNV-1a); empty without a folder.
std::string fileOf(const TriangleMesh& mesh, const std::string& folder)
{
	if (folder.empty()) return {};
	std::uint64_t hash = 14695981039346656037u;
	const auto add = [&hash](const void* data, std::size_t size)
	{
		const auto* bytes = static_cast<const unsigned char*>(data);
		for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 1099511628211u;
	};
	add(mesh.vertices.data(), mesh.vertices.size() * sizeof mesh.vertices[0]);
	add(mesh.triangles.data(), mesh.triangles.size() * sizeof mesh.triangles[0]);
	return fmt::format("{}/{:016x}.clod", folder, hash);
}

HierarchyPointer built(const TriangleMesh& mesh, const std::string& folder)
{
	const std::string file = fileOf(mesh, folder);
	if (!file.empty())
		if (auto loaded = Hierarchy::load(file)) return loaded.value();
	builder::Mesh input;
	input.vertices = mesh.vertices;
	input.triangles = mesh.triangles;
	const HierarchyPointer hierarchy = test::loaded(test::built(input));
	if (!file.empty()) checked(cli::writeFile(file, hierarchy->bytes()));
	return hierarchy;
}

MakeSubject subjectOf(const Options& options)
{
	const std::string &setting = options.setting, folder = options.hierarchies;
	if (setting == "gimpact") return [](const BodyPair& pair) { return gimpactSubject(pair.a, pair.b); };
	ContactMetric metric = ContactMetric::exactly();
	if (setting == "default") metric = Context().worldMetric;
	if (setting == "3.5%") metric = ContactMetric::deviationShare(0.035);
	return [metric, folder](const BodyPair& pair)
	{ return clodSubject(built(pair.a, folder), built(pair.b, folder), metric); };
}

void runPose(const Family& family, const Options& options, const TrialRules& rules)
{
	const std::optional<Trial> trial = FamilyTrials(family, subjectOf(options), rules).run(*options.pose);
	fmt::print("{} pose {}: {}", family.name, *options.pose, trial ? described(*trial) : "the bodies do not meet\n");
}

void run(const Options& options)
{
	if (options.pose && !(options.csv + options.common.json).empty())
		throw cli::Failure(cli::ExitCode::usage, "--pose describes one pose on stdout: --csv and --json are of families");
	cli::requireWritable({options.csv, options.common.json});
	const bool printsRows = options.csv == "-", printsTable = options.common.textOnStdout() && !printsRows;
	TrialRules rules;
	rules.seed = options.common.seed;
	rules.judge.samples = options.samples;
	nlohmann::ordered_json rows = nlohmann::ordered_json::array();
	if (!options.pose && printsTable) fmt::print("{}", tableHead());
	for (const Family& family : families())
	{
		if (options.family != "all" && options.family != family.name) continue;
		if (options.pose)
		{
			runPose(family, options, rules);
			continue;
		}
		FamilyResult result = FamilyTrials(family, subjectOf(options), rules).runAll(options.poses);
		if (printsTable) fmt::print("{}", tableLine(result));
		std::fflush(stdout);
		for (const auto& row : rowsOf(result, options.setting)) rows.push_back(row);
		if (!options.csv.empty() && !printsRows) checked(cli::writeFile(options.csv, csvOf(rows)));  // so far: a run may take hours
	}
	if (printsRows) fmt::print("{}", csvOf(rows));
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
	cli::setUpProgram(app, sizeof(btScalar) == sizeof(float) ? "single (Bullet)" : "double (Bullet)",
					  "licence GPL-3.0-or-later");
	app.require_subcommand(0);
	cli::addChoice(app, "--family", options.family, names, "Family of poses");
	cli::addChoice(app, "--setting", options.setting, {"exact", "default", "3.5%", "gimpact"},
				   "Contact levels, or Bullet's GImpact");
	app.add_option("--poses", options.poses, "Poses a family")
		->type_name("N")
		->check(CLI::Range(std::size_t(1), std::size_t(100'000'000)))
		->capture_default_str();
	app.add_option("--samples", options.samples, "Motions a pose and cone")
		->type_name("N")
		->check(CLI::Range(1, 1'000'000))
		->capture_default_str();
	app.add_option("--pose", options.pose, "Describe this pose instead")->type_name("INDEX");
	app.add_option("--hierarchies", options.hierarchies, "Folder that keeps the bodies' hierarchies from run to run")
		->check(CLI::ExistingDirectory)
		->type_name("DIR");
	app.add_option("--csv", options.csv, "File for the rows; - is stdout")->type_name("FILE");
	cli::addJson(app, options.common);
	cli::addSeed(app, options.common);
	app.footer("Example: clod-oracle --family wedges-crossed --poses 1000 --setting exact");
	app.callback([&options] { oracle::run(options); });
	return cli::runProgram(app, argc, argv);
}
