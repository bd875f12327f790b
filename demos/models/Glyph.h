// SPDX-License-Identifier: Zlib
// The outline of a digit drawn with a round pen: strokes (arcs and lines) joined smoothly. Millimetres, 20 mm tall.
#pragma once
#include <vector>

namespace clod::demo
{
struct GlyphPoint
{
	double x = 0, y = 0;
};

constexpr double GLYPH_PEN = 1.6;  // half the stroke's width
constexpr double GLYPH_WIDTH = 12.6, GLYPH_HEIGHT = 20;

class Glyph
{
public:
	explicit Glyph(int digit);

	// How deep a point lies in the ink: positive inside, about the distance from the outline.
	double depth(GlyphPoint p) const;
	// The closed curves of one depth, ink on their left.
	std::vector<std::vector<GlyphPoint>> contours(double level) const;
	// The point moved along the gradient to the given depth.
	GlyphPoint moved(GlyphPoint p, double level) const;

private:
	using Stroke = std::vector<GlyphPoint>;
	void line(std::vector<GlyphPoint> points) { m_strokes.push_back(std::move(points)); }
	// Angles in degrees; `tail` continues the stroke in straight lines.
	void arc(GlyphPoint centre, GlyphPoint radius, double from, double to, std::vector<GlyphPoint> tail = {});
	void curve(GlyphPoint a, GlyphPoint control, GlyphPoint b);
	std::vector<Stroke> m_strokes;
};
}  // namespace clod::demo
