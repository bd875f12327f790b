// SPDX-License-Identifier: Zlib
// Contours: marching squares (Lorensen & Cline 1987 in the plane) on a fixed fine grid, then Newton steps.
#include "demos/models/Glyph.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace clod::demo
{
namespace
{
constexpr double PI = 3.14159265358979323846;
constexpr double JOIN = 1.2;    // strokes nearer than this flow into each other
constexpr double CELL = 0.125;  // of the contour grid
constexpr double GRID_MARGIN = 1;

double distanceToSegment(GlyphPoint p, GlyphPoint a, GlyphPoint b)
{
	const double dx = b.x - a.x, dy = b.y - a.y;
	const double t = std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
	return std::hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
}

double smoothMinimum(double a, double b)
{
	const double h = std::max(0.0, 1 - std::fabs(a - b) / JOIN);
	return std::min(a, b) - 0.25 * JOIN * h * h;
}

// Where a contour crosses a grid edge: the edge's lower corner, and 0 along x or 1 along y.
using Crossing = std::array<int, 3>;

struct DepthGrid
{
	int columns = int((GLYPH_WIDTH + 2 * GRID_MARGIN) / CELL), rows = int((GLYPH_HEIGHT + 2 * GRID_MARGIN) / CELL);
	std::vector<double> values;  // depth over the contour's level, row by row
	static GlyphPoint corner(int i, int j) { return {i * CELL - GRID_MARGIN, j * CELL - GRID_MARGIN}; }
	double at(int i, int j) const { return values[size_t(j * (columns + 1) + i)]; }
	GlyphPoint point(const Crossing& c) const
	{
		const int i = c[0] + (c[2] == 0 ? 1 : 0), j = c[1] + (c[2] == 0 ? 0 : 1);
		const GlyphPoint a = corner(c[0], c[1]), b = corner(i, j);
		const double t = at(c[0], c[1]) / (at(c[0], c[1]) - at(i, j));
		return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)};
	}
};

// Adds the contour's pieces in a cell, from crossing to crossing with the ink on their left.
void linkCell(const DepthGrid& grid, int i, int j, std::map<Crossing, Crossing>& next)
{
	const bool ink[4] = {grid.at(i, j) > 0, grid.at(i + 1, j) > 0, grid.at(i + 1, j + 1) > 0, grid.at(i, j + 1) > 0};
	const Crossing edges[4] = {{i, j, 0}, {i + 1, j, 1}, {i, j + 1, 0}, {i, j, 1}};
	// Round the cell counter-clockwise: a piece leads from where ink ends back to where that ink began.
	for (int end = 0; end < 4; ++end)
	{
		if (!ink[end] || ink[(end + 1) % 4]) continue;
		int begin = end;
		while (ink[begin]) begin = (begin + 3) % 4;
		next[edges[end]] = edges[begin];
	}
}
}  // namespace

void Glyph::arc(GlyphPoint centre, GlyphPoint radius, double from, double to, std::vector<GlyphPoint> tail)
{
	constexpr int PIECES = 48;
	Stroke stroke;
	for (int i = 0; i <= PIECES; ++i)
	{
		const double angle = PI / 180 * (from + (to - from) * i / PIECES);
		stroke.push_back({centre.x + radius.x * std::cos(angle), centre.y + radius.y * std::sin(angle)});
	}
	stroke.insert(stroke.end(), tail.begin(), tail.end());
	m_strokes.push_back(stroke);
}

void Glyph::curve(GlyphPoint a, GlyphPoint control, GlyphPoint b)
{
	constexpr int PIECES = 24;
	Stroke stroke;
	for (int i = 0; i <= PIECES; ++i)
	{
		const double t = double(i) / PIECES, u = 1 - t;
		stroke.push_back(
			{u * u * a.x + 2 * u * t * control.x + t * t * b.x, u * u * a.y + 2 * u * t * control.y + t * t * b.y});
	}
	m_strokes.push_back(stroke);
}

