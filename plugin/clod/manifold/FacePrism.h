// SPDX-License-Identifier: Zlib
// The prism over a real face: the part of space that the face answers for, and what of a triangle lies in it.
#pragma once
#include <algorithm>
#include <array>

#include "clod/collide/ClippedPolygon.h"
#include "clod/hierarchy/Hierarchy.h"

namespace clod
{
inline constexpr double kOpposingCosine = -0.3;  // faces whose normals agree better than this cannot touch

// The region a reference face answers for: over and under its triangle, between three side planes.
struct FacePrism
{
	Vec3 normal;
	double offset = 0;
	std::array<Vec3, 3> side;  // outward
	std::array<double, 3> sideOffset{};
	double top = 0, bottom = 0;  // heights, bottom <= top
	double heightOf(const Vec3& p) const { return dot(normal, p) - offset; }
	// How far a point is beyond the side plane that it is farthest beyond.
	double besideBy(const Vec3& p) const
	{
		return std::max(
			{dot(side[0], p) - sideOffset[0], dot(side[1], p) - sideOffset[1], dot(side[2], p) - sideOffset[2]});
	}
	bool sidesHold(const Vec3& p) const
	{
		for (std::size_t i = 0; i < 3; ++i)
			if (dot(side[i], p) > sideOffset[i]) return false;
		return true;
	}
};

// Is a height that came out of clipToPrism the prism's bottom?
inline bool atBottom(const FacePrism& prism, double height)
{
	return height <= prism.bottom * (1 - 1e-9);
}

// Side planes through the edges that bisect this face and its neighbours; bottom = -thickness, top = 0.
FacePrism prismOf(const Hierarchy& hierarchy, const Node& node, const Face& face);
// Side planes perpendicular to a triangle whose neighbours are unknown; false for a triangle without area.
bool prismOf(const Triangle& triangle, FacePrism& prism);
// The part of the triangle inside the prism; count 0 when there is none.
ClippedPolygon clipToPrism(const FacePrism& prism, const Triangle& triangle);

// Node::curvature, refined for ties: dihedral angles of the border edges included (half weight).
double bendWithBorder(const Hierarchy& hierarchy, const Node& node);
}  // namespace clod
