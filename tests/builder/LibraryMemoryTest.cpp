// SPDX-License-Identifier: GPL-3.0-or-later
// The library out of memory: an allocation fails anywhere within a build, alone or with all that follow. It says so,
// and builds the same afterwards.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "clod/builder/Builder.h"
#include "tests/support/Meshes.h"

namespace
{
constexpr long kNever = -1;
std::atomic<long> allocations{0}, firstFailing{kNever};
std::atomic<bool> keepsFailing{false};

bool fails()
{
	const long allocation = allocations++, first = firstFailing;
	return first != kNever && (keepsFailing ? allocation >= first : allocation == first);
}
void* allocate(std::size_t size)
{
	return fails() ? nullptr : std::malloc(size ? size : 1);
}
void release(void* p)
{
	std::free(p);
}
}  // namespace

#include "tests/support/ReplacedNew.h"

namespace clod::builder
{
namespace
{
TriangleMesh openBox()
{
	const Mesh box = test::boxMesh({1, 2, 3}, 2);
	TriangleMesh mesh{box.vertices, box.triangles};
	mesh.triangles.pop_back();
	return mesh;
}

class BuilderOutOfMemory : public testing::TestWithParam<unsigned>
{
protected:
	~BuilderOutOfMemory() override { firstFailing = kNever; }
	Outcome buildFailingAt(long place)
	{
		allocations = 0;
		firstFailing = place;
		Outcome outcome = build(m_mesh, m_options);
		firstFailing = kNever;
		return outcome;
	}
	void failAt(long places)
	{
		m_options.threads = GetParam();
		const Outcome before = buildFailingAt(kNever);
		const long all = allocations;
		ASSERT_EQ(before.status, Status::built) << before.message;
		ASSERT_GT(all, 2 * places);
		for (const bool keeps : {false, true})
		{
			keepsFailing = keeps;
			for (long place = 0; place < places; ++place)
			{
				// Not to the end: on several threads the number of allocations varies.
				const Outcome failed = buildFailingAt(place * (all * 9 / 10) / places);
				EXPECT_EQ(failed.status, Status::limit) << place << ": " << failed.message;
				EXPECT_EQ(failed.message, "out of memory");
				EXPECT_EQ(failed.hierarchy, nullptr);
			}
		}
		const Outcome after = buildFailingAt(kNever);
		ASSERT_EQ(after.status, Status::built) << after.message;
		EXPECT_EQ(after.hierarchy->bytes(), before.hierarchy->bytes());
	}

	TriangleMesh m_mesh = openBox();
	Options m_options;
};

TEST_P(BuilderOutOfMemory, WhileItRepairsAndBuilds)
{
	m_options.repair = true;
	failAt(40);
}

TEST_P(BuilderOutOfMemory, WhileItWraps)
{
	m_options.wrap = 4;
	failAt(10);
}

INSTANTIATE_TEST_SUITE_P(Threads, BuilderOutOfMemory, testing::Values(1u, 3u));
}  // namespace
}  // namespace clod::builder
