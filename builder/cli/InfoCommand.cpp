// SPDX-License-Identifier: GPL-3.0-or-later
// clod-build info FILE, and what commands share.
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "builder/cli/Commands.h"
#include "builder/cli/PieceCounts.h"
#include "cli/Counted.h"
#include "cli/Files.h"
#include "cli/MeshPath.h"
#include "cli/Program.h"

namespace clod::builder
{
namespace
{
using cli::counted;
using cli::ExitCode;
using cli::Failure;

struct InfoOptions : cli::CommonOptions
{
	std::string file;
};

bool isContactLevel(const Level& level)
{
	return (level.flags & kClodNode) != 0;
}

std::size_t contactLevelCount(const Hierarchy& hierarchy)
{
	return std::size_t(std::count_if(hierarchy.levels().begin(), hierarchy.levels().end(), isContactLevel));
}

// What the records of some nodes take in memory.
struct Bytes
{
	std::size_t nodes = 0, boxes = 0, children = 0, faces = 0, vertices = 0;
	std::size_t sum() const { return nodes + boxes + children + faces + vertices; }
};

Bytes bytesOf(const Hierarchy& hierarchy, std::uint32_t firstNode, std::uint32_t nodeCount)
{
	Bytes bytes;
	for (std::uint32_t i = firstNode; i < firstNode + nodeCount; ++i)
	{
		const Node& node = hierarchy.node(i);
		bytes.nodes += sizeof(Node);
		bytes.boxes += sizeof(OrientedBox);
		bytes.children += node.childCount * sizeof(std::uint32_t);
		bytes.faces += node.faceCount * sizeof(Face);
		bytes.vertices += 3 * hierarchy.hull(node).padded * sizeof(float);
	}
	return bytes;
}

nlohmann::ordered_json describeLevel(const Hierarchy& hierarchy, std::size_t index)
{
	const Level& level = hierarchy.levels()[index];
	return {{"level", index},
			{"triangles", level.faceCount},
			{"patches", level.nodeCount},
			{"max_h", level.maxHausdorff},
			{"max_s", level.maxDeviation},
			{"max_cover", level.maxCover},
			{"max_protrude", level.maxProtrude},
			{"max_surf", level.maxSurf},
			{"patch_tolerance", level.patchTolerance},
			{"bytes", bytesOf(hierarchy, level.firstNode, level.nodeCount).sum()},
			{"clod", isContactLevel(level)}};
}

void run(const InfoOptions& options)
{
	cli::requireWritable({options.json}, {options.file});
	const auto hierarchy = loadHierarchy(options.file);
	const std::uint64_t fileBytes = std::filesystem::file_size(options.file);
	if (!options.json.empty()) writeReport(options.json, describe(*hierarchy, fileBytes, -1));
	if (options.textOnStdout()) fmt::print("{}", describeAsText(*hierarchy, fileBytes));
}
}  // namespace

void addFileFrame(CLI::App& command, FileFrame& frame, CLI::Option* file)
{
	CLI::Option* const unit = cli::addChoice(command, "--unit", frame.unit, unitNames(),
											 "The file's unit of length; the hierarchy is then in metres [as it is]");
	CLI::Option* const up =
		cli::addChoice(command, "--up", frame.up, upNames(), "The file's axis that points up; it becomes y [y]");
	const auto positive = [](std::string& text) -> std::string
	{
		double value = 0;
		const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
		const bool good = error == std::errc() && end == text.data() + text.size() && std::isfinite(value) && value > 0;
		return good ? std::string() : "'" + text + "' is not a positive number";
	};
	CLI::Option* const scale = command.add_option("--scale", frame.scale, "All lengths of the file times this");
	scale->check(CLI::Validator(positive, "", "positive"))->type_name("FACTOR");
	for (CLI::Option* const option : {unit, up, scale})
		if (file) option->needs(file);
}

std::shared_ptr<const Hierarchy> loadHierarchy(const std::string& path)
{
	const auto hierarchy = Hierarchy::load(path);
	if (hierarchy) return hierarchy.value();
	std::string told = hierarchy.error();
	std::filesystem::path built = path;
	built.replace_extension(".clod");
	std::error_code error;
	if (built != path && std::filesystem::is_regular_file(path, error))
		told += fmt::format("\n  Try: clod-build build {} -o {}", cli::shellWord(path), cli::shellWord(built.string()));
	throw Failure(ExitCode::badInput, told);
}

void writeReport(const std::string& path, const nlohmann::ordered_json& report)
{
	const std::string error = cli::writeJson(path, report);
	if (!error.empty()) throw Failure(ExitCode::failure, error);
}

nlohmann::ordered_json describe(const Hierarchy& hierarchy, std::uint64_t fileBytes, double buildSeconds)
{
	const Asset& a = hierarchy.asset();
	nlohmann::ordered_json report = {{"schema", 1}, {"triangles", a.triangleCount}};
	report["levels"] = nlohmann::ordered_json::array();
	for (std::size_t i = 0; i < hierarchy.levels().size; ++i) report["levels"].push_back(describeLevel(hierarchy, i));
	report["clods"] = contactLevelCount(hierarchy);
	report["lods"] = hierarchy.levels().size;
	report["pieces_within"] = nlohmann::ordered_json::array();
	for (const PieceCount& count : pieceCounts(hierarchy))
		report["pieces_within"].push_back(
			{{"error", count.error}, {"level", count.level}, {"pieces", count.pieces}, {"mixed_levels", count.mixed}});
	const Bytes parts = bytesOf(hierarchy, 0, std::uint32_t(hierarchy.nodes().size));
	report["bytes"] = fileBytes;
	report["bytes_per_triangle"] = double(fileBytes) / double(a.triangleCount);
	report["memory_bytes"] = hierarchy.bytes().size();
	report["bytes_by_part"] = {{"nodes", parts.nodes},
							   {"culling_boxes", parts.boxes},
							   {"children", parts.children},
							   {"faces", parts.faces},
							   {"hull_vertices", parts.vertices},
							   {"header_levels_asset", hierarchy.bytes().size() - parts.sum()}};
	report["volume"] = a.volume;
	report["center_of_mass"] = {a.meshFromBody[0], a.meshFromBody[1], a.meshFromBody[2]};
	const double* const m = a.inertia;
	report["inertia"] = {{m[0], m[3], m[4]}, {m[3], m[1], m[5]}, {m[4], m[5], m[2]}};
	report["build_seconds"] = buildSeconds < 0 ? nlohmann::ordered_json() : nlohmann::ordered_json(buildSeconds);
	report["radius"] = a.radius;
	report["thinnest_wall"] = a.thinnestWall;
	report["components"] = a.componentCount;
	report["nodes"] = hierarchy.nodes().size;
	report["paper"] = hierarchy.isPaperBuild();
	report["content_hash"] = fmt::format("{:016x}", hierarchy.contentHash());
	return report;
}

std::string describeAsText(const Hierarchy& hierarchy, std::uint64_t fileBytes)
{
	const Asset& a = hierarchy.asset();
	std::string text = fmt::format("{:>5} {:>10} {:>9} {:>11} {:>11} {:>11} {:>11}  {}\n", "level", "triangles",
								   "patches", "max h", "max s", "max cover", "protrude", "contact");
	for (std::size_t i = 0; i < hierarchy.levels().size; ++i)
	{
		const Level& level = hierarchy.levels()[i];
		text += fmt::format("{:>5} {:>10} {:>9} {:>11.4g} {:>11.4g} {:>11.4g} {:>11.4g}  {}\n", i, level.faceCount,
							level.nodeCount, level.maxHausdorff, level.maxDeviation, level.maxCover, level.maxProtrude,
							isContactLevel(level) ? "yes" : "no");
	}
	text += fmt::format("{}, {} of them for contact; {} triangles, {}, {} bytes{}\n", counted(hierarchy.levels().size, "level"),
						contactLevelCount(hierarchy), a.triangleCount, counted(hierarchy.nodes().size, "node"), fileBytes,
						hierarchy.isPaperBuild() ? "; built with --paper" : "");
	const Bytes parts = bytesOf(hierarchy, 0, std::uint32_t(hierarchy.nodes().size));
	text += "convex pieces for a certified share of the radius (levels mixed):";
	for (const PieceCount& count : pieceCounts(hierarchy))
		text += fmt::format(" {:g} %: {} ({})", 100 * count.error, count.pieces, count.mixed) +
				(count.error < kErrorShares.back() ? "," : "\n");
	const auto each = [&a](std::size_t bytes) { return double(bytes) / double(a.triangleCount); };
	text += fmt::format(
		"bytes a triangle: {:.1f}; in memory {:.1f} = nodes {:.1f} + culling boxes {:.1f} + children {:.1f} + faces {:.1f} + "
		"hull vertices {:.1f} + rest\n",
		each(fileBytes), each(hierarchy.bytes().size()), each(parts.nodes), each(parts.boxes), each(parts.children),
		each(parts.faces),
		each(parts.vertices));
	text += fmt::format("radius {:.6g}, volume {:.6g}, centre of mass ({:.6g}, {:.6g}, {:.6g}), thinnest wall {:.4g}\n",
						a.radius, a.volume, a.meshFromBody[0], a.meshFromBody[1], a.meshFromBody[2], a.thinnestWall);
	return text;
}

void addInfoCommand(CLI::App& program)
{
	const auto options = std::make_shared<InfoOptions>();
	CLI::App& command = *program.add_subcommand("info", "Show the levels and totals of a .clod file");
	command.add_option("file", options->file, "The .clod file")->required()->type_name("FILE");
	cli::addJson(command, *options);
	cli::addQuiet(command, *options);
	command.footer("Example: clod-build info cup.clod --json -");
	command.callback([options] { run(*options); });
}
}  // namespace clod::builder
