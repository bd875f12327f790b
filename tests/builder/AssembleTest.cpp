// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>

#include "tests/support/LeafHierarchy.h"
#include "tests/support/Meshes.h"

namespace clod::test
{
namespace
{
void print(const Hierarchy& h)
{
	for (std::size_t i = 0; i < h.levels().size; ++i)
	{
		const Level& l = h.levels()[i];
		std::size_t children = 0;
		double thick = 0, area = 0;
		for (std::uint32_t k = 0; k < l.nodeCount; ++k)
		{
			const Node& n = h.node(l.firstNode + k);
			children += n.childCount;
			thick += n.thickness > 0;
			area += double(n.contactArea);
		}
		const double r = double(h.asset().radius) / 100;
		std::printf(
			"%2zu %6u nodes %6u faces %5.2f ch thick %.2f  h %.4f cover %.4f protrude %.5f surf %.4f dev %.4f D %.3g\n",
			i, l.nodeCount, l.faceCount, double(children) / l.nodeCount, thick / l.nodeCount,
			double(l.maxHausdorff) / r, double(l.maxCover) / r, double(l.maxProtrude) / r, double(l.maxSurf) / r,
			double(l.maxDeviation) / r, area / l.nodeCount / (r * r * 1e4));
	}
}

TEST(Assemble, LeafHierarchyOfATorusIsValid)
{
	const auto start = std::chrono::steady_clock::now();
	const auto h = loaded(leafHierarchy(torusMesh(1, 0.4, 64, 32)));
	print(*h);
	std::printf("%.2f s\n", std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

TEST(Assemble, TorusLevelsAreValid)
{
	for (bool paper : {false, true})
	{
		builder::BuildConfig config;
		config.paper = paper;
		const auto start = std::chrono::steady_clock::now();
		const auto h = loaded(builder::assembleHierarchy(torusLods(1, 0.4, 64, 32, 4), config, nullptr));
		print(*h);
		std::printf("%.2f s\n", std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
	}
}
}  // namespace
}  // namespace clod::test
