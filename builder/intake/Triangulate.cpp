// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/intake/Triangulate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include <clod/hierarchy/Layout.h>

namespace clod::builder
{
namespace
{
void checkSoup(const Soup& soup)
{
	if (soup.vertices.empty()) throw Refused(Reason::empty, "the mesh has no vertices");
	if (soup.polygonCount() == 0) throw Refused(Reason::empty, "the mesh has no faces");
	if (soup.corners.size() - 2 * soup.polygonCount() > kTriangleLimit)
		throw Refused(Reason::limit, fmt::format("{} triangles; the limit is {}",
												 soup.corners.size() - 2 * soup.polygonCount(), kTriangleLimit));
	for (std::size_t i = 0; i < soup.vertices.size(); ++i)
	{
		const Vec3& v = soup.vertices[i];
		if (!isFinite(v)) throw Refused(Reason::notFinite, fmt::format("vertex {} is ({}, {}, {})", i, v.x, v.y, v.z));
	}
	for (std::size_t polygon = 0; polygon < soup.polygonCount(); ++polygon)
		for (std::size_t c = soup.polygonBegin(polygon); c < soup.polygonEnd[polygon]; ++c)
			if (soup.corners[c] >= soup.vertices.size())
				throw Refused(Reason::indexOutOfRange, fmt::format("face {}: vertex index {} (from 0) with {} vertices",
																   polygon, soup.corners[c], soup.vertices.size()));
}

// Volumes of features must fit a float: meshes longer or shorter than this are refused.
constexpr double kSmallestExtent = 1e-10, kLargestExtent = 1e10;

void checkExtent(const Soup& soup)
{
	Vec3 low = soup.vertices[soup.corners[0]], high = low;
	for (const std::uint32_t corner : soup.corners)
		for (int i = 0; i < 3; ++i)
		{
			low[i] = std::min(low[i], soup.vertices[corner][i]);
			high[i] = std::max(high[i], soup.vertices[corner][i]);
		}
	const double extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
	if (extent == 0) throw Refused(Reason::zeroVolume, "all vertices are at the same place");
	if (!(extent >= kSmallestExtent && extent <= kLargestExtent))
		throw Refused(Reason::limit,
					  fmt::format("the mesh is {} long; the limits are {} and {}; scale it (--scale of clod-build)",
								  extent, kSmallestExtent, kLargestExtent));
}

}  // namespace

std::vector<std::uint32_t> firstAtSamePlace(const std::vector<Vec3>& vertices)
{
	std::vector<std::uint32_t> order(vertices.size());
	std::iota(order.begin(), order.end(), 0u);
	const auto key = [&](std::uint32_t i) { return std::tie(vertices[i].x, vertices[i].y, vertices[i].z); };
	std::sort(order.begin(), order.end(),
			  [&](std::uint32_t a, std::uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
	std::vector<std::uint32_t> first(vertices.size());
	for (std::size_t i = 0; i < order.size(); ++i)
	{
		const bool same = i > 0 && vertices[order[i]] == vertices[order[i - 1]];
		first[order[i]] = same ? first[order[i - 1]] : order[i];
	}
	return first;
}

namespace
{
// A polygon seen along its area vector, in two dimensions, counter-clockwise.
struct Flat
{
	double u, v;
};
std::vector<Flat> flatten(const std::vector<Vec3>& corners)
{
	Vec3 area;
	for (std::size_t i = 0; i < corners.size(); ++i)
		area += cross(corners[i] - corners[0], corners[(i + 1) % corners.size()] - corners[0]);
	int drop = 0;
	for (int axis = 1; axis < 3; ++axis)
		if (std::abs(area[axis]) > std::abs(area[drop])) drop = axis;
	const int first = (drop + 1) % 3, second = (drop + 2) % 3;
	const bool mirrored = area[drop] < 0;
	std::vector<Flat> flat;
	for (const Vec3& p : corners) flat.push_back(mirrored ? Flat{p[second], p[first]} : Flat{p[first], p[second]});
	return flat;
}

double turn(const Flat& a, const Flat& b, const Flat& c)
{
	return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
}

bool isEar(const std::vector<Flat>& flat, const std::vector<std::uint32_t>& loop, std::size_t at)
{
	const std::size_t n = loop.size();
	const Flat& a = flat[loop[(at + n - 1) % n]];
	const Flat& b = flat[loop[at]];
	const Flat& c = flat[loop[(at + 1) % n]];
	if (turn(a, b, c) <= 0) return false;
	for (std::size_t i = 0; i + 3 < n; ++i)
	{
		const Flat& p = flat[loop[(at + 2 + i) % n]];
		if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
	}
	return true;
}

}  // namespace

std::vector<std::uint32_t> cutEars(const std::vector<Vec3>& corners)
{
	const std::vector<Flat> flat = flatten(corners);
	std::vector<std::uint32_t> loop(corners.size()), result;
	std::iota(loop.begin(), loop.end(), 0u);
	const auto emit = [&](std::size_t at)
	{
		const std::size_t n = loop.size();
		std::array<std::uint32_t, 3> t = {loop[(at + n - 1) % n], loop[at], loop[(at + 1) % n]};
		std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
		result.insert(result.end(), t.begin(), t.end());
	};
	while (loop.size() > 3)
	{
		std::size_t best = loop.size();
		double shortest = std::numeric_limits<double>::infinity();
		for (std::size_t at = 0; at < loop.size(); ++at)
		{
			const std::size_t n = loop.size();
			const double diagonal = lengthSquared(corners[loop[(at + n - 1) % n]] - corners[loop[(at + 1) % n]]);
			if (diagonal >= shortest || !isEar(flat, loop, at)) continue;
			best = at;
			shortest = diagonal;
		}
		if (best == loop.size()) return {};
		emit(best);
		loop.erase(loop.begin() + std::ptrdiff_t(best));
	}
	emit(1);
	return result;
}

namespace
{
class Welder
{
public:
	explicit Welder(const Soup& soup)
		: m_soup(soup), m_first(firstAtSamePlace(soup.vertices)), m_welded(soup.vertices.size(), kNone)
	{
		for (std::size_t i = 0; i < m_first.size(); ++i) m_mesh.weldedCount += m_first[i] == i ? 0 : 1;
	}
	void add(std::size_t polygon)
	{
		std::vector<std::uint32_t> corners;
		for (std::size_t c = m_soup.polygonBegin(polygon); c < m_soup.polygonEnd[polygon]; ++c)
			corners.push_back(welded(m_soup.corners[c]));
		if (corners.size() > kPolygonCornerLimit)
			throw Refused(Reason::limit, fmt::format("face {} has {} corners; the limit is {}", polygon, corners.size(),
													 kPolygonCornerLimit));
		std::vector<std::uint32_t> cut = {0, 1, 2};
		if (corners.size() > 3)
		{
			std::vector<Vec3> places;
			for (const std::uint32_t v : corners) places.push_back(m_mesh.vertices[v]);
			cut = cutEars(places);
		}
		if (cut.empty())
			throw Refused(Reason::degenerate,
						  fmt::format("face {} with {} corners cannot be cut into triangles, at {}", polygon,
									  corners.size(), placeOf(m_mesh.vertices[corners[0]])));
		for (std::size_t i = 0; i < cut.size(); i += 3)
		{
			m_mesh.triangles.push_back({corners[cut[i]], corners[cut[i + 1]], corners[cut[i + 2]]});
			m_mesh.polygonInFile.push_back(std::uint32_t(polygon));
		}
	}
	WeldedMesh finish()
	{
		std::vector<bool> used(m_first.size(), false);
		for (const std::uint32_t c : m_soup.corners) used[c] = true;
		m_mesh.unusedCount = std::size_t(std::count(used.begin(), used.end(), false));
		return std::move(m_mesh);
	}

private:
	std::uint32_t welded(std::uint32_t vertexInFile)
	{
		const std::uint32_t first = m_first[vertexInFile];
		if (m_welded[first] == kNone)
		{
			m_welded[first] = std::uint32_t(m_mesh.vertices.size());
			m_mesh.vertices.push_back(m_soup.vertices[first]);
			m_mesh.vertexInFile.push_back(first);
		}
		return m_welded[first];
	}
	const Soup& m_soup;
	std::vector<std::uint32_t> m_first, m_welded;
	WeldedMesh m_mesh;
};
}  // namespace

WeldedMesh weldAndTriangulate(const Soup& soup)
{
	checkSoup(soup);
	checkExtent(soup);
	Welder welder(soup);
	for (std::size_t polygon = 0; polygon < soup.polygonCount(); ++polygon) welder.add(polygon);
	return welder.finish();
}
}  // namespace clod::builder
