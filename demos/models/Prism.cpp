// SPDX-License-Identifier: Zlib
#include "demos/models/Prism.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "demos/models/Delaunay.h"
#include "demos/models/Sweep.h"

namespace clod::demo
{
namespace
{
constexpr double PI = 3.14159265358979323846;
constexpr int SMOOTHING_PASSES = 4;
constexpr int FEWEST_SEGMENTS = 16;  // of a circle
constexpr double GROWTH = 0.45;      // of the triangles' size with the distance from a loop
constexpr double CLEARANCE = 0.8;    // between points, as a share of the size there
constexpr double ROW = 2.5;          // height of a wall's quads over their width
// The search for a triangle count: when it ends, where it starts (metres), how it goes on round the last length.
constexpr double CLOSE = 0.005, FIRST_EDGE = 0.005, TRIED_STEP = 0.008;
constexpr double LONGEST_EDGE = 1, SMALL_PART = 0.1;
constexpr int FIRST_TRIES = 6, MORE_TRIES = 40;
constexpr double FLAT = 1e-5;  // area over squared edge below which three points are in a line

double distance(const PlanarPoint& a, const PlanarPoint& b)
{
	const double x = b.x - a.x, y = b.y - a.y;
	return std::sqrt(x * x + y * y);
}

double signedArea(const Loop& loop)
{
	double sum = 0;
	for (size_t i = 0; i < loop.size(); ++i)
	{
		const PlanarPoint &a = loop[i], &b = loop[(i + 1) % loop.size()];
		sum += a.x * b.y - b.x * a.y;
	}
	return sum / 2;
}

// A flat side: loops with the solid on their left, and triangles over them.
class Side
{
public:
	explicit Side(std::vector<Loop> loops) : m_loops(std::move(loops))
	{
		for (const Loop& loop : m_loops)
			for (size_t i = 0; i < loop.size(); ++i)
			{
				const double before = distance(loop[(i + loop.size() - 1) % loop.size()], loop[i]);
				m_sizes.push_back(std::max(before, distance(loop[i], loop[(i + 1) % loop.size()])));
				m_points.push_back(loop[i]);
			}
		m_fixed = m_points.size();
		addInnerPoints();
		triangulate();
		for (int pass = 0; pass < SMOOTHING_PASSES; ++pass)
		{
			smooth();
			triangulate();
		}
	}
	const std::vector<PlanarPoint>& points() const { return m_points; }
	size_t fixedCount() const { return m_fixed; }
	const std::vector<std::array<int, 3>>& triangles() const { return m_triangles; }

private:
	bool isInside(const PlanarPoint& p) const
	{
		bool inside = false;
		for (const Loop& loop : m_loops)
			for (size_t i = 0; i < loop.size(); ++i)
			{
				const PlanarPoint &a = loop[i], &b = loop[(i + 1) % loop.size()];
				if ((a.y > p.y) == (b.y > p.y)) continue;
				if (p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
			}
		return inside;
	}
	double sizeAt(const PlanarPoint& p) const
	{
		double size = HUGE_VAL;
		for (size_t i = 0; i < m_fixed; ++i) size = std::min(size, m_sizes[i] + GROWTH * distance(p, m_points[i]));
		return size;
	}
	bool hasRoom(const PlanarPoint& p, double room) const
	{
		return std::all_of(m_points.begin(), m_points.end(),
						   [&](const PlanarPoint& q) { return distance(p, q) >= room; });
	}
	// Of triangular lattices from fine to coarse the points whose size is the lattice's, and that have room.
	void addInnerPoints()
	{
		PlanarPoint low = m_points[0], high = m_points[0];
		for (const PlanarPoint& p : m_points)
		{
			low = {std::min(low.x, p.x), std::min(low.y, p.y)};
			high = {std::max(high.x, p.x), std::max(high.y, p.y)};
		}
		constexpr double step = 1.25;
		const double extent = std::max(high.x - low.x, high.y - low.y);
		for (double edge = *std::min_element(m_sizes.begin(), m_sizes.end()); edge < extent; edge *= step)
			for (double y = low.y + 0.4 * edge; y < high.y; y += edge * std::sqrt(0.75))
			{
				const bool isOdd = (std::lround((y - low.y) / (edge * std::sqrt(0.75))) & 1) != 0;
				for (double x = low.x + (isOdd ? 0.75 : 0.25) * edge; x < high.x; x += edge)
				{
					const double size = sizeAt({x, y});
					if (size < edge || size >= edge * step || !isInside({x, y})) continue;
					if (hasRoom({x, y}, CLEARANCE * size)) m_points.push_back({x, y});
				}
			}
	}
	void triangulate()
	{
		double reach = 0;
		for (const PlanarPoint& p : m_points) reach = std::max({reach, std::fabs(p.x), std::fabs(p.y)});
		const double units = double(DELAUNAY_LIMIT - 1) / reach;
		std::vector<GridPoint> grid;
		for (const PlanarPoint& p : m_points)
			grid.push_back({int64_t(std::llround(p.x * units)), int64_t(std::llround(p.y * units))});
		m_triangles.clear();
		for (const auto& t : delaunay(grid))
		{
			const PlanarPoint a = m_points[size_t(t[0])], b = m_points[size_t(t[1])], c = m_points[size_t(t[2])];
			const double longest = std::max({distance(a, b), distance(b, c), distance(c, a)});
			if (signedArea({a, b, c}) < FLAT * longest * longest) continue;
			if (isInside({(a.x + b.x + c.x) / 3, (a.y + b.y + c.y) / 3})) m_triangles.push_back(t);
		}
	}
	// Every inner point moves to the mean of its neighbours.
	void smooth()
	{
		std::vector<PlanarPoint> sums(m_points.size());
		std::vector<int> counts(m_points.size(), 0);
		for (const auto& t : m_triangles)
			for (size_t k = 0; k < 3; ++k)
				for (const size_t other : {(k + 1) % 3, (k + 2) % 3})
				{
					const PlanarPoint& p = m_points[size_t(t[other])];
					PlanarPoint& sum = sums[size_t(t[k])];
					sum = {sum.x + p.x, sum.y + p.y};
					++counts[size_t(t[k])];
				}
		for (size_t i = m_fixed; i < m_points.size(); ++i)
			if (counts[i] > 0) m_points[i] = {sums[i].x / counts[i], sums[i].y / counts[i]};
	}

	std::vector<Loop> m_loops;
	std::vector<PlanarPoint> m_points;  // the loops' first
	std::vector<double> m_sizes;        // longer of the two pieces at each of the loops' points
	size_t m_fixed = 0;
	std::vector<std::array<int, 3>> m_triangles;
};

class PrismMaker
{
public:
	explicit PrismMaker(const Prism& prism) : m_prism(prism) {}
	ModelMesh make()
	{
		const std::vector<size_t> none;
		double z = m_prism.bottom;
		addSide(none, m_prism.layers.front().loops, z);
		for (size_t i = 0; i < m_prism.layers.size(); ++i)
		{
			const PrismLayer& layer = m_prism.layers[i];
			for (const size_t loop : layer.loops) addWall(loop, z, z + layer.height);
			z += layer.height;
			addSide(layer.loops, i + 1 < m_prism.layers.size() ? m_prism.layers[i + 1].loops : none, z);
		}
		return isClosed() ? m_mesh : ModelMesh{};
	}

private:
	uint32_t vertex(size_t loop, size_t point, double z)
	{
		const auto [entry, isNew] =
			m_vertices.emplace(std::make_tuple(loop, point, z), uint32_t(m_mesh.vertices.size()));
		const PlanarPoint& p = m_prism.loops[loop][point];
		if (isNew) m_mesh.vertices.push_back({p.x, p.y, z});
		return entry->second;
	}
	void addWall(size_t loop, double low, double high)
	{
		const Loop& points = m_prism.loops[loop];
		double length = 0;
		for (size_t i = 0; i < points.size(); ++i) length += distance(points[i], points[(i + 1) % points.size()]);
		const double width = length / double(points.size());
		const int rows = std::max(1, int(std::lround((high - low) / (ROW * width))));
		const auto height = [&](int row) { return row == rows ? high : low + (high - low) * row / rows; };
		for (size_t i = 0; i < points.size(); ++i)
			for (int row = 0; row < rows; ++row)
			{
				const size_t next = (i + 1) % points.size();
				addQuad(m_mesh, {vertex(loop, i, height(row)), vertex(loop, next, height(row)),
								 vertex(loop, next, height(row + 1)), vertex(loop, i, height(row + 1))});
			}
	}
	// What one of two layers covers and the other does not: it looks up where that is the lower one.
	void addSide(const std::vector<size_t>& below, const std::vector<size_t>& above, double z)
	{
		const auto isIn = [](const std::vector<size_t>& list, size_t loop)
		{ return std::find(list.begin(), list.end(), loop) != list.end(); };
		std::vector<size_t> ids;
		std::vector<Loop> loops;
		double area = 0;
		for (const auto& [list, other, sign] :
			 {std::make_tuple(&below, &above, 1), std::make_tuple(&above, &below, -1)})
			for (const size_t loop : *list)
				if (!isIn(*other, loop))
				{
					ids.push_back(loop);
					loops.push_back(m_prism.loops[loop]);
					area += sign * signedArea(loops.back());
				}
		if (ids.empty()) return;
		if (m_sides.count(ids) == 0) m_sides.emplace(ids, Side(loops));
		const Side& side = m_sides.at(ids);
		std::vector<uint32_t> indices;
		for (size_t k = 0; k < ids.size(); ++k)
			for (size_t i = 0; i < loops[k].size(); ++i) indices.push_back(vertex(ids[k], i, z));
		for (size_t i = side.fixedCount(); i < side.points().size(); ++i)
		{
			indices.push_back(uint32_t(m_mesh.vertices.size()));
			m_mesh.vertices.push_back({side.points()[i].x, side.points()[i].y, z});
		}
		for (const auto& t : side.triangles())
		{
			std::array<uint32_t, 3> corners = {indices[size_t(t[0])], indices[size_t(t[1])], indices[size_t(t[2])]};
			if (area < 0) std::swap(corners[1], corners[2]);
			m_mesh.triangles.push_back(corners);
		}
	}
	// Every edge twice, once either way, and every vertex used: so walls and sides met in the loops' own edges.
	bool isClosed() const
	{
		std::set<std::pair<uint32_t, uint32_t>> edges;
		std::vector<bool> used(m_mesh.vertices.size(), false);
		for (const auto& t : m_mesh.triangles)
			for (size_t k = 0; k < 3; ++k)
			{
				used[t[k]] = true;
				if (!edges.insert({t[k], t[(k + 1) % 3]}).second) return false;
			}
		const auto isPaired = [&](const auto& edge) { return edges.count({edge.second, edge.first}) > 0; };
		return std::all_of(edges.begin(), edges.end(), isPaired) &&
			   std::find(used.begin(), used.end(), false) == used.end();
	}

