// SPDX-License-Identifier: GPL-3.0-or-later
// Frames and legend of bodies that answer at known levels: one picture a level, its pixels looked at.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "demos/runner/Frames.h"
#include "demos/runner/InputSurface.h"
#include "tests/demos/BuiltBody.h"

namespace
{
using namespace clod;
using namespace clod::demo;

constexpr double kAside = 0.026;  // A is left of the middle, B right

FrameSubject subjectOf(const HierarchyPointer& a, const HierarchyPointer& b)
{
	FrameSubject subject;
	subject.meshes = {inputSurface(*a), inputSurface(*b)};
	subject.bodies = {{0, a, false}, {1, b, false}};
	subject.overview = subject.overviewAtEnd = orbitCamera({}, 0.055, 0, 60);
	subject.closeUp.center = {9, 9, 9};  // of nothing: its legend is looked at
	subject.closeUp.radius = 0.01;
	subject.hasGround = false;
	return subject;
}

FrameMoment moment()
{
	FrameMoment moment;
	moment.poses.resize(2);
	moment.poses[0].position = {-kAside, 0, 0};
	moment.poses[1].position = {kAside, 0, 0};
	return moment;
}

std::uint32_t coarsestLevel(const Hierarchy& h)
{
	return h.coarsestClodLevel();
}

// Every node of a level of A and every node of a level of B.
FrameAnswer answerAt(const Hierarchy& a, std::uint32_t levelA, const Hierarchy& b, std::uint32_t levelB)
{
	const Level &ofA = a.levels()[levelA], &ofB = b.levels()[levelB];
	GapResult result;
	for (std::uint32_t i = 0; i < std::max(ofA.nodeCount, ofB.nodeCount); ++i)
		result.contacts.push_back(
			{ofA.firstNode + i % ofA.nodeCount, ofB.firstNode + i % ofB.nodeCount, 0, 0, {}, {}, {}});
	FrameAnswer answer;
	answer.pairs.push_back({{0, 1}, std::move(result)});
	return answer;
}

double unlikeness(const Color& l, const Color& r)
{
	// Shading darkens and brightens: only the ratios of channels tell a level.
	const auto chroma = [](const Color& c) { return normalized(Vec3{double(c.r), double(c.g), double(c.b)}); };
	return length(chroma(l) - chroma(r));
}

// Of the pixels that differ between two pictures in columns [from, to), the level whose colour most are nearest to, and
// what share of them.
struct Vote
{
	int level = -1;
	double share = 0;
	int pixels = 0;
};
Vote vote(const Image& image, const Image& bare, int from, int to, int levels)
{
	std::map<int, int> votes;
	Vote vote;
	for (int y = 0; y < image.height; ++y)
		for (int x = from; x < to; ++x)
		{
			const Color color = image.at(x, y);
			if (unlikeness(color, bare.at(x, y)) < 0.05) continue;
			int nearest = 0;
			for (int level = 1; level < levels; ++level)
				if (unlikeness(color, levelColor(level, levels)) < unlikeness(color, levelColor(nearest, levels)))
					nearest = level;
			++votes[nearest];
			++vote.pixels;
		}
	for (const auto& [level, count] : votes)
		if (count > vote.share * vote.pixels) vote = {level, double(count) / vote.pixels, vote.pixels};
	return vote;
}

// Pixels of a legend's swatch: the colour itself, at the top right.
int swatchPixels(const Image& image, const Color& color)
{
	int count = 0;
	for (int y = 0; y < image.height / 3; ++y)
		for (int x = 3 * image.width / 4; x < image.width; ++x)
		{
			const Color c = image.at(x, y);
			count += std::max({std::fabs(c.r - color.r), std::fabs(c.g - color.g), std::fabs(c.b - color.b)}) < 0.008f;
		}
	return count;
}

TEST(RunnerFrames, EveryLevelHasItsColourOnEitherBodyAndInTheLegend)
{
	const HierarchyPointer torus = test::builtBody("torus", 300).hierarchy;
	const int levels = int(coarsestLevel(*torus)) + 1;
	ASSERT_GE(levels, 3);
	// Viridis: dark violet is the finest, yellow the coarsest.
	EXPECT_LT(unlikeness(levelColor(0, levels), {0.267f, 0.005f, 0.329f, 1}), 0.01);
	EXPECT_LT(unlikeness(levelColor(levels - 1, levels), {0.993f, 0.906f, 0.144f, 1}), 0.01);
	FramePainter painter(subjectOf(torus, torus));
	const Image bare = painter.paint(moment(), {}, {});
	for (int level = 0; level < levels; ++level)
	{
		const int other = levels - 1 - level;
		const FrameAnswer answer = answerAt(*torus, std::uint32_t(level), *torus, std::uint32_t(other));
		const Image image = painter.paint(moment(), answer, {});
		ASSERT_EQ(image.width, bare.width);
		const int middle = image.width / 4;  // of the overview, which is the left half
		// The figures at the top left differ, too.
		const Vote a = vote(image, bare, 0, middle, levels), b = vote(image, bare, middle, 2 * middle, levels);
		EXPECT_GT(a.pixels, 2000);
		EXPECT_EQ(a.level, level);
		EXPECT_GT(a.share, 0.6);
		EXPECT_GT(b.pixels, 2000);
		EXPECT_EQ(b.level, other);
		EXPECT_GT(b.share, 0.6);
		for (int k = 0; k < levels; ++k)
			EXPECT_EQ(swatchPixels(image, levelColor(k, levels)) > 40, k == level || k == other)
				<< k << " of " << level;
	}
}

TEST(RunnerFrames, TheLegendNamesTheLevelsOfBothBodies)
{
	const HierarchyPointer torus = test::builtBody("torus", 300).hierarchy, ball = test::builtBody("sphere", 108).hierarchy;
	for (const auto& [a, b] : {std::pair(torus, ball), std::pair(ball, torus)})
	{
		const FrameSubject subject = subjectOf(a, b);
		const std::uint32_t levels = std::max(coarsestLevel(*a), coarsestLevel(*b)) + 1;
		for (std::uint32_t levelA = 0; levelA <= coarsestLevel(*a); ++levelA)
			for (std::uint32_t levelB = 0; levelB <= coarsestLevel(*b); ++levelB)
			{
				const auto legend = legendOf(subject, answerAt(*a, levelA, *b, levelB));
				ASSERT_EQ(legend.size(), levels);
				for (std::uint32_t k = 0; k < levels; ++k)
				{
					EXPECT_EQ(legend[k].isUsed, k == levelA || k == levelB) << k;
					EXPECT_EQ(legend[k].label.rfind(std::to_string(k) + ": ", 0), 0u) << legend[k].label;
					const Color expected = levelColor(int(k), int(levels));
					EXPECT_TRUE(legend[k].color.r == expected.r && legend[k].color.g == expected.g) << k;
					if (k == 0) continue;
					double deviation = 0;  // of whichever body's level is coarser
					for (const HierarchyPointer& h : {a, b})
						if (k <= coarsestLevel(*h))
							deviation = std::max(deviation, double(h->levels()[k].maxDeviation));
					const double said = std::atof(legend[k].label.substr(legend[k].label.find("up to ") + 6).c_str());
					EXPECT_NEAR(said, 1000 * deviation, 5.1e-4) << legend[k].label;
				}
			}
		for (const LegendEntry& entry : legendOf(subject, {})) EXPECT_FALSE(entry.isUsed);
	}
}
}  // namespace
