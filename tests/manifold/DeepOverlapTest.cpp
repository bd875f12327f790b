// SPDX-License-Identifier: GPL-3.0-or-later
// Which way bodies go out of an overlap whose depth no facet tells.
#include <gtest/gtest.h>

#include <cmath>

#include "clod/hierarchy/ConvexPiece.h"
#include "tests/manifold/FacetPair.h"
#include "tests/query/Bodies.h"
#include "tests/support/HierarchyContents.h"
#include "tests/support/LeafHierarchy.h"
#include "tests/support/Meshes.h"

namespace clod::test
{
// A coarsest level may lie within the body: a landscape's is a box.
TEST(DeepOverlap, ARingIsNotConvexHoweverSmallItsRootIs)
{
	HierarchyContent content = contentOf(*body("torus-900").hierarchy);
	const Node& root = content.nodes.back();
	for (std::vector<float>* coordinates : {&content.hullX, &content.hullY, &content.hullZ})
		for (std::uint32_t i = 0; i < root.vertexCount; ++i) (*coordinates)[root.firstVertex + i] *= 0.5F;
	const HierarchyPointer ring = Hierarchy::fromOwnBytes(encode(content)), cube = cubeOf();
	FacetQuestion question{};
	question.a = question.b = contactBody(*cube);
	EXPECT_TRUE(DeepOverlap::areConvex(question));
	question.b = contactBody(*ring);
	EXPECT_FALSE(DeepOverlap::areConvex(question));
}

// A bar that stands in a ring's hole and sinks into its side by one of its edges, no corner inside, goes back into the
// hole: the hulls, which know of no hole, would have it out through the ring.
TEST(DeepOverlap, AnEdgeLeavesAWallThatItHasHardlyEnteredTheWayItCame)
{
	constexpr int kSides = 24;
	constexpr double kHole = 0.6, kSunk = 0.02, kStep = 2 * 3.14159265358979 / kSides;
	const HierarchyPointer ring = Hierarchy::fromOwnBytes(encode(leafHierarchy(torusMesh(1, 1 - kHole, kSides, 12))));
	std::vector<Vec3> corners;
	for (const double x : {-0.1, 0.1})
		for (const double y : {-1.5, 1.5})
			for (const double z : {-0.1, 0.1}) corners.push_back({x, y, z});
	const HierarchyPointer bar = patchHierarchy(boxMesh({0.2, 3, 0.2}, {1, 1, 1}, 1)),
						   convex = convexPiece(convexPolyhedron(corners, 8), 0).value();
	for (int i = 0; i < kSides; ++i)
	{
		const double angle = (i + 0.5) * kStep, middle = kHole * std::cos(0.5 * kStep) + kSunk - 0.1 * std::sqrt(2.0);
		const Vec3 outward = {std::cos(angle), 0, std::sin(angle)};
		const double half = 0.5 * (0.25 * std::acos(-1.0) - angle);
		const Transform ringFromBar = at(middle * outward, rotationFromQuaternion(0, std::sin(half), 0, std::cos(half)));
		for (const HierarchyPointer& stick : {bar, convex})
			for (const bool isFirst : {true, false})
			{
				const FacetPair pair(isFirst ? stick : ring, isFirst ? ring : stick, isFirst ? inverse(ringFromBar) : ringFromBar);
				FacetQuestion question{contactBody(*pair.a), contactBody(*pair.b), pair.aFromB, pair.aFromB, pair.aFromB, pair.rules};
				const Vec3 out = isFirst ? pair.aFromB.rotation * outward : -outward;  // of the hole: of A from B
				// Impulses of a ledge below tell nothing of the wall.
				for (const Vec3& pushed : {Vec3{}, Vec3{0, 1, 0}, out})
				{
					std::vector<Facet> facets;
					DeepOverlap deep;
					const Vec3 way = deep.find(question, pair.result().contacts, false, {}, pushed, facets);
					ASSERT_FALSE(facets.empty()) << i;
					EXPECT_LT(dot(out, way), -0.9) << i;
					for (const Facet& facet : facets) EXPECT_GT(facet.distance, -1.5 * kSunk) << i;
				}
			}
	}
}
}  // namespace clod::test
