// SPDX-License-Identifier: GPL-3.0-or-later
// Source: beneath-beyond insertion with exact orientation (see SmallHull.h).
#include "builder/patches/SmallHull.h"

#include <algorithm>

namespace clod::builder
{
namespace
{
// Exact where the products are; a patch's vertices are floats, so collinear triples of a grid are recognised.
bool isCollinear(const Vec3& a, const Vec3& b, const Vec3& c)
{
	const Vec3 n = cross(b - a, c - a);
	return lengthSquared(n) <= 1e-28 * lengthSquared(b - a) * lengthSquared(c - a);
}

std::uint64_t edge(std::uint32_t from, std::uint32_t to)
{
	return std::uint64_t(from) << 32 | to;
}
}  // namespace

void SmallHull::clear()
{
	m_points.clear();
	m_triangles.clear();
	m_rank = 0;
}

void SmallHull::add(const Vec3& point)
{
	const auto index = std::uint32_t(m_points.size());
	m_points.push_back(point);
	if (m_rank == 4)
	{
		insert(index);
		return;
	}
	if (m_rank == 0)
	{
		m_base[0] = index;
		m_rank = 1;
	}
	else if (m_rank == 1 && point != m_points[m_base[0]])
	{
		m_base[1] = index;
		m_rank = 2;
	}
	else if (m_rank == 2 && !isCollinear(m_points[m_base[0]], m_points[m_base[1]], point))
	{
		m_base[2] = index;
		m_rank = 3;
	}
	else if (m_rank == 3)
		startTetrahedron();
}

// Called with the newest point: the only one that can lie off the plane of all earlier points.
bool SmallHull::startTetrahedron()
{
	const auto top = std::uint32_t(m_points.size() - 1);
	auto [a, b, c] = m_base;
	const int side = orientation(m_points[a], m_points[b], m_points[c], m_points[top]);
	if (side == 0) return false;
	if (side > 0) std::swap(b, c);
	m_triangles = {{a, b, c}, {b, a, top}, {c, b, top}, {a, c, top}};
	m_rank = 4;
	for (std::uint32_t i = 0; i < top; ++i)
		if (i != a && i != b && i != c) insert(i);
	return true;
}

void SmallHull::insert(std::uint32_t point)
{
	m_kept.clear();
	m_visibleEdges.clear();
	for (const Triangle& t : m_triangles)
	{
		if (orientation(m_points[t[0]], m_points[t[1]], m_points[t[2]], m_points[point]) <= 0)
		{
			m_kept.push_back(t);
			continue;
		}
		for (int k = 0; k < 3; ++k) m_visibleEdges.push_back(edge(t[k], t[(k + 1) % 3]));
	}
	if (m_visibleEdges.empty()) return;
	for (const std::uint64_t e : m_visibleEdges)
	{
		const auto from = std::uint32_t(e >> 32), to = std::uint32_t(e);
		if (std::find(m_visibleEdges.begin(), m_visibleEdges.end(), edge(to, from)) == m_visibleEdges.end())
			m_kept.push_back({from, to, point});
	}
	m_triangles.swap(m_kept);
}

void SmallHull::planes(double minimumHeight, std::vector<Plane>& result) const
{
	result.clear();
	for (const Triangle& t : m_triangles)
	{
		const Vec3 &a = m_points[t[0]], &b = m_points[t[1]], &c = m_points[t[2]];
		const Vec3 n = cross(b - a, c - a);
		const double longest = std::sqrt(std::max({lengthSquared(b - a), lengthSquared(c - b), lengthSquared(a - c)}));
		const double area = length(n);
		if (area <= minimumHeight * longest) continue;
		const Vec3 unit = (1 / area) * n;
		result.push_back({unit, std::max({dot(unit, a), dot(unit, b), dot(unit, c)})});
	}
}
}  // namespace clod::builder
