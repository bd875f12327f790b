// SPDX-License-Identifier: Zlib
// Counts as text: "1 level", "2 levels".
#pragma once
#include <fmt/format.h>

#include <cstddef>
#include <string>

namespace clod::cli
{
inline std::string counted(std::size_t count, const char* what)
{
	return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}
}  // namespace clod::cli
