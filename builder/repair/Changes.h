// SPDX-License-Identifier: GPL-3.0-or-later
// What a repair did, a sentence each, in the order it was done.
#pragma once
#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <vector>

namespace clod::builder
{
using Changes = std::vector<std::string>;

// "1 hole", "2 holes".
inline std::string counted(std::size_t count, const char* one, const char* more)
{
	return fmt::format("{} {}", count, count == 1 ? one : more);
}
}  // namespace clod::builder
