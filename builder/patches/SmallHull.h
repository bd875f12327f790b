// SPDX-License-Identifier: GPL-3.0-or-later
// Convex hull of a patch's few vertices, grown point by point with exact signs.
// Source: beneath-beyond insertion; coplanar points never count as visible, so every hull is weakly convex and closed.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "builder/patches/Orientation.h"

namespace clod::builder
{
class SmallHull
{
public:
	void clear();
	// O(triangles so far).
	void add(const Vec3& point);

	// All points lie in one plane exactly (fewer than four points included): there are no triangles.
	bool isFlat() const { return m_triangles.empty(); }
	const std::vector<Vec3>& points() const { return m_points; }
	// Outward triangles of indices into points().
	const std::vector<std::array<std::uint32_t, 3>>& triangles() const { return m_triangles; }
	// Outward planes supporting all points, one a triangle; triangles without a stable normal are left out.
	void planes(double minimumHeight, std::vector<Plane>& result) const;

private:
	using Triangle = std::array<std::uint32_t, 3>;
	bool startTetrahedron();
	void insert(std::uint32_t point);

	std::vector<Vec3> m_points;
	std::vector<Triangle> m_triangles;
	std::array<std::uint32_t, 3> m_base{};      // three points that are not collinear, once m_rank reaches 3
	int m_rank = 0;                             // 0, 1, 2 (a line), 3 (a plane), 4
	std::vector<Triangle> m_kept;               // scratch
	std::vector<std::uint64_t> m_visibleEdges;  // from << 32 | to
};
}  // namespace clod::builder
