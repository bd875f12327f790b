// SPDX-License-Identifier: GPL-3.0-or-later
// Which facets count where bodies overlap.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>

#include "clod/manifold/FacetChoice.h"
#include "clod/manifold/FacetFinder.h"
#include "tests/manifold/FacetPair.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
// Edge on edge, all but parallel: B's end is beyond A's edge, so that the farther side's face is over it, too, deeper
// than the way out that the edges ask for, which leaves nothing of it.
TEST(FacetChoice, WhatTheWayOutLeavesApartIsNoContact)
{
	const double c = std::sqrt(0.5), turn = 0.0152, sunk = 0.0032, beyond = 0.195;
	const Vec3 up{c, c, 0}, aside{c, -c, 0}, along{0, 0, 1};
	const HierarchyPointer cube = cubeOf(1);
	for (const double side : {-1.0, 1.0})
		for (const double way : {-0.0128, 0.0, 0.0128})
		{
			// About `up`, through the middle of A's edge; B's edge ends so far from there on the one hand.
			const double w = side * turn, k = 1 - std::cos(w), s = std::sin(w);
			const Mat3 turned{
				{{1 - 0.5 * k, 0.5 * k, c * s}, {0.5 * k, 1 - 0.5 * k, -c * s}, {-c * s, c * s, 1 - k}}};
			const Vec3 place = (2 * c - sunk) * up - (0.5 - beyond) * (turned * along);
			FacetPair pair(cube, cube, at(place, turned));
			pair.move(way * aside);
			double deepest = 0;
			for (const ContactPoint& point : pair.points()) deepest = std::min(deepest, point.height);
			EXPECT_LT(deepest, -0.99 * sunk) << side << " " << way;
			EXPECT_GT(deepest, -1.01 * sunk) << side << " " << way;
		}
}

// The facets chosen of two bodies, as they are seen by the first of them, but for those merely possible.
std::vector<Facet> countingFacets(const FacetPair& pair)
{
	const Transform then = aFromBAfter(pair.rules.a, pair.rules.b, pair.aFromB, pair.rules.timeStep);
	const FacetQuestion question{contactBody(*pair.a), contactBody(*pair.b), pair.aFromB, then, then, pair.rules};
	FacetFinder finder;
	FacetChoice choice;
	std::vector<Facet> facets;
	finder.find(question, pair.result().contacts, facets);
	choice.choose(question, {}, pair.aFromB, facets);
	const auto isIdle = [](const Facet& facet) { return facet.reach == Facet::Reach::kPossible; };
	facets.erase(std::remove_if(facets.begin(), facets.end(), isIdle), facets.end());
	return facets;
}

// Of these, those that the motion as predicted meets.
std::vector<Facet> metFacets(const FacetPair& pair)
{
	std::vector<Facet> facets = countingFacets(pair);
	const auto isIdle = [](const Facet& facet) { return facet.distance + facet.linear > 0; };
	facets.erase(std::remove_if(facets.begin(), facets.end(), isIdle), facets.end());
	return facets;
}

