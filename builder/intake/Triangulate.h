// SPDX-License-Identifier: GPL-3.0-or-later
// Polygon soup to welded triangles that remember where they came from.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "builder/intake/Soup.h"

namespace clod::builder
{
struct WeldedMesh
{
	std::vector<Vec3> vertices;               // distinct, all used, in the order of their first use
	std::vector<std::uint32_t> vertexInFile;  // first index in the file of each
	std::vector<std::array<std::uint32_t, 3>> triangles;
	std::vector<std::uint32_t> polygonInFile;  // of each triangle
	std::size_t weldedCount = 0;               // vertices of the file that repeat another one exactly
	std::size_t unusedCount = 0;               // vertices of the file in no face
};

// For each vertex the first one at the same place. All must be finite.
std::vector<std::uint32_t> firstAtSamePlace(const std::vector<Vec3>& vertices);

// Cuts a polygon into triangles, three corner numbers each: always the ear with the shortest diagonal first, ties by
// the lowest corner; each triangle starts with its lowest corner. Empty where no ear is left.
std::vector<std::uint32_t> cutEars(const std::vector<Vec3>& corners);

// Checks counts, finiteness, index range and size, welds vertices equal in all three coordinates (0 equals -0), and
// cuts polygons into triangles (cutEars). The order of faces and the corner each starts with are kept, so the same
// solid in another format gives the same result. Throws Refused.
WeldedMesh weldAndTriangulate(const Soup& soup);
}  // namespace clod::builder
