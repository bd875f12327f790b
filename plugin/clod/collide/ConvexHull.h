// SPDX-License-Identifier: Zlib
// A convex hull as a set of float vertices swept along a segment (its thickness).
#pragma once
#include <cstdint>

#include "clod/collide/Vector.h"

namespace clod
{
inline constexpr std::uint32_t kVertexLanes = 4;  // hull vertices are padded to a multiple of this by the last one

// Vertices as structure of arrays, 16-byte aligned, padded to kVertexLanes by repeating the last one.
struct HullView
{
	const float* x;
	const float* y;
	const float* z;
	std::uint32_t count;   // without padding
	std::uint32_t padded;  // multiple of kVertexLanes
	Vec3 vertex(std::uint32_t i) const { return {double(x[i]), double(y[i]), double(z[i])}; }
};

struct ConvexHull
{
	HullView vertices;
	Vec3 sweep;  // hull = hull(vertices) (+) segment [0, sweep]; own frame
};
}  // namespace clod
