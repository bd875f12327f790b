// SPDX-License-Identifier: Zlib
// The frame of a command-line program: exit codes, parsing with the nearest match on errors, common options,
// interruption. Results go to stdout or a named file; progress, warnings and errors go to stderr.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "demos/cli/Files.h"

namespace clod::cli
{
enum class ExitCode : int
{
	ok = 0,
	failure = 1,
	usage = 2,
	badInput = 3,  // mesh or file, with the reason and the first offending element
	verificationFailed = 4,
	limitReached = 5,
	interrupted = 130
};

// Thrown by a command to end the program with this code and this sentence on stderr. Never leaves runProgram.
class Failure : public std::runtime_error
{
public:
	Failure(ExitCode code, const std::string& message) : std::runtime_error(message), m_code(code) {}
	ExitCode code() const { return m_code; }

private:
	ExitCode m_code;
};

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
void addSeed(CLI::App& command, CommonOptions& options);
void addThreads(CLI::App& command, CommonOptions& options);

// An option that takes one of `choices`; anything else is a usage error naming the nearest one.
CLI::Option* addChoice(CLI::App& command, const std::string& name, std::string& value,
					   const std::vector<std::string>& choices, const std::string& description);

// Adds --version (see Version.h) and requires one subcommand. `licence` is one sentence.
void setUpProgram(CLI::App& app, const std::string& licence);

// Parses, runs the callbacks of the chosen subcommand, and maps every outcome to an exit code. SIGINT and SIGTERM end
// the program with 130 after removing the partial files of Files.h.
int runProgram(CLI::App& app, int argc, char** argv);
}  // namespace clod::cli