// A corner between walls passes another one in a step that carries it far aside, as teeth of gears do: which of the
// faces that meet there carries must not depend on which of the bodies is A. Their caps lie in one plane, where edges
// meet besides.
TEST(FacetChoice, ARidgeIsPassedAlikeWhicheverBodyIsA)
{
	const HierarchyPointer cube = cubeOf(1);
	Random random(3);
	std::size_t met = 0;
	for (int i = 0; i < 2000; ++i)
	{
		const auto some = [&](double most) { return uniform(random, -most, most); };
		const double angle = 0.785 + some(0.6), c = std::cos(angle), s = std::sin(angle);
		const Mat3 turn{{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}};
		const Vec3 lowest = turn * Vec3{-0.5, -0.5, 0};
		const double aside = some(0.1), above = 0.001 + some(0.001), onward = -1.5 * aside + some(0.05), down = some(0.05);
		const Transform aFromB = at(Vec3{0.5 + above + aside, 0.5 + above - aside, 0} - lowest, turn);
		const Vec3 way{onward - down, -onward - down, 0};
		FacetPair pair(cube, cube, aFromB), exchanged(cube, cube, inverse(aFromB));
		pair.move(way);
		exchanged.move(-(transposed(turn) * way));
		const std::vector<Facet> facets = metFacets(pair);
		std::vector<Facet> others = metFacets(exchanged);
		for (Facet& facet : others) facet.normal = -(turn * facet.normal);
		const auto isAmong = [](const Facet& facet, const std::vector<Facet>& list)
		{
			const auto isSame = [&](const Facet& other)
			{ return length(other.normal - facet.normal) < 1e-6 && std::abs(other.distance - facet.distance) < 1e-6; };
			return std::any_of(list.begin(), list.end(), isSame);
		};
		for (const Facet& facet : facets) EXPECT_TRUE(isAmong(facet, others)) << i << ": only one way round";
		for (const Facet& facet : others) EXPECT_TRUE(isAmong(facet, facets)) << i << ": only the other way round";
		met += facets.size();
	}
	EXPECT_GT(met, 2000u);
}

// About the y axis, of so many corners round it and round its section.
HierarchyPointer ringOf(double radius, double tube, std::uint32_t round, std::uint32_t across)
{
	constexpr double kTwoPi = 6.283185307179586;
	PatchedMesh mesh;
	mesh.wall = tube;
	const auto corner = [=](std::uint32_t i, std::uint32_t j) { return i % round * across + j % across; };
	for (std::uint32_t i = 0; i < round; ++i)
		for (std::uint32_t j = 0; j < across; ++j)
		{
			const double a = kTwoPi * i / round, b = kTwoPi * j / across, d = radius + tube * std::cos(b);
			mesh.vertices.push_back({d * std::cos(a), tube * std::sin(b), -d * std::sin(a)});
			mesh.triangles.push_back({corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)});
			mesh.triangles.push_back({corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)});
		}
	mesh.patch.resize(mesh.triangles.size());
	return patchHierarchy(singleTriangles(mesh));
}

// Rings that hang in each other touch with the corners of two saddles, where four edges of the one cross four of the
// other: whichever the motion as predicted meets, joints may lead the bodies to the others within the step.
TEST(FacetChoice, WhereSaddlesTouchTheFacetsBesideCountToo)
{
	constexpr double kRing = 1, kTube = 0.3;
	const HierarchyPointer ring = ringOf(kRing, kTube, 8, 4);
	const Mat3 across{{{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}}};  // the axis along z, the near side towards A's
	Random random(7);
	int met = 0, counted = 0;  // wherever all four are
	for (int i = 0; i < 500; ++i)
	{
		const auto some = [&](double most) { return uniform(random, -most, most); };
		// Corner in corner, B's ring inside of A's on the x axis, but for a little.
		const double apart = 0.004 + some(0.002);
		const Vec3 place{2 * (kRing - kTube) - apart, some(0.004), some(0.004)};
		FacetPair pair(ring, ring, at(place, across));
		pair.move({0.012, some(0.004), some(0.004)});
		std::set<std::pair<bool, bool>> ofMet, ofAll;  // signs of normals
		for (const Facet& facet : countingFacets(pair))
		{
			const std::pair<bool, bool> side{facet.normal.y > 0, facet.normal.z > 0};
			if (facet.reach != Facet::Reach::kBeside) ofMet.insert(side);
			ofAll.insert(side);
		}
		EXPECT_GE(ofAll.size(), 3u) << i;
		pair.rules.valleys = false;
		for (const Facet& facet : countingFacets(pair)) EXPECT_NE(facet.reach, Facet::Reach::kBeside) << i;
		met += ofMet.size() == 4;
		counted += ofAll.size() == 4;
	}
	EXPECT_LT(met, 250);
	EXPECT_GT(counted, 440);
}
}  // namespace clod::test
