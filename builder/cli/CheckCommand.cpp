// SPDX-License-Identifier: GPL-3.0-or-later
// clod-build check FILE [--mesh MESH]
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <fmt/format.h>

#include "builder/check/Check.h"
#include "builder/cli/Commands.h"
#include "builder/intake/ReadMesh.h"
#include "cli/MeshPath.h"
#include "cli/Program.h"
#include "cli/Progress.h"

namespace clod::builder
{
namespace
{
using cli::ExitCode;
using cli::Failure;

struct CheckOptions : cli::CommonOptions
{
	std::string file, mesh;
	FileFrame frame;
};

// The mesh as the reader of the builder sees it: only the syntax is trusted, the geometry is compared.
check::GivenMesh readGiven(const std::string& path, const FileFrame& frame)
{
	try
	{
		Soup soup = readMesh(path);
		convert(frame, soup);
		check::GivenMesh given;
		given.vertices = soup.vertices;
		for (std::size_t p = 0; p < soup.polygonCount(); ++p)
			given.polygons.emplace_back(soup.corners.begin() + std::ptrdiff_t(soup.polygonBegin(p)),
										soup.corners.begin() + std::ptrdiff_t(soup.polygonEnd[p]));
		return given;
	}
	catch (const Refused& refused)
	{
		throw Failure(ExitCode::badInput, path + ": " + refused.what());
	}
}

nlohmann::ordered_json describeAll(const std::vector<check::Invariant>& invariants)
{
	nlohmann::ordered_json report = {{"schema", 1}};
	report["invariants"] = nlohmann::ordered_json::array();
	for (const check::Invariant& i : invariants)
	{
		nlohmann::ordered_json entry = {{"name", i.name},
										{"checked", i.checked},
										{"violations", i.violations},
										{"worst", i.worst},
										{"undecided", i.undecided}};
		if (i.violations > 0) entry["first_violation"] = i.firstViolation;
		report["invariants"].push_back(entry);
	}
	return report;
}

void run(const CheckOptions& options)
{
	cli::requireWritable({options.json}, {options.file, cli::meshPath(options.mesh).file});
	const auto hierarchy = loadHierarchy(options.file);
	check::Options settings;
	settings.threads = options.threads;
	cli::Progress bar(options.quiet);
	settings.progress = [&bar](const std::string& name, double fraction) { bar.update(name, fraction); };
	check::GivenMesh given;
	if (!options.mesh.empty())
	{
		given = readGiven(options.mesh, options.frame);
		settings.given = &given;
	}
	const std::vector<check::Invariant> invariants = check::checkHierarchy(*hierarchy, settings);
	bar.finish();
	if (!options.json.empty()) writeReport(options.json, describeAll(invariants));
	for (const check::Invariant& i : invariants)
		if (options.textOnStdout())
			fmt::print("{} {:<20} {:>9} checked, {:>4} broken, {:>4} undecided, worst {:.4g}\n",
					   i.violations == 0 ? "ok  " : "FAIL", i.name, i.checked, i.violations, i.undecided, i.worst);
	for (const check::Invariant& i : invariants)
		if (i.violations > 0)
			throw Failure(ExitCode::verificationFailed,
						  fmt::format("{}: {}: {}", options.file, i.name, i.firstViolation));
}
}  // namespace

void addCheckCommand(CLI::App& program)
{
	const auto options = std::make_shared<CheckOptions>();
	CLI::App& command =
		*program.add_subcommand("check", "Re-prove every invariant of a .clod file with code of its own");
	command.add_option("file", options->file, "The .clod file")->required()->type_name("FILE");
	CLI::Option* const mesh =
		command.add_option("--mesh", options->mesh, "The mesh it was built from: level 0 must equal it");
	mesh->type_name("MESH");
	addFileFrame(command, options->frame, mesh);
	cli::addThreads(command, *options);
	cli::addJson(command, *options);
	cli::addQuiet(command, *options);
	command.footer("Example: clod-build check cup.clod --mesh cup.obj");
	command.callback([options] { run(*options); });
}
}  // namespace clod::builder
