// SPDX-License-Identifier: Zlib
#include "cli/Version.h"

#include <fmt/format.h>

#include "GitVersion.h"

namespace clod::cli
{
std::string gitHash()
{
	return CLOD_GIT_HASH;
}

std::string versionText(const std::string& program, const std::string& licence)
{
	return fmt::format("{} {} (commit {})\ncompiler {}, {}\n{}", program, CLOD_VERSION, CLOD_GIT_HASH, __VERSION__,
					   CLOD_BUILD_TYPE, licence);
}
}  // namespace clod::cli
