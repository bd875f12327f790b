// SPDX-License-Identifier: GPL-3.0-or-later
// The subcommands of clod-build. Each adds itself to the program and keeps its options alive in the callback.
#pragma once
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include <clod/hierarchy/Hierarchy.h>

#include "builder/intake/FileFrame.h"

namespace CLI
{
class App;
class Option;
}  // namespace CLI

namespace clod::builder
{
void addBuildCommand(CLI::App& program);
void addInfoCommand(CLI::App& program);
void addCheckCommand(CLI::App& program);
void addExportCommand(CLI::App& program);
void addPartsCommand(CLI::App& program);

// --unit, --up and --scale: how a mesh file is to be read; they make sense with `file` alone, where that is an option.
void addFileFrame(CLI::App& command, FileFrame& frame, CLI::Option* file = nullptr);

// A glTF scene of at least one part; anything else ends the program with the exit code for bad input.
Soup readParts(const std::string& path);

// Loads and validates a .clod file; a refusal ends the program with the exit code for bad input.
std::shared_ptr<const Hierarchy> loadHierarchy(const std::string& path);

// What `info` knows: the report, and the same as text. buildSeconds < 0: not known (files do not carry it, so that
// every run writes the same bytes).
nlohmann::ordered_json describe(const Hierarchy& hierarchy, std::uint64_t fileBytes, double buildSeconds);
std::string describeAsText(const Hierarchy& hierarchy, std::uint64_t fileBytes);

// Writes a report and ends the program with a failure where that is impossible.
void writeReport(const std::string& path, const nlohmann::ordered_json& report);
}  // namespace clod::builder