Glyph::Glyph(int digit)
{
	switch (digit)
	{
		case 0:
			arc({6.3, 10}, {4.7, 8.4}, 0, 360);
			break;
		case 1:
			line({{2.6, 14.6}, {6.6, 18.4}, {6.6, 3.4}});
			line({{2.8, 1.6}, {10.2, 1.6}});
			break;
		case 2:
			arc({6.2, 13.8}, {4.4, 4.6}, 165, -38, {{2.0, 1.6}, {10.9, 1.6}});
			break;
		case 3:
			arc({5.9, 14.4}, {4.1, 4.0}, 150, -90);
			arc({5.9, 6.0}, {4.6, 4.4}, 90, -150);
			break;
		case 4:
			line({{9.0, 1.6}, {9.0, 18.4}, {1.6, 6.3}, {11.2, 6.3}});
			break;
		case 5:
			arc({6.0, 6.6}, {5.0, 5.0}, -145, 129, {{3.6, 18.4}, {9.9, 18.4}});
			break;
		case 6:
			arc({6.3, 6.4}, {4.7, 4.8}, 0, 360);
			curve({1.6, 6.4}, {1.6, 14.6}, {8.9, 18.4});
			break;
		case 7:
			line({{1.8, 18.4}, {10.8, 18.4}, {5.0, 1.6}});
			break;
		case 8:
			arc({6.3, 14.4}, {4.0, 4.0}, 0, 360);
			arc({6.3, 6.0}, {4.7, 4.4}, 0, 360);
			break;
		default:
			arc({6.3, 13.6}, {4.7, 4.8}, 0, 360);
			curve({11.0, 13.6}, {11.0, 5.4}, {3.7, 1.6});
	}
}

double Glyph::depth(GlyphPoint p) const
{
	double result = 0;
	for (size_t i = 0; i < m_strokes.size(); ++i)
	{
		const Stroke& stroke = m_strokes[i];
		double nearest = distanceToSegment(p, stroke[0], stroke[1]);
		for (size_t k = 1; k + 1 < stroke.size(); ++k)
			nearest = std::min(nearest, distanceToSegment(p, stroke[k], stroke[k + 1]));
		result = i == 0 ? nearest : smoothMinimum(result, nearest);
	}
	return GLYPH_PEN - result;
}

GlyphPoint Glyph::moved(GlyphPoint p, double level) const
{
	constexpr double STEP = 1e-5;
	for (int i = 0; i < 6; ++i)
	{
		const double gx = (depth({p.x + STEP, p.y}) - depth({p.x - STEP, p.y})) / (2 * STEP);
		const double gy = (depth({p.x, p.y + STEP}) - depth({p.x, p.y - STEP})) / (2 * STEP);
		const double move = (level - depth(p)) / std::max(0.25, gx * gx + gy * gy);
		p = {p.x + move * gx, p.y + move * gy};
	}
	return p;
}

std::vector<std::vector<GlyphPoint>> Glyph::contours(double level) const
{
	DepthGrid grid;
	for (int j = 0; j <= grid.rows; ++j)
		for (int i = 0; i <= grid.columns; ++i) grid.values.push_back(depth(DepthGrid::corner(i, j)) - level);
	std::map<Crossing, Crossing> next;
	for (int j = 0; j < grid.rows; ++j)
		for (int i = 0; i < grid.columns; ++i) linkCell(grid, i, j, next);
	std::vector<std::vector<GlyphPoint>> loops;
	while (!next.empty())
	{
		std::vector<GlyphPoint> loop;
		Crossing crossing = next.begin()->first;
		for (auto step = next.find(crossing); step != next.end(); step = next.find(crossing))
		{
			loop.push_back(grid.point(crossing));
			crossing = step->second;
			next.erase(step);
		}
		loops.push_back(loop);
	}
	return loops;
}
}  // namespace clod::demo
