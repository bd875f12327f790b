// SPDX-License-Identifier: GPL-3.0-or-later
// A hash of the bits of numbers, one after the other (FNV's step).
#pragma once
#include <cstdint>
#include <cstring>

namespace clod::test
{
inline std::uint64_t mixed(std::uint64_t hash, double value)
{
	std::uint64_t bits;
	std::memcpy(&bits, &value, sizeof bits);
	return (hash ^ bits) * 0x100000001B3u;
}
}  // namespace clod::test
