// SPDX-License-Identifier: Zlib
// The subcommands of clod-bench. Each adds itself to the program; what it does runs as CLI11's callback and ends with
// cli::Failure where it fails.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "cli/Program.h"
#include "demos/models/Models.h"
#include "demos/runner/HierarchyCache.h"

namespace CLI
{
class App;
class Validator;
}  // namespace CLI

namespace clod::demo
{
void addModelCommand(CLI::App& program);
void addListCommand(CLI::App& program);
void addRunCommand(CLI::App& program);
void addReplayCommand(CLI::App& program);
void addPaperCommand(CLI::App& program);
void addTradeoffCommand(CLI::App& program);
void addIdleCommand(CLI::App& program);
void addBudgetCommand(CLI::App& program);
void addScalingCommand(CLI::App& program);
void addLevelsCommand(CLI::App& program);
void addTryCommand(CLI::App& program);
void addExtremesCommand(CLI::App& program);

// --cache-dir and --no-cache.
void addCache(CLI::App& command, CacheOptions& options);

// --resolution.
void addResolution(CLI::App& command, double& share);

// A finite number in [low, high]; unlike CLI::Range, it refuses "nan".
CLI::Validator between(double low, double high);

// A mesh as its OBJ file would hold it; of a benchmark model, 0 triangles are the paper's count.
MeshSource meshSource(const std::string& name, const ModelMesh& mesh);
MeshSource modelSource(const std::string& name, std::size_t triangles);

// The first fields of every report: schema, program, command, machine.
nlohmann::ordered_json startReport(const std::string& command);
// Name, triangles, patches, radius, bytes and hash of a hierarchy.
nlohmann::ordered_json describeHierarchy(const Hierarchy& hierarchy, const std::string& name);

// Throw cli::Failure (1) when the file cannot be written; do nothing for an empty path; "-" is stdout.
void writeReport(const std::string& path, const nlohmann::ordered_json& report);
void makeDirectory(const std::string& path);  // and those above it
void writeText(const std::string& path, const std::string& text);
}  // namespace clod::demo
