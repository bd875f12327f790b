// SPDX-License-Identifier: GPL-3.0-or-later
// A hierarchy while it is being assembled: nodes with growable parts, numbers still in double.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "builder/Lod.h"
#include "builder/assemble/Assignment.h"
#include "builder/assemble/ConvexDistance.h"
#include "builder/assemble/Geometry.h"

namespace clod::builder
{
// The numbers of Node that are certified upper bounds.
struct Bounds
{
	double cover = 0, reach = 0, protrude = 0, surf = 0;
};

struct NodeDraft
{
	std::vector<std::uint32_t> children;  // node ids, the primary ones first
	std::uint32_t primaryChildren = 0;
	std::vector<Vec3> vertices;
	std::vector<std::array<std::uint32_t, 3>> faces;  // into vertices; empty in completion nodes
	std::vector<std::uint32_t> triangles;             // the level's mesh triangle of each face
	std::vector<Piece> pieces;                        // O(n): the input surface it answers for
	Vec3 inward{0, 0, 1};
	double thickness = 0;
	Vec3 meanNormal;
	double coneCosine = -1;
	double curvature = 0;
	Bounds bounds;
	double resolution = 0;
	double featureVolume = 0;
	double contactArea = 0;
	double hausdorff = 0;

	Triangle face(std::size_t i) const { return {vertices[faces[i][0]], vertices[faces[i][1]], vertices[faces[i][2]]}; }
	ConvexSet hull() const { return {vertices.data(), vertices.size(), thickness * inward}; }
	// Vertices, and once more at the other end of the thickening segment.
	std::vector<Vec3> hullPoints() const
	{
		std::vector<Vec3> points = vertices;
		if (thickness > 0)
			for (const Vec3& v : vertices) points.push_back(v + thickness * inward);
		return points;
	}
};

struct LevelDraft
{
	std::uint32_t firstNode = 0, nodeCount = 0;
	bool clod = true;
	double patchTolerance = 0;
};

struct HierarchyDraft
{
	std::vector<LevelDraft> levels;
	std::vector<NodeDraft> nodes;
	std::vector<std::uint32_t> primaryParent;
};
}  // namespace clod::builder
