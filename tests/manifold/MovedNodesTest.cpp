// SPDX-License-Identifier: GPL-3.0-or-later
// What a dispatch notes of nodes in blocks of 64, against the same kept in sets.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "clod/manifold/MovedNode.h"
#include "tests/manifold/FacetPair.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
// Of these places those in the block of one of them, as bits.
std::uint64_t bitsIn(const std::set<std::uint32_t>& places, std::uint32_t place)
{
	std::uint64_t bits = 0;
	for (const std::uint32_t other : places)
		if (other / 64 == place / 64) bits |= std::uint64_t(1) << other % 64;
	return bits;
}

// Nodes in any order, as contacts of either body.
std::vector<Contact> contactsOf(std::uint32_t nodes, bool isA, Random& random)
{
	std::vector<std::uint32_t> order(nodes);
	std::iota(order.begin(), order.end(), 0u);
	for (std::uint32_t i = nodes; i > 1; --i) std::swap(order[i - 1], order[std::uint32_t(uniform(random, 0, i))]);
	std::vector<Contact> contacts(nodes);
	for (std::uint32_t i = 0; i < nodes; ++i) (isA ? contacts[i].nodeA : contacts[i].nodeB) = order[i];
	return contacts;
}
}  // namespace

// Nodes of several blocks share borders within a block and across two: each block tells of its own nodes.
TEST(MovedNodes, BlocksTellWhichNodesShareAFeatureAreDisplacedAndNear)
{
	Random random(23);
	const HierarchyPointer cup = body("cup-3000").hierarchy;
	const ContactBody whole = contactBody(*cup);
	const std::uint32_t count = cup->levels()[0].nodeCount;
	ASSERT_GT(count, 2 * 64u);
	std::size_t shared = 0, across = 0, still = 0, before = 0;
	MovedNodes nodes;
	for (const bool isA : {false, true})
	{
		PointRules rules;
		const Transform turned = at({0, 0, 0.001}, rotationFromQuaternion(0, 0, 0.025, 1));
		const FacetQuestion question{whole, whole, {}, turned, turned, rules};
		const std::vector<Contact> contacts = contactsOf(count, isA, random);
		nodes.start(question, contacts, isA);
		ASSERT_EQ(nodes.blocks(), (count + 63) / 64);
		std::map<std::uint32_t, std::set<std::uint32_t>> having;                             // places, by numbers
		std::map<std::pair<std::uint32_t, std::uint32_t>, std::set<std::uint32_t>> nearTo;  // by those and blocks
		std::vector<std::pair<std::uint32_t, double>> displaced;
		for (const Contact& contact : contacts)
		{
			const MovedNode& node = nodes.of(isA ? contact.nodeA : contact.nodeB);
			displaced.emplace_back(node.place, node.displaced);
			std::vector<std::uint32_t> numbers;
			for (const MovedCorner& corner : node.corners) numbers.push_back(corner.number);
			for (const MovedEdge& edge : node.edges) numbers.push_back(edge.number);
			for (const std::uint32_t number : numbers) having[number].insert(node.place);
			for (const std::uint32_t number : numbers)
			{
				const std::set<std::uint32_t>& places = having[number];
				const std::uint64_t bits = bitsIn(places, node.place);
				EXPECT_EQ(nodes.sharing(number, node.place), bits) << number << " of " << node.place;
				shared += (bits & (bits - 1)) != 0 ? 1 : 0;
				across += places.size() > 1 && *places.begin() / 64 != node.place / 64 ? 1 : 0;
				const std::uint32_t other = std::uint32_t(uniform(random, 0, 3 * 64));  // of the other body's
				std::set<std::uint32_t>& noted = nearTo[{number, other / 64}];
				EXPECT_EQ(nodes.noteNear(number, 3, other), bitsIn(noted, other));
				before += noted.empty() ? 0 : 1;
				noted.insert(other);
			}
			const double least = displaced[std::size_t(uniform(random, 0, double(displaced.size())))].second;
			std::set<std::uint32_t> far;
			for (const auto& [place, by] : displaced)
				if (by >= least) far.insert(place);
			EXPECT_EQ(nodes.displaced(least, node.place), bitsIn(far, node.place));
			still += far.size() < displaced.size() ? 1 : 0;
		}
	}
	EXPECT_GT(shared, 1000u);
	EXPECT_GT(across, 100u);
	EXPECT_GT(still, count / 4);
	EXPECT_GT(before, 1000u);
}
}  // namespace clod::test
