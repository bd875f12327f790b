// SPDX-License-Identifier: GPL-3.0-or-later
// Which of many facets a solver gets, each where closed forms know it.
#include <gtest/gtest.h>

#include <cmath>

#include "clod/manifold/ContactReducer.h"

namespace clod::test
{
namespace
{
constexpr std::uint64_t kOther = 99;  // a feature that is not the last step's

Facet facetAt(const Vec3& place, double distance = 0)
{
	Facet facet{};
	facet.kind = Facet::Kind::kDeep;
	facet.reach = Facet::Reach::kNear;
	facet.onA = facet.onB = place;
	facet.normal = {0, -1, 0};
	facet.distance = facet.then = distance;
	return facet;
}

ContactPoint pointOf(const Facet& facet, std::uint64_t feature)
{
	ContactPoint point;
	point.pointOnA = facet.onA;
	point.pointOnB = facet.onB;
	point.normal = facet.normal;
	point.feature = feature;
	return point;
}

// One point of the last step, at the origin, that carried 5.
ClusterSet carriedAtTheOrigin()
{
	ClusterSet set;
	set.slots[0].count = 1;
	HeldPoint& point = set.slots[0].points[0];
	point.point = pointOf(facetAt({}), 1);
	point.impulse = 5;
	return set;
}

// What becomes of them, of bodies of length 1.
ClusterSet reduced(const std::vector<Facet>& facets, std::uint64_t feature, bool liesAlone = false)
{
	std::vector<ContactPoint> points;
	for (const Facet& facet : facets) points.push_back(pointOf(facet, feature++));
	ContactReducer reducer;
	ClusterSet next;
	PointRules rules;
	rules.length = 1;
	rules.liesAlone = liesAlone;
	reducer.reduce(facets, points, carriedAtTheOrigin(), rules, next);
	return next;
}
}  // namespace

TEST(ContactReducer, APointGoesOnWhereItsFeaturesOrItsPlaceAre)
{
	EXPECT_EQ(reduced({facetAt({0.001, 0, 0})}, kOther).slots[0].points[0].impulse, 5) << "near";
	EXPECT_EQ(reduced({facetAt({0.5, 0, 0})}, 1).slots[0].points[0].impulse, 5) << "the same features";
	const ClusterSet far = reduced({facetAt({0.5, 0, 0})}, kOther);
	EXPECT_EQ(far.slots[0].points[0].impulse, 0);
	EXPECT_EQ(far.slots[0].points[0].previous, kNone);
}

TEST(ContactReducer, WhatCarriedComesBeforeWhatIsLower)
{
	// Too near to each other for both: the first is lower, the second goes on.
	const ClusterSet next = reduced({facetAt({0.0005, 0, 0}, -0.1), facetAt({}, 0)}, 0);
	ASSERT_EQ(next.pointCount(), 1);
	EXPECT_EQ(next.slots[0].points[0].point.pointOnA.x, 0);
	EXPECT_EQ(next.slots[0].points[0].impulse, 5);
}

TEST(ContactReducer, TheDeepestIsAmongThemHoweverManyCarry)
{
	std::vector<Facet> facets;
	for (int i = 0; i < 40; ++i)
	{
		facets.push_back(facetAt({0.1 * i, 0, 0}));
		facets.back().multiplier = 1 + i;
	}
	facets.push_back(facetAt({2.05, 0.03, 0}, -0.01));  // not the farthest of those that are left
	const ClusterSet next = reduced(facets, 0);
	int deep = 0;
	for (const ContactCluster& cluster : next.slots)
		for (int i = 0; i < cluster.count; ++i) deep += cluster.points[std::size_t(i)].point.pointOnA.y > 0;
	EXPECT_EQ(deep, 1);
	EXPECT_EQ(next.pointCount(), int(ContactReducer::kMostOpen));
}

TEST(ContactReducer, OfAFlatThatLiesAloneTheOutermostAndTheLowestStay)
{
	std::vector<Facet> facets;
	for (int i = 0; i < 49; ++i)
	{
		facets.push_back(facetAt({1 + 0.1 * (i % 7), 0, 0.1 * (i / 7)}, i == 24 ? 0.001 : 0.002));
		facets.back().kind = Facet::Kind::kVertexFace;
	}
	const auto countWhere = [](const ClusterSet& set, auto isMeant)
	{
		int count = 0;
		for (const ContactCluster& cluster : set.slots)
			for (int i = 0; i < cluster.count; ++i) count += isMeant(cluster.points[std::size_t(i)].point.pointOnA);
		return count;
	};
	const auto isCorner = [](const Vec3& p) { return std::abs(p.x - 1.3) > 0.29 && std::abs(p.z - 0.3) > 0.29; };
	const auto isMiddle = [](const Vec3& p) { return std::abs(p.x - 1.3) < 0.01 && std::abs(p.z - 0.3) < 0.01; };
	const ClusterSet alone = reduced(facets, 0, true);
	EXPECT_EQ(countWhere(alone, isCorner), 4);
	EXPECT_EQ(countWhere(alone, isMiddle), 1);
	EXPECT_LE(alone.pointCount(), 9);
	// So does what carries, wherever it lies.
	std::vector<Facet> sliding = facets;
	sliding[18].multiplier = 1;
	const auto isLoaded = [&](const Vec3& p) { return p.x == sliding[18].onA.x && p.z == sliding[18].onA.z; };
	EXPECT_EQ(countWhere(alone, isLoaded), 0);
	EXPECT_EQ(countWhere(reduced(sliding, 0, true), isLoaded), 1);
	// Nor does it tip over where the lowest are all on one side, as it is tilted by next to nothing, and the others carry.
	std::vector<Facet> tilted = facets;
	for (Facet& facet : tilted) facet.distance = facet.then = 1e-4 * facet.onA.x;
	tilted[6].multiplier = tilted[48].multiplier = 1;
	EXPECT_EQ(countWhere(reduced(tilted, 0, true), isCorner), 4);
	EXPECT_EQ(reduced(facets, 0).pointCount(), int(ContactReducer::kMostOpen));
	// What is no flat stays whole.
	for (std::size_t i = 0; i < facets.size(); ++i) facets[i].normal = normalized({0.1 * double(i % 7), -1, 0.1 * double(i / 7)});
	EXPECT_EQ(reduced(facets, 0, true).pointCount(), int(ContactReducer::kMostOpen));
}

// A pin in a hole with flanges has facets all round: the sides that carry would else leave none to those that may.
TEST(ContactReducer, WhatIsHeldFromOpposingSidesHasMorePoints)
{
	std::vector<Facet> facets;
	for (int i = 0; i < 200; ++i)
	{
		facets.push_back(facetAt({0.03 * i, 0, 0}));
		facets.back().normal = normalized({0.1, i % 2 == 0 ? 1.0 : -1.0, 0});
	}
	EXPECT_EQ(reduced(facets, 0).pointCount(), kMaxClusters * kClusterPoints);
	// Of these, first what is low, though it is merely possible.
	for (std::size_t i = 0; i < facets.size(); ++i)
	{
		facets[i].distance = facets[i].then = i < 100 ? 0.1 : 0.001;
		if (i >= 100) facets[i].reach = Facet::Reach::kPossible;
	}
	int low = 0;
	for (const ContactCluster& cluster : reduced(facets, 0).slots)
		for (int i = 0; i < cluster.count; ++i) low += cluster.points[std::size_t(i)].point.pointOnA.x > 2.99;
	EXPECT_EQ(low, 100);
	for (Facet& facet : facets) facet.normal = normalized({2, facet.normal.y, 0});  // 53 degrees apart
	EXPECT_EQ(reduced(facets, 0).pointCount(), int(ContactReducer::kMostOpen));
}
}  // namespace clod::test
