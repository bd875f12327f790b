// SPDX-License-Identifier: GPL-3.0-or-later
// A builder configured without repair says so instead of building something else.
#include <gtest/gtest.h>

#include "builder/repair/Repair.h"

namespace clod::test
{
namespace
{
template <class Step>
std::string sentenceOf(const Step& step)
{
	try
	{
		step();
	}
	catch (const std::runtime_error& error)
	{
		return error.what();
	}
	return "";
}

TEST(RepairAbsent, NamesTheOptionThatBringsItBack)
{
	const builder::Soup soup;
	for (const std::string& sentence :
		 {sentenceOf([&] { builder::repair(soup, 1); }), sentenceOf([&] { builder::wrapAround(soup, 1); })})
		EXPECT_NE(sentence.find("CLOD_BUILD_REPAIR=ON"), std::string::npos) << sentence;
}
}  // namespace
}  // namespace clod::test
