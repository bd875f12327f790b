// SPDX-License-Identifier: GPL-3.0-or-later
// The signed distance to the input surface where corners are hardest: many slivers on one side of a steep one.
#include "clod/hierarchy/InputSurface.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/bullet/PatchHierarchy.h"

namespace clod::test
{
namespace
{
// A square pyramid, ten times as high as wide; the side that faces +x is cut into slivers from the apex.
PatchedMesh spire(std::uint32_t slivers)
{
	PatchedMesh mesh;
	mesh.vertices = {{0, 0, 10}, {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0}, {-0.5, -0.5, 0}};
	std::uint32_t last = 1;
	for (std::uint32_t i = 1; i <= slivers; ++i)
	{
		std::uint32_t next = 2;
		if (i < slivers)
		{
			next = std::uint32_t(mesh.vertices.size());
			mesh.vertices.push_back({0.5, double(i) / double(slivers) - 0.5, 0});
		}
		mesh.triangles.push_back({0, last, next});
		mesh.triangles.push_back({3, next, last});  // the bottom
		last = next;
	}
	mesh.triangles.push_back({0, 2, 3});
	mesh.triangles.push_back({0, 3, 4});
	mesh.triangles.push_back({0, 4, 1});
	mesh.triangles.push_back({3, 1, 4});
	mesh.patch.assign(mesh.triangles.size(), 0);
	mesh.wall = 0.1;
	return mesh;
}
}  // namespace

TEST(InputSurface, BeyondASteepCornerIsOutsideHoweverItsSidesAreCut)
{
	for (const std::uint32_t slivers : {1u, 3u, 40u})
	{
		const auto hierarchy = patchHierarchy(spire(slivers));
		const double* const from = hierarchy->asset().meshFromBody;
		const Vec3 apex = Vec3{0, 0, 10} - Vec3{from[0], from[1], from[2]};
		for (int i = 0; i < 16; ++i)
		{
			const double angle = 2 * std::acos(-1.0) * i / 16;
			// In the apex's own region: 0.8 aside, 0.6 up.
			const Vec3 away = 0.1 * Vec3{0.8 * std::cos(angle), 0.8 * std::sin(angle), 0.6};
			std::uint32_t visited = 0;
			EXPECT_NEAR(distanceToInput(*hierarchy, apex + away, visited).distance, 0.1, 1e-5) << slivers << " " << i;
			EXPECT_LT(distanceToInput(*hierarchy, apex - Vec3{0, 0, 3}, visited).distance, 0) << slivers;
		}
	}
}
}  // namespace clod::test