	const Prism& m_prism;
	ModelMesh m_mesh;
	std::map<std::vector<size_t>, Side> m_sides;  // by their loops
	std::map<std::tuple<size_t, size_t, double>, uint32_t> m_vertices;
};

int segmentsOf(double radius, double edge)
{
	return std::max(FEWEST_SEGMENTS, int(std::lround(2 * PI * radius / edge)));
}

// Starts in the middle of a piece, so that two equal circles stand flat against each other.
Loop ringLoop(const PlanarPoint& centre, double radius, int segments, int sense)
{
	Loop loop;
	for (int i = 0; i < segments; ++i)
	{
		const double angle = sense * 2 * PI * (i + 0.5) / segments;
		loop.push_back({centre.x + radius * std::cos(angle), centre.y + radius * std::sin(angle)});
	}
	return loop;
}
}  // namespace

Loop polygonLoop(const std::vector<PlanarPoint>& corners, double edge)
{
	Loop loop;
	for (size_t i = 0; i < corners.size(); ++i)
	{
		const PlanarPoint &a = corners[i], &b = corners[(i + 1) % corners.size()];
		const int pieces = std::max(1, int(std::lround(distance(a, b) / edge)));
		for (int k = 0; k < pieces; ++k)
			loop.push_back({a.x + (b.x - a.x) * k / pieces, a.y + (b.y - a.y) * k / pieces});
	}
	return loop;
}

Loop discLoop(const PlanarPoint& centre, double radius, double edge)
{
	return ringLoop(centre, radius, segmentsOf(radius, edge), 1);
}

Loop holeLoop(const PlanarPoint& centre, double radius, double edge)
{
	const int segments = segmentsOf(radius, edge);
	return ringLoop(centre, radius / std::cos(PI / segments), segments, -1);
}

Loop stadiumLoop(const PlanarPoint& from, const PlanarPoint& to, double radius, double edge, double arcEdge)
{
	const double reach = distance(from, to), ahead = std::atan2(to.y - from.y, to.x - from.x);
	const int arc = segmentsOf(radius, arcEdge) / 2, straight = std::max(1, int(std::lround(reach / edge)));
	Loop loop;
	for (const bool isFar : {true, false})
	{
		const PlanarPoint &centre = isFar ? to : from, &next = isFar ? from : to;
		const double start = ahead + (isFar ? -PI / 2 : PI / 2);
		for (int i = 0; i <= arc; ++i)
			loop.push_back({centre.x + radius * std::cos(start + PI * i / arc),
							centre.y + radius * std::sin(start + PI * i / arc)});
		const PlanarPoint last = loop.back();
		for (int i = 1; i < straight; ++i)
			loop.push_back({last.x + (next.x - centre.x) * i / straight, last.y + (next.y - centre.y) * i / straight});
	}
	return loop;
}

ModelMesh makePrism(size_t triangles, const std::function<Prism(double edge)>& atEdge)
{
	ModelMesh best;
	const auto error = [&](const ModelMesh& mesh)
	{ return std::fabs(double(mesh.triangles.size()) - double(triangles)); };
	const auto tryEdge = [&](double edge)
	{
		ModelMesh mesh = PrismMaker(atEdge(edge)).make();
		const double count = double(mesh.triangles.size());
		if (count > 0 && (best.triangles.empty() || error(mesh) < error(best))) best = std::move(mesh);
		return count;
	};
	const auto isClose = [&] { return !best.triangles.empty() && error(best) <= CLOSE * double(triangles); };
	// Parts of a metre start with longer ones, or a single try takes minutes.
	double extent = 0;
	for (const Loop& loop : atEdge(LONGEST_EDGE).loops)
		for (const PlanarPoint& p : loop) extent = std::max({extent, std::fabs(p.x), std::fabs(p.y)});
	double edge = FIRST_EDGE * std::max(1.0, extent / SMALL_PART);
	for (int i = 0; i < FIRST_TRIES && !isClose(); ++i)
	{
		const double count = tryEdge(edge);
		edge *= count > 0 ? std::clamp(std::sqrt(count / double(triangles)), 0.4, 2.5) : 0.97;
	}
	for (int i = 0; i < MORE_TRIES && !isClose(); ++i)
		tryEdge(edge * (1 + TRIED_STEP * (i % 2 ? 1 : -1) * ((i + 1) / 2)));
	return best;
}
}  // namespace clod::demo
