// SPDX-License-Identifier: GPL-3.0-or-later
// clod-build parts MESH: the named parts of a glTF scene, each of which can be built by itself.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "builder/assemble/BoundingSphere.h"
#include "builder/cli/Commands.h"
#include "builder/intake/ReadMesh.h"
#include "cli/MeshPath.h"
#include "cli/Program.h"

namespace clod::builder
{
namespace
{
using cli::ExitCode;
using cli::Failure;

struct PartsOptions : cli::CommonOptions
{
	std::string mesh;
};

// Of the coordinates that are numbers.
Sphere sphereOf(const Soup& part)
{
	std::vector<Vec3> points;
	for (const Vec3& v : part.vertices)
		if (isFinite(v)) points.push_back(v);
	return points.empty() ? Sphere() : boundingSphere(points);
}

void run(const PartsOptions& options)
{
	const Soup scene = readParts(options.mesh);
	nlohmann::ordered_json report = {{"schema", 1}, {"parts", nlohmann::ordered_json::array()}};
	if (options.textOnStdout()) fmt::print("{:>9} {:>11}  {:<40} part\n", "faces", "radius", "centre");
	for (const Part& part : scene.parts)
	{
		const Soup piece = partOf(scene, part.name);
		const Sphere ball = sphereOf(piece);
		report["parts"].push_back({{"name", part.name},
								   {"faces", piece.polygonCount()},
								   {"radius", ball.radius},
								   {"center", {ball.center.x, ball.center.y, ball.center.z}}});
		if (options.textOnStdout())
			fmt::print("{:>9} {:>11.4g}  {:<40} {}\n", piece.polygonCount(), ball.radius, placeOf(ball.center),
					   part.name);
	}
	if (!options.json.empty()) writeReport(options.json, report);
	if (options.textOnStdout())
		fmt::print("One of them:  clod-build build {} -o {}.clod\nEach of them: clod-build build {} --parts -o {}\n",
				   cli::shellWord(options.mesh + "#" + scene.parts[0].name), scene.parts[0].name,
				   cli::shellWord(options.mesh), cli::shellWord(cli::nameOf({options.mesh, {}})));
}
}  // namespace

Soup readParts(const std::string& path)
{
	try
	{
		Soup soup = readMesh(path);
		if (!soup.parts.empty()) return soup;
	}
	catch (const Refused& refused)
	{
		throw Failure(ExitCode::badInput, path + ": " + refused.what());
	}
	throw Failure(ExitCode::badInput,
				  fmt::format("{}: it names no parts, only glTF scenes do\n  Try: clod-build build {} -o {}.clod", path,
							  cli::shellWord(path), cli::shellWord(cli::nameOf({path, {}}))));
}

void addPartsCommand(CLI::App& program)
{
	const auto options = std::make_shared<PartsOptions>();
	CLI::App& command = *program.add_subcommand("parts", "List the named parts of a glTF scene");
	command.add_option("mesh", options->mesh, "The .gltf or .glb file")->required()->type_name("MESH");
	cli::addJson(command, *options);
	cli::addQuiet(command, *options);
	command.footer("Example: clod-build parts engine.glb");
	command.callback([options] { run(*options); });
}
}  // namespace clod::builder
