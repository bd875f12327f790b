// SPDX-License-Identifier: Zlib
// Words and keys over a picture, and pictures put together into sheets (cairo, DejaVu Sans).
#pragma once
#include <string>
#include <vector>

#include "demos/render/Image.h"
#include "demos/render/Renderer.h"

namespace clod::demo
{
struct LegendEntry
{
	Color color;
	std::string label;  // e.g. "up to 0.3 mm"
};

struct OverlayText
{
	std::string title;                // bold, top left
	std::string subtitle;             // one line under it: what the picture shows
	std::vector<std::string> lines;   // below: figures of this frame
	std::string legendTitle;          // e.g. "Certified error of the patches"
	std::vector<LegendEntry> legend;  // right side, first entry on top
	std::string footer;               // bottom left, e.g. "step 480 of 1200, t = 2.000 s"
	std::string footnote;             // bottom, small, over the footer: explains the symbols
	double pixelsPerMetre = 0;        // > 0: a scale bar, bottom right (Camera::pixelsPerMetre)
};

void drawOverlay(Image& image, const OverlayText& text);
// The picture with the same words above and below it, where they hide nothing. The same height for any words.
Image captioned(const Image& picture, const OverlayText& text);

struct CaptionedImage
{
	Image image;
	std::string caption;  // under the picture
};

// Pictures in rows of `columns`, each `cellWidth` pixels wide (0: as they are), under a title.
Image contactSheet(const std::vector<CaptionedImage>& cells, int columns, int cellWidth, const std::string& title);
// Pictures beside each other, at their own size, captions on top, under a title.
Image sideBySide(const std::vector<CaptionedImage>& cells, const std::string& title);
}  // namespace clod::demo
