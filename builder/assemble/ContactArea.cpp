// SPDX-License-Identifier: GPL-3.0-or-later
// After Otaduy & Lin's per-vertex support areas (SGP 2003, sec. 5.1), made independent of the tessellation. The slab is
// clipped exactly; the cap is a disc, approximated by 16 planes of the same area.
#include "builder/assemble/ContactArea.h"

#include <algorithm>

namespace clod::builder
{
namespace
{
constexpr double kFacing = 0.2;  // least cosine between a face and the contact normal
constexpr int kCapSides = 16;

void clip(std::vector<Vec3>& polygon, const Vec3& normal, double offset)
{
	std::vector<Vec3> next;
	for (std::size_t i = 0; i < polygon.size(); ++i)
	{
		const Vec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
		const double a = dot(normal, p) - offset, b = dot(normal, q) - offset;
		if (a <= 0) next.push_back(p);
		if ((a <= 0) != (b <= 0)) next.push_back(p + (a / (a - b)) * (q - p));
	}
	polygon.swap(next);
}

double projectedArea(const std::vector<Vec3>& polygon, const Vec3& normal)
{
	Vec3 sum;
	for (std::size_t i = 2; i < polygon.size(); ++i)
		sum += 0.5 * cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
	return std::max(0.0, dot(sum, normal));
}

// Half-spaces of the capped slab round the origin.
std::vector<std::pair<Vec3, double>> slab(const Vec3& normal, double delta, double cap)
{
	const double pi = std::acos(-1.0);
	const Vec3 other = std::fabs(normal.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
	const Vec3 u = normalized(cross(normal, other)), v = cross(normal, u);
	std::vector<std::pair<Vec3, double>> planes{{normal, delta}, {-normal, delta}};
	const double side = cap * std::sqrt(pi / (kCapSides * std::tan(pi / kCapSides)));  // polygon of the disc's area
	for (int i = 0; i < kCapSides; ++i)
	{
		const double angle = 2 * pi * i / kCapSides;
		planes.push_back({std::cos(angle) * u + std::sin(angle) * v, side});
	}
	return planes;
}
}  // namespace

ContactArea::ContactArea(const Mesh& mesh, double delta, double cap)
	: m_mesh(mesh), m_delta(delta), m_cap(cap), m_neighbours(triangleNeighbours(mesh))
{
	for (const auto& t : mesh.triangles)
	{
		m_areas.push_back(areaVector({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}));
		m_normals.push_back(normalized(m_areas.back()));
	}
}

double ContactArea::at(std::uint32_t start, const Vec3& origin, const Vec3& normal) const
{
	const auto planes = slab(normal, m_delta, m_cap);
	// Faces wholly inside the slab and the cap's inscribed circle need no clipping.
	const double inner = planes.back().second;
	const auto isInside = [&](const Vec3& p)
	{
		const double height = dot(p, normal);
		return std::fabs(height) <= m_delta && lengthSquared(p) - height * height <= inner * inner;
	};
	thread_local std::vector<std::uint32_t> seenIn;  // the flood that last met a face; floods of a thread are numbered
	thread_local std::uint32_t flood = 0;
	if (seenIn.size() != m_mesh.triangles.size() || flood == kNone)
	{
		seenIn.assign(m_mesh.triangles.size(), 0);
		flood = 0;
	}
	seenIn[start] = ++flood;
	std::vector<std::uint32_t> open{start};
	double area = 0;
	std::vector<Vec3> polygon;
	while (!open.empty())
	{
		const std::uint32_t face = open.back();
		open.pop_back();
		const auto& t = m_mesh.triangles[face];
		const auto corner = [&](std::size_t k) { return m_mesh.vertices[t[k]] - origin; };
		if (isInside(corner(0)) && isInside(corner(1)) && isInside(corner(2)))
			area += std::max(0.0, dot(m_areas[face], normal));
		else
		{
			polygon.assign({corner(0), corner(1), corner(2)});
			for (const auto& plane : planes)
				if (!polygon.empty()) clip(polygon, plane.first, plane.second);
			if (polygon.empty()) continue;
			area += projectedArea(polygon, normal);
		}
		for (std::uint32_t other : m_neighbours[face])
		{
			if (other == kNone || seenIn[other] == flood || dot(m_normals[other], normal) <= kFacing) continue;
			seenIn[other] = flood;
			open.push_back(other);
		}
	}
	return std::max(area, 4 * m_delta * m_delta);
}

void averageContactAreas(HierarchyDraft& draft, std::size_t levels)
{
	const std::size_t count = draft.levels[levels - 1].firstNode + draft.levels[levels - 1].nodeCount;
	std::vector<double> surface(count, 0), inverseSquares(count, 0);
	for (std::size_t i = 0; i < count; ++i)
	{
		NodeDraft& node = draft.nodes[i];
		if (node.children.empty())
		{
			for (std::size_t f = 0; f < node.faces.size(); ++f) surface[i] += length(areaVector(node.face(f)));
			inverseSquares[i] = surface[i] / (node.contactArea * node.contactArea);
			continue;
		}
		for (std::uint32_t k = 0; k < node.primaryChildren; ++k)
		{
			surface[i] += surface[node.children[k]];
			inverseSquares[i] += inverseSquares[node.children[k]];
		}
		node.contactArea = std::sqrt(surface[i] / inverseSquares[i]);
	}
	for (std::size_t i = count; i-- > 0;)
		for (const std::uint32_t child : draft.nodes[i].children)
			draft.nodes[child].contactArea = std::max(draft.nodes[child].contactArea, draft.nodes[i].contactArea);
}
}  // namespace clod::builder
