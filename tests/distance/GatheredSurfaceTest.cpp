// SPDX-License-Identifier: GPL-3.0-or-later
// What is said to cross no thickened hull, against the distance of the hulls.
#include "clod/distance/GatheredSurface.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "clod/hierarchy/BoundGrid.h"
#include "tests/query/Bodies.h"
#include "tests/support/HierarchyContents.h"

namespace
{
using namespace clod;
using namespace clod::test;

// Hulls thickened away from the solid, as no builder does it but the loader takes it.
std::shared_ptr<const Hierarchy> thickenedOutward(const Hierarchy& hierarchy)
{
	HierarchyContent content = contentOf(hierarchy);
	double room = 0;
	for (Node& node : content.nodes)
	{
		room = std::max(room, 2 * double(node.thickness));
		for (float& v : node.inward) v = -v;
	}
	for (int i = 0; i < 3; ++i)
	{
		content.asset.boxMin[i] -= float(4 * room);
		content.asset.boxMax[i] += float(4 * room);
	}
	for (OrientedBox& box : content.cullBoxes)
	{
		for (float& half : box.half) half = boundAtLeast(double(half) + room);
		box.radius = boundAtLeast(double(box.radius) + 2 * room);
	}
	return loaded(content);
}

struct Tally
{
	int clear = 0;    // said to cross nothing
	int crossed = 0;  // of those, crossed a hull
	int rest = 0;
};

// A small triangle near some face of the leaf, on either side of it; coordinates are floats.
Triangle triangleNear(const Hierarchy& solid, const Node& leaf, Random& random)
{
	const double size = std::max(double(leaf.thickness), 0.01 * solid.asset().radius);
	const Face& face = solid.faces(leaf)[random() % leaf.faceCount];
	const Triangle corner = triangleOf(solid, leaf, face);
	const double share = uniform(random, 0, 1), height = uniform(random, -2, 2);
	const Vec3 on = share * corner[0] + (1 - share) * (0.5 * (corner[1] + corner[2]));
	Triangle triangle;
	for (Vec3& v : triangle)
	{
		v = on + height * size * toVec3(face.normal) + randomVector(random, 0, 0.3 * size);
		v = {double(float(v.x)), double(float(v.y)), double(float(v.z))};
	}
	return triangle;
}

bool crosses(const Hierarchy& solid, const Node& leaf, const Triangle& triangle)
{
	alignas(16) float axis[3][kVertexLanes];
	for (int k = 0; k < 3; ++k)
		for (std::uint32_t lane = 0; lane < kVertexLanes; ++lane) axis[k][lane] = float(triangle[std::min(lane, 2u)][k]);
	const ConvexHull flat{{axis[0], axis[1], axis[2], 3, kVertexLanes}, {}};
	const RelativePose same(Transform{}, solid.originRadius());
	return hullDistance(contactHull(solid, leaf), flat, same, {1, 0, 0}, 0).overlap;
}

// Triangles near each leaf, asked of that leaf alone.
Tally asked(const Hierarchy& solid, Random& random)
{
	std::vector<Contact> ofItself;
	for (std::uint32_t i = 0; i < solid.levels()[0].nodeCount; ++i) ofItself.push_back({i, i, 0, 0, {}, {}, {}});
	ContactSide own, other;
	gatherSides(QueryContext(solid, solid, Transform{}), ofItself, own, other);
	QueryStats stats;
	GatheredSurface surface(own, other, 0, stats);
	Tally tally;
	for (int i = 0; i < 5000; ++i)
	{
		const std::uint32_t group = std::uint32_t(random() % ofItself.size());
		const Node& leaf = solid.node(group);
		const Triangle triangle = triangleNear(solid, leaf, random);
		if (!surface.crossesNothing(group, triangle))
			++tally.rest;
		else
			++(crosses(solid, leaf, triangle) ? tally.crossed : tally.clear);
	}
	return tally;
}

TEST(GatheredSurface, WhatCrossesAThickenedHullIsNeverSaidToCrossNothing)
{
	Random random(5);
	for (const char* name : {"patches-torus", "patches-box", "sphere-300"})
	{
		const Hierarchy& solid = *body(name).hierarchy;
		for (const bool outward : {false, true})
		{
			const Tally tally = asked(outward ? *thickenedOutward(solid) : solid, random);
			EXPECT_EQ(tally.crossed, 0) << name << (outward ? ", outward" : "");
			EXPECT_GT(tally.clear, 1000) << name << (outward ? ", outward" : "");
			EXPECT_GT(tally.rest, 1000) << name << (outward ? ", outward" : "");
		}
	}
}
}  // namespace
