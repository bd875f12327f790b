// SPDX-License-Identifier: GPL-3.0-or-later
// After Otaduy & Lin's per-vertex support areas (SGP 2003, sec. 5.1), made independent of the tessellation. The slab is
// clipped exactly; the cap is a disc, approximated by 16 planes of the same area.
#include "builder/assemble/ContactArea.h"

#include <algorithm>
#include <boost/container/small_vector.hpp>

#include "builder/assemble/VisitMarks.h"

namespace clod::builder
{
namespace
{
constexpr double kFacing = 0.2;  // least cosine between a face and the contact normal
constexpr int kCapSides = 16;

using Polygon = boost::container::small_vector<Vec3, 24>;

void clip(Polygon& polygon, const Vec3& normal, double offset)
{
	if (std::all_of(polygon.begin(), polygon.end(), [&](const Vec3& p) { return dot(normal, p) <= offset; })) return;
	Polygon next;
	for (std::size_t i = 0; i < polygon.size(); ++i)
	{
		const Vec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
		const double a = dot(normal, p) - offset, b = dot(normal, q) - offset;
		if (a <= 0) next.push_back(p);
		if ((a <= 0) != (b <= 0)) next.push_back(p + (a / (a - b)) * (q - p));
	}
	polygon.swap(next);
}

double projectedArea(const Polygon& polygon, const Vec3& normal)
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

// What a flood may reach: the slab and the cap, round the origin.
struct ContactArea::Region
{
	Vec3 normal;
	double delta;
	std::vector<std::pair<Vec3, double>> planes;
	double inner;  // radius of the cap's inscribed circle

	Region(const Vec3& n, double depth, double cap)
		: normal(n), delta(depth), planes(slab(n, depth, cap)), inner(planes.back().second)
	{
	}
	bool holds(const Vec3& p) const
	{
		const double height = dot(p, normal);
		return std::fabs(height) <= delta && lengthSquared(p) - height * height <= inner * inner;
	}
};

ContactArea::ContactArea(const Mesh& mesh, double delta, double cap)
	: m_mesh(mesh), m_delta(delta), m_cap(cap), m_neighbours(triangleNeighbours(mesh))
{
	for (const auto& t : mesh.triangles)
	{
		m_areas.push_back(areaVector({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}));
		m_normals.push_back(normalized(m_areas.back()));
	}
	m_clusterOf.assign(mesh.triangles.size(), kNone);
	for (std::uint32_t face = 0; face < m_clusterOf.size(); ++face)
		if (m_clusterOf[face] == kNone) cluster(face);
	for (Cluster& c : m_clusters)
		for (const std::uint32_t face : c.faces)
			for (const std::uint32_t other : m_neighbours[face])
				if (other != kNone && m_clusterOf[other] != m_clusterOf[face]) c.border.push_back(other);
}

// Breadth first from the seed, over faces turned much as the seed is.
void ContactArea::cluster(std::uint32_t seed)
{
	constexpr std::size_t kMostFaces = 64;
	constexpr double kAlike = 0.95;  // least cosine with the seed's normal
	const std::uint32_t id = std::uint32_t(m_clusters.size());
	Cluster c;
	c.axis = m_normals[seed];
	c.faces.push_back(seed);
	m_clusterOf[seed] = id;
	for (std::size_t next = 0; next < c.faces.size(); ++next)
		for (const std::uint32_t other : m_neighbours[c.faces[next]])
		{
			if (other == kNone || m_clusterOf[other] != kNone || c.faces.size() == kMostFaces) continue;
			if (dot(m_normals[other], c.axis) < kAlike) continue;
			m_clusterOf[other] = id;
			c.faces.push_back(other);
		}
	thread_local VisitMarks seen;
	seen.restart(m_mesh.vertices.size());
	for (const std::uint32_t face : c.faces)
	{
		c.area += m_areas[face];
		c.coneCosine = std::min(c.coneCosine, dot(m_normals[face], c.axis) * (1 - 1e-12));
		for (const std::uint32_t v : m_mesh.triangles[face])
			if (seen.add(v)) c.vertices.push_back(m_mesh.vertices[v]);
	}
	c.coneSine = std::sqrt(1 - c.coneCosine * c.coneCosine);
	m_clusters.push_back(std::move(c));
}

// Whether every face is wholly in reach and turned towards the normal far enough: a flood that meets one meets all.
bool ContactArea::isInRegion(const Cluster& cluster, const Vec3& origin, const Region& region) const
{
	const double along = dot(cluster.axis, region.normal);
	const double across = std::sqrt(std::max(0.0, 1 - along * along));
	if (along * cluster.coneCosine - across * cluster.coneSine <= kFacing + 1e-9) return false;
	for (const Vec3& v : cluster.vertices)
		if (!region.holds(v - origin)) return false;
	return true;
}

double ContactArea::areaOf(std::uint32_t face, const Vec3& origin, const Region& region) const
{
	const auto& t = m_mesh.triangles[face];
	Polygon polygon;
	bool isHeld = true;
	for (const std::uint32_t v : t)
	{
		polygon.push_back(m_mesh.vertices[v] - origin);
		isHeld = isHeld && region.holds(polygon.back());
	}
	if (isHeld) return std::max(0.0, dot(m_areas[face], region.normal));
	for (const auto& plane : region.planes)
		if (!polygon.empty()) clip(polygon, plane.first, plane.second);
	return polygon.empty() ? -1 : projectedArea(polygon, region.normal);
}

double ContactArea::at(std::uint32_t start, const Vec3& origin, const Vec3& normal) const
{
	const Region region(normal, m_delta, m_cap);
	thread_local VisitMarks seen, asked, taken;  // faces; clusters asked whether they are in reach; those that are
	seen.restart(m_mesh.triangles.size());
	asked.restart(m_clusters.size());
	taken.restart(m_clusters.size());
	std::vector<std::uint32_t> open{start};
	seen.add(start);
	double area = 0;
	while (!open.empty())
	{
		const std::uint32_t face = open.back(), id = m_clusterOf[face];
		open.pop_back();
		if (taken.has(id)) continue;
		const Cluster& c = m_clusters[id];
		const bool whole = asked.add(id) && isInRegion(c, origin, region);
		const double here = whole ? dot(c.area, normal) : areaOf(face, origin, region);
		if (here < 0) continue;
		area += here;
		if (whole) taken.add(id);
		const auto enter = [&](std::uint32_t other)
		{
			if (other == kNone || dot(m_normals[other], normal) <= kFacing || !seen.add(other)) return;
			open.push_back(other);
		};
		if (whole)
			for (const std::uint32_t other : c.border) enter(other);
		else
			for (const std::uint32_t other : m_neighbours[face]) enter(other);
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
