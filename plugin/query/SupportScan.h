// SPDX-License-Identifier: Zlib
// The vertex of a hull farthest along a direction: a linear scan over padded structure-of-arrays floats, in double.
// Hulls of a dual hierarchy have some ten vertices: a scan beats any search. The wide and the plain version give the
// same bits: same products, same order of sums, no fused operations, ties to the smallest index.
#pragma once
#include <cstdint>

#include "clod/hierarchy/Hierarchy.h"

namespace clod
{
struct Support
{
	double value;         // dot(direction, vertex)
	std::uint32_t index;  // of the vertex; the smallest one among equals
};

// hull.count > 0.
Support supportVertex(const HullView& hull, const Vec3& direction);

// The plain version, the oracle of the wide one.
Support supportVertexPlain(const HullView& hull, const Vec3& direction);
}  // namespace clod
