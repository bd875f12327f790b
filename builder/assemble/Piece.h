// SPDX-License-Identifier: GPL-3.0-or-later
// The bits of the input surface that patches answer for.
//
// A piece is a triangle of an input face's midpoint-split tree, named by the interval of base-4 codes it covers at the
// deepest split. Every level's pieces cover every input face, so each point of the surface has an owner in every level,
// and owners of the same point in neighbouring levels are parent and child: that is the graph.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "builder/Lod.h"
#include "builder/assemble/Geometry.h"

namespace clod::builder
{
struct Piece
{
	static constexpr int kDepth = 8;
	static constexpr std::uint32_t kCodes = 1u << (2 * kDepth);
	std::uint32_t face;   // input triangle
	std::uint32_t first;  // interval of codes
	std::uint32_t count;  // a power of 4
	std::uint32_t owner;  // patch of the level
};

// The four children of the midpoint split; child k of code interval [first, first + 4 size) starts at first + k size.
Triangle childTriangle(const Triangle& t, std::uint32_t k);

// The piece's triangle (closed; midpoints in double).
Triangle pieceTriangle(const Triangle& face, const Piece& piece);

// Pieces as triangles. Corners that are vertices of the mesh are shared, those of split faces each piece's own.
struct Territory
{
	std::vector<Vec3> corners;
	std::vector<std::array<std::uint32_t, 3>> triangles;
};
Territory territoryOf(const std::vector<Piece>& pieces, const Mesh& input);
}  // namespace clod::builder
