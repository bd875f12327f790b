// SPDX-License-Identifier: GPL-3.0-or-later
// The README's example runs, and refuses what is not there.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/bullet/PatchHierarchy.h"
#include "tests/support/Files.h"

namespace clod::test
{
namespace
{
struct Output
{
	int status = -1;
	std::string text;
};

Output run(const std::string& command)
{
	Output output;
	FILE* pipe = popen((command + " 2>&1").c_str(), "r");
	std::array<char, 256> line;
	while (pipe && std::fgets(line.data(), int(line.size()), pipe)) output.text += line.data();
	output.status = pipe ? pclose(pipe) : -1;
	return output;
}
}  // namespace

TEST(Example, TwoModelsComeToRestOnEachOther)
{
	const TemporaryFolder folder;
	const auto model = patchHierarchy(boxMesh({0.04, 0.02, 0.03}, {8, 4, 6}, 2));
	const Output output = run(CLOD_EXAMPLE " " + folder.fileOf("model.clod", model->bytes()));
	EXPECT_EQ(output.status, 0) << output.text;
	// The radius is 1, so half the height is 0.01 / 0.02693 = 0.371 of it; contacts rest 0.0005 apart.
	EXPECT_NE(output.text.find("step 480: heights  0.372  1.115"), std::string::npos) << output.text;
}

TEST(Example, AMissingFileIsAnError)
{
	const Output output = run(CLOD_EXAMPLE " /nonexistent/model.clod");
	EXPECT_NE(output.status, 0);
	EXPECT_NE(output.text.find("/nonexistent/model.clod"), std::string::npos) << output.text;
}
}  // namespace clod::test
