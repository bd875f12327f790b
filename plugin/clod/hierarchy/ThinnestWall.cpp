// SPDX-License-Identifier: Zlib
// The triangles of the input surface lie in a grid of cells; each face looks through the cells along its way, no
// farther than the shortest way met so far. Based on: Amanatides & Woo, A fast voxel traversal algorithm for ray
// tracing, 1987.
#include "clod/hierarchy/ThinnestWall.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "clod/hierarchy/BoundGrid.h"

namespace clod
{
namespace
{
constexpr double kRoom = 1e-6;           // of the radius, for rounding
constexpr double kCellsATriangle = 2;    // of the bounding box
constexpr double kMostEntries = 16;      // of a triangle on average: else cells are made larger
constexpr double kMostCellsAlong = 256;

class Walls
{
public:
	explicit Walls(const HierarchyContent& content) : m_thinnest(2 * double(content.asset.radius))
	{
		const double rounding = kStorageShare * double(content.asset.radius);
		gather(content);
		sort(double(content.asset.radius));
		const Level& leaves = content.levels[0];
		for (std::size_t t = 0; t < m_triangles.size(); ++t)
		{
			const Triangle& from = m_triangles[t];
			const Vec3 inward = -toVec3(content.faces[leaves.firstFace + t].normal);
			const double way = exitDistance((1.0 / 3) * (from[0] + from[1] + from[2]), inward);
			if (way > rounding) m_thinnest = std::min(m_thinnest, way);
		}
	}
	double thinnest() const { return m_thinnest; }

private:
	struct Cells
	{
		int low[3], high[3];
	};
	void gather(const HierarchyContent& content)
	{
		const Level& leaves = content.levels[0];
		m_triangles.resize(leaves.faceCount);
		for (std::uint32_t i = leaves.firstNode; i < leaves.firstNode + leaves.nodeCount; ++i)
		{
			const Node& n = content.nodes[i];
			for (std::uint32_t f = n.firstFace; f < n.firstFace + n.faceCount; ++f)
				for (std::size_t k = 0; k < 3; ++k)
				{
					const std::uint32_t v = n.firstVertex + content.faces[f].vertex[k];
					const Vec3 corner{double(content.hullX[v]), double(content.hullY[v]), double(content.hullZ[v])};
					m_triangles[f - leaves.firstFace][k] = corner;
					for (int axis = 0; axis < 3; ++axis)
					{
						m_low[axis] = std::min(m_low[axis], corner[axis]);
						m_high[axis] = std::max(m_high[axis], corner[axis]);
					}
				}
		}
	}
	int cellOf(double at, int axis) const
	{
		return std::clamp(int((at - m_low[axis]) / m_size), 0, m_count[axis] - 1);
	}
	Cells cellsOf(const Triangle& t, double room) const
	{
		Cells cells{};
		for (int axis = 0; axis < 3; ++axis)
		{
			cells.low[axis] = cellOf(std::min({t[0][axis], t[1][axis], t[2][axis]}) - room, axis);
			cells.high[axis] = cellOf(std::max({t[0][axis], t[1][axis], t[2][axis]}) + room, axis);
		}
		return cells;
	}
	std::size_t index(int x, int y, int z) const { return (std::size_t(x) * m_count[1] + y) * m_count[2] + z; }
	template <class Visit>
	void forEachCell(const Cells& cells, const Visit& visit) const
	{
		for (int x = cells.low[0]; x <= cells.high[0]; ++x)
			for (int y = cells.low[1]; y <= cells.high[1]; ++y)
				for (int z = cells.low[2]; z <= cells.high[2]; ++z) visit(index(x, y, z));
	}
	// Triangles of a cell lie side by side.
	void sort(double radius)
	{
		const double room = kRoom * radius;
		double volume = 1, longest = 0;
		for (int axis = 0; axis < 3; ++axis)
		{
			m_low[axis] -= room;
			const double extent = m_high[axis] - m_low[axis] + room;
			volume *= extent;
			longest = std::max(longest, extent);
		}
		const double triangles = double(m_triangles.size());
		m_size = std::max(std::cbrt(volume / (kCellsATriangle * triangles)), longest / kMostCellsAlong);
		for (double entries = std::numeric_limits<double>::infinity();; m_size *= 2)
		{
			for (int axis = 0; axis < 3; ++axis)
				m_count[axis] = 1 + int((m_high[axis] - m_low[axis] + room) / m_size);
			entries = 0;
			for (const Triangle& t : m_triangles)
			{
				const Cells c = cellsOf(t, room);
				entries += (c.high[0] - c.low[0] + 1.0) * (c.high[1] - c.low[1] + 1.0) * (c.high[2] - c.low[2] + 1.0);
			}
			if (entries <= kMostEntries * triangles) break;
		}
		m_start.assign(std::size_t(m_count[0]) * m_count[1] * m_count[2] + 1, 0);
		for (const Triangle& t : m_triangles) forEachCell(cellsOf(t, room), [&](std::size_t cell) { ++m_start[cell]; });
		for (std::size_t i = 1; i < m_start.size(); ++i) m_start[i] += m_start[i - 1];
		m_entries.resize(m_start.back());
		for (std::uint32_t t = 0; t < m_triangles.size(); ++t)
			forEachCell(cellsOf(m_triangles[t], room), [&](std::size_t cell) { m_entries[--m_start[cell]] = t; });
	}
	// To the first triangle that is left outward, if it is nearer than the thinnest wall known.
	double exitDistance(const Vec3& origin, const Vec3& direction) const
	{
		double nearest = std::numeric_limits<double>::infinity();
		int cell[3], step[3];
		double next[3], across[3];
		for (int axis = 0; axis < 3; ++axis)
		{
			cell[axis] = cellOf(origin[axis], axis);
			step[axis] = direction[axis] < 0 ? -1 : 1;
			const double border = m_low[axis] + m_size * (cell[axis] + (step[axis] > 0 ? 1 : 0));
			const double speed = std::abs(direction[axis]);
			across[axis] = speed > 0 ? m_size / speed : nearest;
			next[axis] = speed > 0 ? std::abs(border - origin[axis]) / speed : nearest;
		}
		for (;;)
		{
			const std::size_t at = index(cell[0], cell[1], cell[2]);
			for (std::uint32_t e = m_start[at]; e < m_start[at + 1]; ++e)
				nearest = std::min(nearest, exitThrough(m_triangles[m_entries[e]], origin, direction));
			const int axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : next[1] < next[2] ? 1 : 2;
			if (next[axis] > std::min(nearest, m_thinnest)) return nearest;
			cell[axis] += step[axis];
			if (cell[axis] < 0 || cell[axis] >= m_count[axis]) return nearest;
			next[axis] += across[axis];
		}
	}
	// Infinite where the way does not leave through it.
	static double exitThrough(const Triangle& t, const Vec3& origin, const Vec3& direction)
	{
		constexpr double kNone = std::numeric_limits<double>::infinity();
		const Vec3 normal = cross(t[1] - t[0], t[2] - t[0]);
		const double along = dot(normal, direction);
		if (along <= 0) return kNone;
		const double at = dot(normal, t[0] - origin) / along;
		if (at < 0) return kNone;
		const Vec3 p = origin + at * direction;
		for (std::size_t i = 0; i < 3; ++i)
			if (dot(normal, cross(t[(i + 1) % 3] - t[i], p - t[i])) < 0) return kNone;
		return at;
	}

