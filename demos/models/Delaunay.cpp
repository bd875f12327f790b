// SPDX-License-Identifier: Zlib
#include "demos/models/Delaunay.h"

#include <algorithm>
#include <cmath>

namespace clod::demo
{
namespace
{
__extension__ typedef __int128 Wide;

// Is p strictly inside the circle of the counter-clockwise triangle a b c? In double where the sign is certain, else in
// integers: differences below 2^28 make products below 2^115.
bool inCircle(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& p)
{
	const int64_t ax = a.x - p.x, ay = a.y - p.y, bx = b.x - p.x, by = b.y - p.y, cx = c.x - p.x, cy = c.y - p.y;
	const int64_t a2 = ax * ax + ay * ay, b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
	const int64_t bc = bx * cy - cx * by, ca = cx * ay - ax * cy, ab = ax * by - bx * ay;
	const double t0 = double(a2) * double(bc), t1 = double(b2) * double(ca), t2 = double(c2) * double(ab);
	const double sum = t0 + t1 + t2, bound = 1e-14 * (std::fabs(t0) + std::fabs(t1) + std::fabs(t2));
	if (sum > bound) return true;
	if (sum < -bound) return false;
	return Wide(a2) * bc + Wide(b2) * ca + Wide(c2) * ab > 0;
}

// Edges of the removed triangles that no other removed triangle shares, in the removed triangles' sense.
std::vector<std::array<int, 2>> borderEdges(const std::vector<std::array<int, 3>>& removed)
{
	std::vector<std::array<int, 2>> edges, border;
	for (const auto& t : removed)
		for (size_t k = 0; k < 3; ++k) edges.push_back({t[k], t[(k + 1) % 3]});
	for (const auto& e : edges)
		if (std::find(edges.begin(), edges.end(), std::array<int, 2>{e[1], e[0]}) == edges.end()) border.push_back(e);
	return border;
}
}  // namespace

std::vector<std::array<int, 3>> delaunay(const std::vector<GridPoint>& points)
{
	constexpr int64_t FAR = 15 * DELAUNAY_LIMIT;
	std::vector<GridPoint> all = points;
	const int n = int(points.size());
	all.insert(all.end(), {{-FAR, -FAR}, {FAR, -FAR}, {0, FAR}});
	std::vector<std::array<int, 3>> triangles = {{n, n + 1, n + 2}}, removed;
	for (int p = 0; p < n; ++p)
	{
		removed.clear();
		size_t kept = 0;
		for (const auto& t : triangles)
		{
			if (inCircle(all[size_t(t[0])], all[size_t(t[1])], all[size_t(t[2])], all[size_t(p)]))
				removed.push_back(t);
			else
				triangles[kept++] = t;
		}
		triangles.resize(kept);
		for (const auto& e : borderEdges(removed)) triangles.push_back({e[0], e[1], p});
	}
	const auto isOuter = [n](const std::array<int, 3>& t) { return t[0] >= n || t[1] >= n || t[2] >= n; };
	triangles.erase(std::remove_if(triangles.begin(), triangles.end(), isOuter), triangles.end());
	return triangles;
}
}  // namespace clod::demo
