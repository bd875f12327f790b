// SPDX-License-Identifier: GPL-3.0-or-later
// The real faces of one level as a coloured mesh in the mesh's own frame, for MeshLab, Blender, f3d and other viewers.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <clod/hierarchy/Hierarchy.h>

namespace clod::builder
{
struct LevelSurface
{
	// Vertices are repeated in every patch, so that each can carry its patch's colour.
	std::vector<Float3> verticesInBody;
	std::vector<std::array<std::uint8_t, 3>> colors;  // one a vertex
	std::vector<std::array<std::uint32_t, 3>> triangles;
	std::size_t patchCount = 0;
	Vec3 meshFromBody;
};
LevelSurface levelSurface(const Hierarchy& hierarchy, std::uint32_t level);

std::string encodePly(const LevelSurface& surface);  // binary, coordinates in double
std::string encodeObj(const LevelSurface& surface);  // colours after the coordinates
std::string encodeGlb(const LevelSurface& surface);  // body frame moved by the node's translation
}  // namespace clod::builder
