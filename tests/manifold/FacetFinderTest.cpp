// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "clod/hierarchy/ConvexPiece.h"
#include "clod/manifold/FacetFinder.h"
#include "tests/manifold/FacetPair.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
// A body on a floor much wider than it, or at its edge: the facets of a floor of one node, of which edges that are far off
// are left out, are those of a floor whose sides are nodes of their own.
TEST(FacetFinder, OfAWideFloorNothingIsLeftOut)
{
	Random random(5);
	const HierarchyPointer torus = body("torus-900").hierarchy;
	const double size = double(torus->asset().radius);
	std::vector<Vec3> corners;
	for (int i = 0; i < 8; ++i) corners.push_back(5 * size * Vec3{i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5});
	const HierarchyPointer whole = convexPiece(convexPolyhedron(corners, 8), 0).value();
	const HierarchyPointer sides = patchHierarchy(boxMesh({5 * size, 5 * size, 5 * size}, {1, 1, 1}, 1));
	std::size_t found[] = {0, 0};
	for (int round = 0; round < 300; ++round)
	{
		const Mat3 turn = randomRotation(random);
		double lowest = 0;
		for (const Vec3& v : contactBody(*torus).surface(0).vertices()) lowest = std::min(lowest, (turn * v).y);
		const double height = 2.5 * size + uniform(random, -0.02, 0.1) * size - lowest;
		const Vec3 place{uniform(random, -3.2, 3.2) * size, height, uniform(random, -3.2, 3.2) * size};
		const Transform aFromB = inverse(at(place, turn));
		const Vec3 way = uniform(random, 0.01, 0.3) * size * (aFromB.rotation * Vec3{0, 1, 0});
		std::vector<std::tuple<double, double, double, double>> of[2];
		bool hasEdge = false;
		for (const HierarchyPointer& floor : {whole, sides})
		{
			FacetPair pair(torus, floor, aFromB);
			pair.move(way);
			const Transform then = aFromBAfter(pair.rules.a, pair.rules.b, aFromB, pair.rules.timeStep);
			FacetFinder finder;
			std::vector<Facet> facets;
			finder.find({contactBody(*torus), contactBody(*floor), aFromB, then, then, pair.rules}, pair.result().contacts,
						facets);
			for (const Facet& facet : facets)
			{
				// How far aside and how deep inside facets are looked for depends on the nodes.
				if (facet.reach >= Facet::Reach::kPossible || facet.distance < -0.03 * size) continue;
				hasEdge = hasEdge || facet.kind != Facet::Kind::kVertexFace;
				const auto rounded = [&](double length) { return std::round(1e5 * length / size); };
				of[floor == sides].emplace_back(rounded(facet.distance), rounded(facet.onA.x), rounded(facet.onA.y),
												rounded(facet.onA.z));
			}
		}
		for (auto& facets : of) std::sort(facets.begin(), facets.end());
		EXPECT_EQ(of[0], of[1]) << round;
		found[hasEdge] += of[1].size();
	}
	EXPECT_GT(found[0], 100u);
	EXPECT_GT(found[1], 100u);
}

// Nodes share corners and edges at their borders, which a dispatch asks once. The oracle asks each pair of nodes by
// itself: the same facets come of it, and of each what counts most.
TEST(FacetFinder, WhatNodesShareIsAskedOnceAndNothingIsLost)
{
	Random random(11);
	const HierarchyPointer torus = body("torus-900").hierarchy, sphere = body("sphere-300").hierarchy;
	std::size_t found = 0, overlapping = 0, most = 0;
	const HierarchyPointer cube = cubeOf(8);
	const std::pair<HierarchyPointer, HierarchyPointer> pairs[] = {
		{torus, sphere}, {sphere, torus}, {torus, cube}, {cube, cubeOf(12)}};
	for (const auto& [a, b] : pairs)
		for (int round = 0; round < 16; ++round)
		{
			const double radius = std::min(double(a->asset().radius), double(b->asset().radius));
			const Vec3 away = randomDirection(random);
			FacetPair pair(a, b, {randomRotation(random), uniform(random, 0.5, 1.5) * radius * away});
			pair.move(-uniform(random, 0.05, 1) * radius * away);
			pair.rules.b.angular = uniform(random, 0, 0.3) / pair.rules.timeStep * randomDirection(random);
			const FacetQuestion question{contactBody(*a), contactBody(*b), pair.aFromB,
										 aFromBAfter(pair.rules.a, pair.rules.b, pair.aFromB, pair.rules.timeStep),
										 aFromBAfter(pair.rules.a, pair.rules.b, pair.aFromB, pair.rules.timeStep), pair.rules};
			const std::vector<Contact> contacts = pair.result().contacts;
			if (contacts.size() <= kFewPairs) continue;
			FacetFinder finder;
			std::vector<Facet> facets;
			finder.find(question, contacts, facets);
			std::map<std::uint64_t, Facet::Reach> expected, asked;
			for (const Facet& facet : facets) EXPECT_TRUE(asked.insert({facet.feature, facet.reach}).second);
			for (const Contact& contact : contacts)
			{
				std::vector<Facet> alone;
				finder.find(question, std::vector<Contact>(kFewPairs + 1, contact), alone);
				for (const Facet& facet : alone)
				{
					const auto at = expected.insert({facet.feature, facet.reach}).first;
					at->second = std::min(at->second, facet.reach);
				}
				overlapping += contact.upper <= 0 ? 1 : 0;
			}
			EXPECT_EQ(asked, expected) << round;
			found += facets.size();
			std::set<std::uint32_t> nodesOfB;
			for (const Contact& contact : contacts) nodesOfB.insert(contact.nodeB);
			most = std::max(most, nodesOfB.size());
		}
	EXPECT_GT(found, 2000u);
	EXPECT_GT(overlapping, 100u);
	EXPECT_GT(most, 64u);  // that are told apart at a time
}

// A number is of one feature only, however many find their place in the table taken; one that nothing displaces keeps it.
TEST(FeatureNumbers, AreOfOneFeatureEach)
{
	Random random(3);
	FeatureNumbers numbers;
	for (int dispatch = 0; dispatch < 3; ++dispatch)
	{
		numbers.start();
		std::map<std::uint32_t, std::tuple<std::uint32_t, bool, std::uint32_t>> owner;
		std::uint32_t again = 0;
		for (int i = 0; i < 20000; ++i)
		{
			const std::tuple<std::uint32_t, bool, std::uint32_t> feature{
				std::uint32_t(uniform(random, 0, 2)), uniform(random, 0, 1) < 0.5, std::uint32_t(uniform(random, 0, 3000))};
			const auto [level, isEdge, index] = feature;
			const auto [at, isNew] = owner.insert({numbers.of(level, isEdge, index), feature});
			EXPECT_EQ(at->second, feature);
			again += isNew ? 0 : 1;
			EXPECT_EQ(numbers.of(level, isEdge, index), at->first);
		}
		EXPECT_GT(again, 1000u);
		EXPECT_EQ(numbers.next(), owner.size());
	}
}
}  // namespace clod::test
