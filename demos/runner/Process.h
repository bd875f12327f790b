// SPDX-License-Identifier: Zlib
// Other programs run as children of this one.
#pragma once
#include <string>
#include <vector>

namespace clod::demo
{
inline constexpr int kProgramMissing = 127;

// Runs words[0] (a path, or a name looked up in PATH) and waits. Its stdout goes to our stderr, since ours is for
// results, or nowhere when quiet; should we die, it is told. Value: its exit code, kProgramMissing, or minus the signal
// that ended it.
int runProgram(const std::vector<std::string>& words, bool quiet = false);
}  // namespace clod::demo
