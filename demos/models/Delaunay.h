// SPDX-License-Identifier: Zlib
// Delaunay triangulation of points on an integer grid, with exact signs (Bowyer 1981, Watson 1981: insert a point,
// remove the triangles whose circle holds it, fan the hole).
#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace clod::demo
{
struct GridPoint
{
	int64_t x = 0, y = 0;  // at most DELAUNAY_LIMIT in absolute value
};
constexpr int64_t DELAUNAY_LIMIT = 4000000;

// Counter-clockwise triangles that cover the points' convex hull, but for slivers on its border. Points are distinct.
std::vector<std::array<int, 3>> delaunay(const std::vector<GridPoint>& points);
}  // namespace clod::demo
