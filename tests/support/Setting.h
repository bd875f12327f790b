// SPDX-License-Identifier: GPL-3.0-or-later
// CLOD_... variables lengthen random tests: nightly ones are those of every change with more starts.
#pragma once
#include <cstdlib>

namespace clod::test
{
inline int setting(const char* name, int standard)
{
	const char* text = std::getenv(name);
	return text ? std::atoi(text) : standard;
}
}  // namespace clod::test
