// SPDX-License-Identifier: Zlib
#include "cli/Version.h"

#include <fmt/format.h>

#include "GitVersion.h"
#include "clod/Version.h"
#include "clod/collide/InstructionSets.h"
#include "clod/hierarchy/PackedFile.h"

#define CLOD_TEXT(number) #number
#define CLOD_JOINED(major, minor, patch) CLOD_TEXT(major) "." CLOD_TEXT(minor) "." CLOD_TEXT(patch)
#define CLOD_VERSION CLOD_JOINED(CLOD_VERSION_MAJOR, CLOD_VERSION_MINOR, CLOD_VERSION_PATCH)

namespace clod::cli
{
std::string gitHash()
{
	return CLOD_GIT_HASH;
}

std::string compilerName()
{
#ifdef __clang__
	return __VERSION__;  // with its name
#else
	return "GCC " __VERSION__;
#endif
}

std::string versionText(const std::string& program, const std::string& precision, const std::string& licence)
{
	return fmt::format("{} {} (commit {})\ncompiler {}, {}\nprecision {}; kernels {}; file format {}\n{}", program,
					   CLOD_VERSION, CLOD_GIT_HASH, compilerName(), CLOD_BUILD_TYPE, precision,
					   hasWideInstructions() ? "AVX2" : "plain (no AVX2)", kPackedVersion, licence);
}
}  // namespace clod::cli
