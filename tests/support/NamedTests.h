// SPDX-License-Identifier: GPL-3.0-or-later
// What tests of each scene or model call themselves: GTest takes no hyphens.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace clod::test
{
inline std::string nameOfTest(const testing::TestParamInfo<std::string>& info)
{
	std::string name = info.param;
	std::replace(name.begin(), name.end(), '-', '_');
	return name;
}
}  // namespace clod::test
