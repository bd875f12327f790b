// SPDX-License-Identifier: GPL-3.0-or-later
// A machine that has less memory than a file, or what it claims, asks for: that is told of and not thrown. The largest piece that
// may be allocated is limited.
#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <vector>

#include "clod/hierarchy/HierarchyFormat.h"
#include "clod/hierarchy/PackedFile.h"
#include "clod/hierarchy/ScaledHierarchy.h"
#include "tests/query/Bodies.h"
#include "tests/support/Files.h"
#include "tests/support/HierarchyContents.h"

namespace
{
std::atomic<std::size_t> most{std::numeric_limits<std::size_t>::max()};

void* allocate(std::size_t size)
{
	return size > most ? nullptr : std::malloc(size ? size : 1);
}
void release(void* p)
{
	std::free(p);
}
}  // namespace

#include "tests/support/ReplacedNew.h"

namespace clod::test
{
namespace
{
using Bytes = std::vector<std::byte>;

struct Limited
{
	explicit Limited(std::size_t bytes) { most = bytes; }
	~Limited() { most = std::numeric_limits<std::size_t>::max(); }
};
const Hierarchy& torus()
{
	return *body("torus", 900).hierarchy;
}
}  // namespace

TEST(HierarchyMemory, ThatIsNotEnoughForAFileIsToldOf)
{
	const TemporaryFolder folder;
	const Bytes block = torus().bytes();
	for (const Bytes& stored : {block, pack(block)})
	{
		const std::string file = folder.fileOf("torus.clod", stored);
		for (const std::uint32_t finest : {0u, 1u})
			for (const std::size_t limit : {stored.size() / 2, std::size_t(10000)})
			{
				const Limited limited(limit);
				const auto loaded = Hierarchy::load(file, finest);
				EXPECT_NE(loaded.error().find("memory"), std::string::npos) << limit << ", from " << finest << ": " << loaded.error();
			}
		Bytes given = stored;
		if (stored == block) continue;  // it is taken as it is
		const Limited limited(10000);
		EXPECT_NE(Hierarchy::fromBytes(std::move(given)).error().find("memory"), std::string::npos);
	}
	const Limited limited(10000);
	EXPECT_NE(scaledHierarchy(torus(), {1, 2, 1}).error().find("memory"), std::string::npos);
}

// Of coarse levels nothing tells how many triangles there were.
TEST(HierarchyMemory, CoarseLevelsTakeWhatTheyHold)
{
	HierarchyContent content = contentOf(torus());
	content.asset.triangleCount = kNone;
	const TemporaryFolder folder;
	const std::string file = folder.fileOf("torus.clod", encode(content));
	const Limited limited(10 * torus().bytes().size());
	const auto loaded = Hierarchy::load(file, 1);
	EXPECT_TRUE(loaded) << loaded.error();
}
}  // namespace clod::test
