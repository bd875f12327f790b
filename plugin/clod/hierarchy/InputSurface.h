// SPDX-License-Identifier: Zlib
// The input surface seen from a point: its nearest face, and on which side of it the point lies.
//
// The sign is that of the pseudonormal at the nearest feature: the face normal, the sum of the two face normals at an
// edge, the angle-weighted sum round a corner. For a closed oriented surface it tells inside from outside.
//
// Based on: Baerentzen & Aanaes, "Signed distance computation using
// the angle weighted pseudonormal", 2005.
#pragma once
#include <limits>

#include "clod/Export.h"
#include "clod/hierarchy/Hierarchy.h"

namespace clod
{
// Index of the leaf that owns a face of the input surface. O(log nodes).
std::uint32_t ownerOf(const Hierarchy& hierarchy, std::uint32_t face);

// The normal that tells the side at a feature of a face of the input surface; not normalised.
Vec3 pseudonormal(const Hierarchy& hierarchy, std::uint32_t face, int feature);

struct SignedDistance
{
	double distance;     // > 0 outside
	std::uint32_t face;  // the nearest one
	int feature;
};

// Distance of a point (body frame) to the input surface, negative inside. Searches level 0 through the culling boxes of
// the tree; visited counts the boxes. within: the surface is known to be no farther. Cost: some tens of boxes and
// faces, many more where the surface is far and nothing is known.
CLOD_API SignedDistance distanceToInput(const Hierarchy& hierarchy, const Vec3& point, std::uint32_t& visited,
										double within = std::numeric_limits<double>::infinity());
}  // namespace clod
