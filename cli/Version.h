// SPDX-License-Identifier: Zlib
// What --version prints, and what reports name as the program that made them.
#pragma once
#include <string>

namespace clod::cli
{
std::string gitHash();
std::string compilerName();  // and its version
// Several lines: program, version, commit, compiler, build type, precision (of whatever Bullet the program has),
// kernels in use on this machine, version of the files it reads and writes, licence.
std::string versionText(const std::string& program, const std::string& precision, const std::string& licence);
}  // namespace clod::cli
