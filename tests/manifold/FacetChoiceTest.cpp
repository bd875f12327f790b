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
// About (1, 1, 0), which is up where cubes stand edge on edge.
Mat3 turnAboutUp(double turn)
{
	const double c = std::sqrt(0.5), k = 1 - std::cos(turn), s = std::sin(turn);
	return {{{1 - 0.5 * k, 0.5 * k, c * s}, {0.5 * k, 1 - 0.5 * k, -c * s}, {-c * s, c * s, 1 - k}}};
}

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
			// About the middle of A's edge; B's edge ends so far from there on the one hand.
			const Mat3 turned = turnAboutUp(side * turn);
			const Vec3 place = (2 * c - sunk) * up - (0.5 - beyond) * (turned * along);
			FacetPair pair(cube, cube, at(place, turned));
			pair.move(way * aside);
			double deepest = 0;
			for (const ContactPoint& point : pair.points()) deepest = std::min(deepest, point.height);
			EXPECT_LT(deepest, -0.99 * sunk) << side << " " << way;
			EXPECT_GT(deepest, -1.01 * sunk) << side << " " << way;
		}
}

// The facets chosen of two bodies, as they are seen by the first of them, but for those merely possible. last: what was
// chosen at the pose before.
std::vector<Facet> countingFacets(const FacetPair& pair, const std::vector<FacetRecord>& last = {}, const Transform& lastAFromB = {})
{
	const Transform then = aFromBAfter(pair.rules.a, pair.rules.b, pair.aFromB, pair.rules.timeStep);
	const FacetQuestion question{contactBody(*pair.a), contactBody(*pair.b), pair.aFromB, then, then, pair.rules};
	FacetFinder finder;
	FacetChoice choice;
	std::vector<Facet> facets;
	finder.find(question, pair.result().contacts, facets);
	choice.choose(question, last, lastAFromB, facets);
	const auto isIdle = [](const Facet& facet) { return facet.reach == Facet::Reach::kPossible; };
	facets.erase(std::remove_if(facets.begin(), facets.end(), isIdle), facets.end());
	return facets;
}

// Two cubes edge on edge, B's turned by so much about the way up, and so far apart.
FacetPair edgeOnEdge(double turn, double gap)
{
	const double c = std::sqrt(0.5);
	return FacetPair(cubeOf(1), cubeOf(1), at((2 * c + gap) * Vec3{c, c, 0}, turnAboutUp(turn)));
}

TEST(FacetChoice, OfEdgesAllButParallelOnlyTheSideCountsThatTheWayEndsOver)
{
	const double c = std::sqrt(0.5);
	const Vec3 up{c, c, 0}, aside{c, -c, 0};
	for (const double turn : {-0.004, 0.004, 0.02})
		for (const double gap : {-0.0005, 0.0005})
			for (const double way : {-0.03, 0.03})
			{
				FacetPair pair = edgeOnEdge(turn, gap);
				pair.rules.margin = 5e-4 * pair.rules.length;
				pair.move(way * aside - 0.001 * up);
				const std::vector<Facet> facets = countingFacets(pair);
				EXPECT_EQ(facets.empty(), gap > 0) << turn << " " << gap << " " << way;
				for (const Facet& facet : facets)
					EXPECT_LT(dot(facet.normal, way * aside), -0.5 * std::abs(way)) << turn << " " << gap << " " << way;
			}
}

// It ends beside them, but would lead through on the way there.
TEST(FacetChoice, AWayThroughEdgesIsMetWhereItLeadsIn)
{
	const double c = std::sqrt(0.5);
	const Vec3 up{c, c, 0}, aside{c, -c, 0};
	for (const double side : {-1.0, 1.0})
	{
		FacetPair pair = edgeOnEdge(0.004, 0.0005);
		pair.rules.margin = 5e-4 * pair.rules.length;
		pair.move(0.03 * side * aside - 0.02 * up);
		const std::vector<Facet> facets = countingFacets(pair);
		const auto isOfEdges = [&](const Facet& facet) { return dot(facet.normal, -1 * up) > 0.99; };
		EXPECT_TRUE(std::any_of(facets.begin(), facets.end(), isOfEdges)) << side;
	}
}

// At rest these have no normal; they will have one where they cross at the end.
TEST(FacetChoice, EdgesThatAreParallelAreMetWhereTheyWillCross)
{
	const double c = std::sqrt(0.5), down = 0.002;
	const Vec3 up{c, c, 0};
	FacetPair pair = edgeOnEdge(0, 0);
	pair.move(-down * up);
	pair.rules.b.angular = (0.02 / pair.rules.timeStep) * up;
	const std::vector<Facet> facets = countingFacets(pair);
	ASSERT_EQ(facets.size(), 1u);
	EXPECT_EQ(facets[0].kind, Facet::Kind::kEdgeEdge);
	EXPECT_GT(dot(facets[0].normal, -1 * up), 0.9999);
	EXPECT_NEAR(facets[0].distance, 0, 1e-6);
	EXPECT_NEAR(facets[0].then, -down, 1e-6);
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
		met += ofMet.size() == 4;
		counted += ofAll.size() == 4;
	}
	EXPECT_LT(met, 250);
	EXPECT_GT(counted, 440);
}

