// SPDX-License-Identifier: Zlib
// The frame of a command-line program: exit codes, parsing with the nearest match on errors, common options,
// interruption. Results go to stdout or a named file; progress, warnings and errors go to stderr.
#pragma once
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "cli/Failure.h"

namespace CLI
{
class App;
class Option;
class Validator;
}  // namespace CLI

namespace clod::cli
{
// Options most commands share. A command adds those it understands.
struct CommonOptions
{
	bool quiet = false;
	std::string
		json;  // file for the machine-readable report; "-" = stdout, which then carries nothing else; empty = none
	std::uint64_t seed = 1;
	unsigned threads = 0;  // 0 = all cores
	bool textOnStdout() const { return json != "-"; }
};
void addQuiet(CLI::App& command, CommonOptions& options);
void addJson(CLI::App& command, CommonOptions& options);
void addSeed(CLI::App& command, CommonOptions& options,
			 const std::string& description = "Seed of everything random");
void addThreads(CLI::App& command, CommonOptions& options);
// -o, which must be given and not be empty: what it names is made after minutes, or is a folder to create.
void addOutput(CLI::App& command, std::string& path, const std::string& type, const std::string& description);
// The same of a command that writes several files.
void addFolder(CLI::App& command, std::string& folder, const std::string& files);

// Before minutes are spent on what could not be written: throws Failure for the first of these files that cannot be
// (1), and where two of them are one, or one is what the command reads (2). An empty name is no file.
void requireWritable(std::initializer_list<std::string> files, const std::vector<std::string>& inputs = {});

// One of `choices`; anything else is a usage error naming the nearest one.
CLI::Validator oneOf(const std::vector<std::string>& choices);
// An option that takes one of them.
CLI::Option* addChoice(CLI::App& command, const std::string& name, std::string& value,
					   const std::vector<std::string>& choices, const std::string& description);

// Adds --version (see Version.h) and requires one subcommand. `licence` is one sentence.
void setUpProgram(CLI::App& app, const std::string& precision, const std::string& licence);

// Parses, runs the callbacks of the chosen subcommand, and maps every outcome to an exit code. SIGINT, SIGTERM,
// SIGQUIT, SIGXCPU and SIGHUP (unless it is ignored) end the program with 130 after removing the partial files of
// Files.h.
int runProgram(CLI::App& app, int argc, char** argv);
}  // namespace clod::cli
