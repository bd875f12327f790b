// SPDX-License-Identifier: GPL-3.0-or-later
// A steady query allocates nothing: operator new is counted.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <vector>

#include "clod/query/StopRule.h"
#include "tests/query/Answers.h"

namespace
{
std::atomic<long> allocations{0};

void* allocate(std::size_t size)
{
	++allocations;
	return std::malloc(size ? size : 1);
}
void release(void* p)
{
	std::free(p);
}
}  // namespace

#include "tests/support/ReplacedNew.h"

namespace
{
using namespace clod;
using namespace clod::test;

struct Case
{
	const char* name;
	Settings settings;
};

std::vector<Case> cases(double radius)
{
	std::vector<Case> list;
	const auto add = [&](const char* name, auto change)
	{
		Settings settings;
		settings.tolerance = 0.01 * radius;
		change(settings);
		list.push_back({name, settings});
	};
	const auto size = [=](Settings& s) { s.metric.weightedDeviation = 0.01 * radius; };
	add("exact", [](Settings& s) { s.metric.exact = true; });
	add("size", size);
	add("certified, base levels", [=](Settings& s) { s.metric.maxError = 0.05 * radius; });
	add("certified, mixed levels",
		[=](Settings& s) { s.metric.maxError = 0.05 * radius, s.metric.weightedDeviation = 0.02 * radius; });
	add("velocity",
		[=](Settings& s) {
			s.metric.velocity = {1, 1e-3 * radius, {0.05 * radius, 0, 0}, {0, 0.1, 0.05}};
		});
	add("view", [=](Settings& s) { s.metric.view = {1, {0, 0, 3 * radius}, 0.005, 0.01 * radius}; });
	add("gap within an error", [=](Settings& s) { size(s), s.gapError = 1e-3 * radius; });
	add("budget of tests", [=](Settings& s) { size(s), s.budget.tests = 200; });
	add("coarsened", [=](Settings& s) { size(s), s.metric.coarsening = 8; });
	add("sweep", [=](Settings& s) { size(s), s.sweep.linear = {0, 0, 1e-3 * radius}; });
	const std::size_t withGap = list.size();
	for (std::size_t i = 0; i < withGap; ++i)
	{
		list.push_back(list[i]);
		list.back().settings.contactsOnly = true;
	}
	add("distance", [=](Settings& s) { size(s), s.distance = true; });
	return list;
}

struct Walk
{
	const char* name;
	double gap, step;  // of the radius
	bool isApart() const { return gap > 0; }
};

// Allocations in the last two of seven rounds of the same loop of poses: the first ones grow the buffers.
long allocationsOf(const BodyPair& pair, const Walk& walk, const Settings& settings)
{
	Random random(1);
	const double radius = smallerRadius(pair.a, pair.b);
	const Transform start = poseWithGap(random, pair.a, pair.b, walk.gap);
	GapCache cache;
	GapResult result;
	long before = 0;
	std::size_t contacts = 0;
	for (int step = 0; step < 350; ++step)
	{
		if (step == 250) before = allocations;
		Transform pose = start;
		pose.translation += walk.step * radius * Vec3{double(step % 50), 0, 1};
		query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
		contacts += result.contacts.size();
	}
	const long made = allocations - before;
	EXPECT_EQ(contacts == 0, walk.isApart());
	return made;
}

TEST(Query, SteadyStepsAllocateNothing)
{
	const BodyPair pair{body("torus", 900), body("torus", 900)};
	const Walk walks[] = {{"sliding", -0.001, 1e-4}, {"almost at rest", -0.001, 1e-7}, {"apart", 0.05, 1e-4}};
	for (const Case& c : cases(smallerRadius(pair.a, pair.b)))
	{
		ASSERT_EQ(settingsError(c.settings), "") << c.name;
		if (c.settings.metric.maxError < kOff)
		{
			const QueryContext context(*pair.a.hierarchy, *pair.b.hierarchy, Transform{});
			const BaseLevels base = StopRule(context, c.settings.metric).base();
			EXPECT_EQ(base.isUsed(), c.settings.metric.weightedDeviation == kOff);
			EXPECT_FALSE(base.isOfLeaves());
		}
		for (const Walk& walk : walks)
			EXPECT_EQ(allocationsOf(pair, walk, c.settings), 0)
				<< c.name << (c.settings.contactsOnly ? ", contacts only, " : ", ") << walk.name;
	}
	const long before = allocations;
	std::vector<int> grown(std::size_t(before) + 1);
	EXPECT_EQ(grown.back(), 0);
	EXPECT_EQ(allocations - before, 1) << "the counter counts";
}
}  // namespace