// A section turned about the z axis, in so many steps from that angle: places as radius and z, clockwise.
HierarchyPointer turned(const std::vector<std::pair<double, double>>& section, std::uint32_t round, double first = 0)
{
	constexpr double kTwoPi = 6.283185307179586;
	PatchedMesh mesh;
	mesh.wall = 1;
	for (std::uint32_t i = 0; i < round; ++i)
		for (const auto& [radius, z] : section)
		{
			const double a = first + kTwoPi * i / round;
			mesh.vertices.push_back({radius * std::cos(a), radius * std::sin(a), z});
		}
	const std::uint32_t sides = std::uint32_t(section.size());
	for (std::uint32_t i = 0; i < round; ++i)
		for (std::uint32_t side = 0; side < sides; ++side)
		{
			const std::uint32_t here = sides * i, there = sides * ((i + 1) % round), other = (side + 1) % sides;
			mesh.triangles.push_back({here + side, there + other, here + other});
			mesh.triangles.push_back({here + side, there + side, there + other});
		}
	mesh.patch.resize(mesh.triangles.size());
	return patchHierarchy(singleTriangles(mesh));
}
// A wall round a hole.
HierarchyPointer tubeOf(double inner, double outer, double half, std::uint32_t round, double first = 0)
{
	return turned({{inner, -half}, {outer, -half}, {outer, half}, {inner, half}}, round, first);
}

// A post of three sides sunk into the corner of a square room has its edge beyond the borders of both walls: each counts,
// also the one that it is sunk into less, and the ends of the room, beneath which it is too, do not.
TEST(FacetChoice, InAHollowCornerBothWallsCount)
{
	const double wall = 1, radius = 0.6, degree = std::atan(1) / 45;
	const HierarchyPointer room = tubeOf(std::sqrt(2.0) * wall, 3, 1, 4, 45 * degree);
	Random random(11);
	for (int i = 0; i < 300; ++i)
	{
		const double towards = (-45 + uniform(random, -10, 10)) * degree;
		const HierarchyPointer post = tubeOf(0.2, radius, 0.6, 3, towards);
		const double less = uniform(random, 0.003, 0.008), more = uniform(random, 1.15, 2) * less;
		const double x = i % 2 == 0 ? less : more, y = i % 2 == 0 ? more : less;
		const Vec3 edge{wall + x, -wall - y, uniform(random, -0.3, 0.3)};
		FacetPair pair(room, post, at(edge - radius * Vec3{std::cos(towards), std::sin(towards), 0}));
		double deepestX = 0, deepestY = 0, along = 0;
		for (const Facet& facet : countingFacets(pair))
		{
			if (facet.distance > -1e-6 || facet.reach != Facet::Reach::kOverlap) continue;
			along = std::max(along, std::abs(facet.normal.z));
			double& deepest = std::abs(facet.normal.x) > 0.9 ? deepestX : deepestY;
			deepest = std::max(deepest, -facet.distance);
		}
		EXPECT_NEAR(deepestX, x, 1e-6) << i;
		EXPECT_NEAR(deepestY, y, 1e-6) << i;
		EXPECT_LT(along, 0.1) << i;
	}
}

// A pin that a step tilts in a hole sinks with one flange into the plate's top and with the other one into its bottom. No
// shift leads out of both, and the flanges are beneath the far side of the plate, too: they did not come from there.
TEST(FacetChoice, NothingIsDeeperThanBodiesHaveGone)
{
	const double half = 0.05, gap = 0.001;
	const HierarchyPointer hole = tubeOf(0.53, 1, half, 24);
	const HierarchyPointer pin = turned({{0.2, -0.2}, {0.8, -0.2}, {0.8, -half - gap}, {0.5, -half - gap}, {0.5, half + gap},
										 {0.8, half + gap}, {0.8, 0.2}, {0.2, 0.2}}, 24);
	Random random(5);
	int sunk = 0;
	for (int i = 0; i < 100; ++i)
	{
		const auto some = [&](double most) { return uniform(random, -most, most); };
		const Transform before = at({some(0.01), some(0.01), some(0.0005)});
		const double tilt = uniform(random, 0.005, 0.02), c = std::cos(tilt), s = std::sin(tilt);
		const Transform now = at(before.translation + Vec3{some(0.01), some(0.01), 0}, {{{c, 0, s}, {0, 1, 0}, {-s, 0, c}}});
		FacetPair first(hole, pin, before), then(hole, pin, now);
		first.rules.resting = 0.003;
		const std::vector<Facet> known = countingFacets(first);
		ASSERT_FALSE(known.empty());
		double deepest = 0;
		for (const Facet& facet : countingFacets(then, {known.begin(), known.end()}, before))
			deepest = std::max(deepest, -facet.distance);
		sunk += deepest > 0.001;
		EXPECT_LT(deepest, half) << i;
	}
	EXPECT_GT(sunk, 90);
}
}  // namespace clod::test