	double m_thinnest;
	std::vector<Triangle> m_triangles;
	Vec3 m_low{kFar, kFar, kFar}, m_high{-kFar, -kFar, -kFar};
	double m_size = 0;                     // of a cell
	int m_count[3] = {};                   // of cells
	std::vector<std::uint32_t> m_start;    // of each cell's entries
	std::vector<std::uint32_t> m_entries;  // triangles
	static constexpr double kFar = std::numeric_limits<double>::infinity();
};
}  // namespace

double thinnestWall(const HierarchyContent& content)
{
	return Walls(content).thinnest();
}

UsualWall::UsualWall(const Hierarchy& hierarchy) : thickness(double(hierarchy.asset().thinnestWall))
{
	constexpr double kThinner = 0.05;  // share of the surface
	const Level& level = hierarchy.levels()[hierarchy.finestLevel()];
	std::vector<std::pair<double, double>> walls;  // of a face, and its area
	double total = 0;
	for (std::uint32_t n = level.firstNode; n < level.firstNode + level.nodeCount; ++n)
	{
		const Node& node = hierarchy.node(n);
		const HullView hull = hierarchy.hull(node);
		for (const Face& face : hierarchy.faces(node))
		{
			const Vec3 corner = hull.vertex(face.vertex[0]);
			const double area =
				0.5 * length(cross(hull.vertex(face.vertex[1]) - corner, hull.vertex(face.vertex[2]) - corner));
			walls.emplace_back(2 * double(face.thickness), area);
			total += area;
		}
	}
	std::sort(walls.begin(), walls.end());
	double below = 0;
	for (const auto& [wall, area] : walls)
	{
		if (below > kThinner * total) break;
		thickness = std::max(thickness, wall);
		below += area;
	}
}
}  // namespace clod
