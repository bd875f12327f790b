// SPDX-License-Identifier: GPL-3.0-or-later
// Programs under test, run as children with their output in files.
#pragma once
#include <sys/types.h>

#include <string>
#include <vector>

namespace clod::test
{
// Starts words[0] with stdout and stderr going to files.
pid_t startProgram(std::vector<std::string> words, const std::string& stdoutPath, const std::string& stderrPath);

inline constexpr int kTimedOut = -1000;
// Its exit code, minus the signal that ended it, or kTimedOut: then it was killed after `seconds`.
int waitForProgram(pid_t child, double seconds = 500);
}  // namespace clod::test
