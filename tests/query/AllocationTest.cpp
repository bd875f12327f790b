// SPDX-License-Identifier: GPL-3.0-or-later
// A steady query allocates nothing: operator new is counted.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/query/Bodies.h"

namespace
{
std::atomic<long> allocations{0};
}

void* operator new(std::size_t size)
{
	++allocations;
	if (void* p = std::malloc(size ? size : 1)) return p;
	throw std::bad_alloc();
}
void operator delete(void* p) noexcept
{
	std::free(p);
}
void operator delete(void* p, std::size_t) noexcept
{
	std::free(p);
}

namespace
{
using namespace clod;
using namespace clod::test;

TEST(Query, SteadyStepsAllocateNothing)
{
	const Body &a = body("torus", 900), &b = body("torus", 900);
	Random random(1);
	Transform start = poseWithGap(random, a, b, -0.001);
	for (const bool exact : {true, false})
	{
		Settings settings;
		settings.metric.exact = exact;
		settings.metric.weightedDeviation = 0.01 * smallerRadius(a, b);
		settings.tolerance = 0.01 * smallerRadius(a, b);
		PairCache cache;
		QueryResult result;
		// The same loop of poses, three times: the first ones grow the buffers.
		long before = 0;
		for (int step = 0; step < 150; ++step)
		{
			if (step == 100) before = allocations;
			Transform pose = start;
			pose.translation += 1e-4 * smallerRadius(a, b) * Vec3{double(step % 50), 0, 1};
			query(*a.hierarchy, *b.hierarchy, pose, settings, cache, result);
		}
		EXPECT_EQ(allocations - before, 0);
		EXPECT_FALSE(result.contacts.empty());
	}
	const long before = allocations;
	std::vector<int> grown(std::size_t(before) + 1);
	EXPECT_EQ(grown.back(), 0);
	EXPECT_EQ(allocations - before, 1) << "the counter counts";
}
}  // namespace
