// SPDX-License-Identifier: Zlib
// The digits 0 to 9 as solid letters: a glyph's outline extruded, its edges bevelled, faces and walls meshed with
// near-equilateral triangles (Delaunay, smoothed).
#include <algorithm>
#include <cmath>
#include <set>

#include "demos/models/Delaunay.h"
#include "demos/models/Glyph.h"
#include "demos/models/Shapes.h"

namespace clod::demo
{
namespace
{
constexpr double BEVEL = 0.7;           // width and height, mm
constexpr double HALF_THICKNESS = 2.5;  // mm
constexpr double HALF_WALL = HALF_THICKNESS - BEVEL;
constexpr double UNITS_PER_MM = 1e5;  // of the integer grid of the triangulation
constexpr double METRES_PER_MM = 1e-3;
constexpr int SMOOTHING_PASSES = 6;

using Loop = std::vector<GlyphPoint>;

struct Outline
{
	std::vector<Loop> border, bevel;  // fine curves at depth 0 and BEVEL
};

// The face of a digit: points of the border loops first, then of the bevel's, then free ones.
struct Face
{
	std::vector<GlyphPoint> points;
	std::vector<size_t> loopStarts;  // of the border, and one past its end
	size_t fixedCount = 0;           // border and bevel
	std::vector<std::array<int, 3>> triangles;
	size_t borderCount() const { return loopStarts.back(); }
};

// About length / edge points, evenly along the loop, exactly at the depth.
void resample(const Glyph& glyph, const Loop& loop, double edge, double level, std::vector<GlyphPoint>& points)
{
	std::vector<double> arc(1, 0.0);
	for (size_t i = 0; i < loop.size(); ++i)
	{
		const GlyphPoint a = loop[i], b = loop[(i + 1) % loop.size()];
		arc.push_back(arc.back() + std::hypot(b.x - a.x, b.y - a.y));
	}
	const int count = std::max(5, int(std::lround(arc.back() / edge)));
	size_t cell = 0;
	for (int k = 0; k < count; ++k)
	{
		const double wanted = arc.back() * k / count;
		while (arc[cell + 1] < wanted) ++cell;
		const double t = (wanted - arc[cell]) / (arc[cell + 1] - arc[cell]);
		const GlyphPoint a = loop[cell], b = loop[(cell + 1) % loop.size()];
		points.push_back(glyph.moved({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)}, level));
	}
}

// A triangular lattice in the ink, clear of the fixed curves.
void addLattice(const Glyph& glyph, double edge, std::vector<GlyphPoint>& points)
{
	const double rowHeight = edge * std::sqrt(0.75), clearance = 0.6 * edge;
	for (int row = 0; row * rowHeight < GLYPH_HEIGHT; ++row)
		for (int column = 0; column * edge < GLYPH_WIDTH; ++column)
		{
			const GlyphPoint p = {(column + 0.5 * (row % 2)) * edge, row * rowHeight};
			const double depth = glyph.depth(p);
			if (depth > clearance && std::fabs(depth - BEVEL) > clearance) points.push_back(p);
		}
}

// The Delaunay triangles whose middle is ink.
std::vector<std::array<int, 3>> triangulate(const Glyph& glyph, const std::vector<GlyphPoint>& points)
{
	std::vector<GridPoint> grid;
	for (const GlyphPoint& p : points)
		grid.push_back({int64_t(std::llround(p.x * UNITS_PER_MM)), int64_t(std::llround(p.y * UNITS_PER_MM))});
	std::vector<std::array<int, 3>> triangles;
	for (const auto& t : delaunay(grid))
	{
		const GlyphPoint a = points[size_t(t[0])], b = points[size_t(t[1])], c = points[size_t(t[2])];
		if (glyph.depth({(a.x + b.x + c.x) / 3, (a.y + b.y + c.y) / 3}) > 0) triangles.push_back(t);
	}
	return triangles;
}

// Every free point moves to the mean of its neighbours.
void smooth(Face& face)
{
	std::vector<GlyphPoint> sums(face.points.size());
	std::vector<int> counts(face.points.size(), 0);
	for (const auto& t : face.triangles)
		for (size_t k = 0; k < 3; ++k)
			for (const size_t other : {(k + 1) % 3, (k + 2) % 3})
			{
				const GlyphPoint& p = face.points[size_t(t[other])];
				GlyphPoint& sum = sums[size_t(t[k])];
				sum = {sum.x + p.x, sum.y + p.y};
				++counts[size_t(t[k])];
			}
	for (size_t i = face.fixedCount; i < face.points.size(); ++i)
		if (counts[i] > 0) face.points[i] = {sums[i].x / counts[i], sums[i].y / counts[i]};
}

// Are the border loops' edges, and nothing else, the border of the triangles, and is every point used?
bool isValid(const Face& face)
{
	std::set<std::array<int, 2>> edges;
	std::vector<bool> used(face.points.size(), false);
	for (const auto& t : face.triangles)
		for (size_t k = 0; k < 3; ++k)
		{
			edges.insert({t[k], t[(k + 1) % 3]});
			used[size_t(t[k])] = true;
		}
	if (std::find(used.begin(), used.end(), false) != used.end()) return false;
	size_t open = 0;
	for (const auto& e : edges) open += edges.count({e[1], e[0]}) == 0;
	if (open != face.borderCount()) return false;
	for (size_t loop = 0; loop + 1 < face.loopStarts.size(); ++loop)
		for (size_t i = face.loopStarts[loop]; i < face.loopStarts[loop + 1]; ++i)
		{
			const size_t next = i + 1 < face.loopStarts[loop + 1] ? i + 1 : face.loopStarts[loop];
			if (edges.count({int(i), int(next)}) == 0 || edges.count({int(next), int(i)}) != 0) return false;
		}
	return true;
}

Face makeFace(const Glyph& glyph, const Outline& outline, double edge)
{
	Face face;
	face.loopStarts.push_back(0);
	for (const Loop& loop : outline.border)
	{
		resample(glyph, loop, edge, 0, face.points);
		face.loopStarts.push_back(face.points.size());
	}
	for (const Loop& loop : outline.bevel) resample(glyph, loop, edge, BEVEL, face.points);
	face.fixedCount = face.points.size();
	addLattice(glyph, edge, face.points);
	face.triangles = triangulate(glyph, face.points);
	for (int pass = 0; pass < SMOOTHING_PASSES; ++pass)
	{
		smooth(face);
		face.triangles = triangulate(glyph, face.points);
	}
	return face;
}

int wallRows(double edge)
{
	return std::max(1, int(std::lround(2 * HALF_WALL / (1.3 * edge))));
}

size_t solidCount(const Face& face, double edge)
{
	return 2 * face.triangles.size() + 2 * face.borderCount() * size_t(wallRows(edge));
}

// Height of the face over the middle plane: a quarter circle over the bevel, then flat.
double lift(const Glyph& glyph, const Face& face, size_t i)
{
	if (i < face.borderCount()) return HALF_WALL;
	const double t = i < face.fixedCount ? 1 : std::min(1.0, glyph.depth(face.points[i]) / BEVEL);
	return HALF_WALL + BEVEL * std::sqrt(std::max(0.0, 1 - (1 - t) * (1 - t)));
}

// Face, mirrored face, and the wall between their borders.
ModelMesh extrude(const Glyph& glyph, const Face& face, double edge)
{
	ModelMesh mesh;
	const size_t border = face.borderCount(), inner = face.points.size() - border;
	const size_t rows = size_t(wallRows(edge));
	const auto place = [](const GlyphPoint& p, double z) {
		return METRES_PER_MM * Vec3{p.x - GLYPH_WIDTH / 2, p.y - GLYPH_HEIGHT / 2, z};
	};
	for (size_t row = 0; row <= rows; ++row)
		for (size_t i = 0; i < border; ++i)
			mesh.vertices.push_back(place(face.points[i], HALF_WALL * (2 * double(row) / double(rows) - 1)));
	for (const double side : {1.0, -1.0})
		for (size_t i = border; i < face.points.size(); ++i)
			mesh.vertices.push_back(place(face.points[i], side * lift(glyph, face, i)));
	const auto front = [&](int i) { return uint32_t(rows * border + size_t(i)); };
	const auto back = [&](int i)
	{ return uint32_t(size_t(i) < border ? size_t(i) : rows * border + size_t(i) + inner); };
	for (const auto& t : face.triangles)
	{
		mesh.triangles.push_back({front(t[0]), front(t[1]), front(t[2])});
		mesh.triangles.push_back({back(t[0]), back(t[2]), back(t[1])});
	}
	for (size_t loop = 0; loop + 1 < face.loopStarts.size(); ++loop)
		for (size_t i = face.loopStarts[loop]; i < face.loopStarts[loop + 1]; ++i)
			for (size_t row = 0; row < rows; ++row)
			{
				const size_t next = i + 1 < face.loopStarts[loop + 1] ? i + 1 : face.loopStarts[loop];
				const uint32_t a = uint32_t(row * border + i), b = uint32_t(row * border + next);
				const uint32_t c = uint32_t(b + border), d = uint32_t(a + border);
				mesh.triangles.push_back({a, b, c});
				mesh.triangles.push_back({a, c, d});
			}
	return mesh;
}

// Edge lengths whose count is close to the wanted one: secant steps on count ~ edge^-2, then small changes.
std::vector<double> edgeCandidates(const Glyph& glyph, const Outline& outline, size_t triangles)
{
	double edge = std::sqrt(1100.0 / double(triangles));
	for (int i = 0; i < 5; ++i)
	{
		const double count = double(solidCount(makeFace(glyph, outline, edge), edge));
		edge *= std::sqrt(count / double(triangles));
	}
	std::vector<double> candidates;
	for (int i = 0; i <= 24; ++i) candidates.push_back(edge * (1 + 0.005 * (i % 2 ? 1 : -1) * ((i + 1) / 2)));
	return candidates;
}
}  // namespace

ModelMesh makeDigit(int digit, size_t triangles)
{
	const Glyph glyph(digit);
	const Outline outline = {glyph.contours(0), glyph.contours(BEVEL)};
	Face best;
	double bestEdge = 0;
	const auto error = [&](size_t count) { return count > triangles ? count - triangles : triangles - count; };
	for (const double edge : edgeCandidates(glyph, outline, triangles))
	{
		const Face face = makeFace(glyph, outline, edge);
		if (!isValid(face)) continue;
		if (bestEdge > 0 && error(solidCount(face, edge)) >= error(solidCount(best, bestEdge))) continue;
		best = face;
		bestEdge = edge;
	}
	return bestEdge > 0 ? extrude(glyph, best, bestEdge) : ModelMesh{};
}
}  // namespace clod::demo
