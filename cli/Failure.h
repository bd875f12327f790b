// SPDX-License-Identifier: Zlib
// How a program ends: exit codes, and the exception that carries one with its sentence.
#pragma once
#include <stdexcept>
#include <string>

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
}  // namespace clod::cli
