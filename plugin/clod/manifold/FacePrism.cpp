// SPDX-License-Identifier: Zlib
// Side planes from the faces across the edges; clipping by five planes.
#include "clod/manifold/FacePrism.h"

#include <algorithm>

namespace clod
{
namespace
{
void setSide(FacePrism& prism, std::size_t edge, const Vec3& from, const Vec3& direction)
{
	prism.side[edge] = direction;
	prism.sideOffset[edge] = dot(direction, from);
}
}  // namespace

FacePrism prismOf(const Hierarchy& hierarchy, const Node& node, const Face& face)
{
	FacePrism prism;
	prism.normal = toVec3(face.normal);
	prism.offset = double(face.offset);
	prism.bottom = -double(face.thickness);
	const Triangle corners = triangleOf(hierarchy, node, face);
	for (std::size_t i = 0; i < 3; ++i)
	{
		const Vec3 edge = corners[(i + 1) % 3] - corners[i];
		const Vec3 neighbourNormal = toVec3(hierarchy.faces()[face.neighbour[i]].normal);
		Vec3 outward = normalized(cross(edge, prism.normal + neighbourNormal));
		if (lengthSquared(outward) == 0) outward = normalized(cross(edge, prism.normal));  // a fold: no bisector
		setSide(prism, i, corners[i], outward);
	}
	return prism;
}

bool prismOf(const Triangle& triangle, FacePrism& prism)
{
	prism.normal = normalized(cross(triangle[1] - triangle[0], triangle[2] - triangle[0]));
	if (!(lengthSquared(prism.normal) > 0.5)) return false;
	prism.offset = dot(prism.normal, triangle[0]);
	for (std::size_t i = 0; i < 3; ++i)
		setSide(prism, i, triangle[i], normalized(cross(triangle[(i + 1) % 3] - triangle[i], prism.normal)));
	return true;
}

ClippedPolygon clipToPrism(const FacePrism& prism, const Triangle& triangle)
{
	ClippedPolygon polygon;
	const double height[3] = {prism.heightOf(triangle[0]), prism.heightOf(triangle[1]), prism.heightOf(triangle[2])};
	const auto [lowest, highest] = std::minmax_element(height, height + 3);
	if (*lowest > prism.top || *highest < prism.bottom) return polygon;
	bool isCut[3];
	for (std::size_t i = 0; i < 3; ++i)
	{
		const auto outside = [&](const Vec3& corner) { return dot(prism.side[i], corner) > prism.sideOffset[i]; };
		const int out = int(outside(triangle[0])) + int(outside(triangle[1])) + int(outside(triangle[2]));
		if (out == 3) return polygon;
		isCut[i] = out > 0;
	}
	polygon.count = 3;
	std::copy(triangle.begin(), triangle.end(), polygon.vertex.begin());
	for (std::size_t i = 0; i < 3; ++i)
		if (isCut[i]) clipByPlane(polygon, prism.side[i], prism.sideOffset[i]);
	if (*highest > prism.top) clipByPlane(polygon, prism.normal, prism.offset + prism.top);
	if (*lowest < prism.bottom) clipByPlane(polygon, -prism.normal, -(prism.offset + prism.bottom));
	return polygon;
}

double bendWithBorder(const Hierarchy& hierarchy, const Node& node)
{
	double bend = 0, area = 0;
	for (const Face& face : hierarchy.faces(node))
	{
		const Triangle corners = triangleOf(hierarchy, node, face);
		const Vec3 normal = toVec3(face.normal);
		area += 0.5 * length(cross(corners[1] - corners[0], corners[2] - corners[0]));
		for (std::size_t i = 0; i < 3; ++i)
		{
			const Vec3 edge = corners[(i + 1) % 3] - corners[i];
			const Vec3 other = toVec3(hierarchy.faces()[face.neighbour[i]].normal);
			const double edgeLength = length(edge);
			if (!(edgeLength > 0)) continue;
			const double sine = dot(cross(normal, other), edge) / edgeLength;  // > 0: convex edge
			bend += 0.25 * edgeLength * std::atan2(sine, dot(normal, other));
		}
	}
	return area > 0 ? bend / area : 0;
}
}  // namespace clod
