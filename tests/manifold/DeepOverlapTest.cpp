// SPDX-License-Identifier: GPL-3.0-or-later
// Which way bodies go out of an overlap whose depth no facet tells.
#include <gtest/gtest.h>

#include <cmath>

#include "clod/hierarchy/ConvexPiece.h"
#include "tests/manifold/FacetPair.h"
#include "tests/query/Bodies.h"
#include "tests/support/HierarchyContents.h"

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
// hole: the hulls, which know of no hole, would have it out through the ring. A way kept from where it was before, at
// the other side of the hole, would do so, too. Curved patches have no thickness of their own: the wall has it.
TEST(DeepOverlap, AnEdgeLeavesAWallThatItHasHardlyEnteredTheWayItCame)
{
	constexpr int kSides = 24;
	constexpr double kHole = 0.7, kSunk = 0.02, kStep = 2 * 3.14159265358979 / kSides;
	HierarchyContent content = contentOf(*body("ring").hierarchy);
	for (Node& node : content.nodes) node.thickness = 0;
	const HierarchyPointer told = Hierarchy::fromOwnBytes(encode(content));
	for (Face& face : content.faces) face.thickness = 0;  // as of a stretched body
	const HierarchyPointer untold = Hierarchy::fromOwnBytes(encode(content));
	std::vector<Vec3> corners;
	for (const double x : {-0.1, 0.1})
		for (const double y : {-1.5, 1.5})
			for (const double z : {-0.1, 0.1}) corners.push_back({x, y, z});
	const HierarchyPointer bar = patchHierarchy(boxMesh({0.2, 3, 0.2}, {1, 1, 1}, 1)),
						   convex = convexPiece(convexPolyhedron(corners, 8), 0).value();
	for (const int which : {0, 1, 2, 3})
		for (const bool isFirst : {true, false})
			for (const int pushed : {0, 1, 2})
			{
				const HierarchyPointer &stick = which % 2 == 0 ? bar : convex, &ring = which < 2 ? told : untold;
				Vec3 kept;
				for (int i = 0; i < kSides; ++i)
				{
					const double angle = ((kSides / 2 + 1) * i + 0.5) * kStep;  // the sides about by turns
					const double middle = kHole * std::cos(0.5 * kStep) + kSunk - 0.1 * std::sqrt(2.0);
					const double half = 0.5 * (0.25 * std::acos(-1.0) - angle);
					const Vec3 outward = {std::cos(angle), 0, std::sin(angle)};
					const Transform ringFromBar =
						at(middle * outward, rotationFromQuaternion(0, std::sin(half), 0, std::cos(half)));
					const FacetPair pair(isFirst ? stick : ring, isFirst ? ring : stick,
										 isFirst ? inverse(ringFromBar) : ringFromBar);
					const FacetQuestion question{contactBody(*pair.a), contactBody(*pair.b), pair.aFromB, pair.aFromB,
												 pair.aFromB, pair.rules};
					const Vec3 out = isFirst ? pair.aFromB.rotation * outward : -outward;  // of the hole: of A from B
					// Impulses of a ledge below tell nothing of the wall, nor do those that have it out.
					const Vec3 last = pushed == 0 ? Vec3{} : pushed == 1 ? Vec3{0, 1, 0} : out;
					std::vector<Facet> facets;
					DeepOverlap deep;
					kept = deep.find(question, pair.result().contacts, false, kept, last, facets);
					ASSERT_FALSE(facets.empty()) << i;
					for (const Facet& facet : facets)
					{
						EXPECT_LT(dot(out, facet.normal), -0.9) << i;
						EXPECT_GT(facet.distance, -1.5 * kSunk) << i;
					}
				}
			}
}
}  // namespace clod::test
