// SPDX-License-Identifier: Zlib
#include "demos/render/Overlay.h"

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>

#include "demos/render/MetricLength.h"

namespace clod::demo
{
namespace
{
constexpr double PAD = 10;
const Color INK = {0.10f, 0.12f, 0.16f, 1}, PALE_INK = {0.30f, 0.33f, 0.38f, 1};
const Color PANEL = {1, 1, 1, 0.80f}, PAPER = {1, 1, 1, 1};

enum class Weight
{
	Normal,
	Bold,
};

struct Font
{
	double size;
	Weight weight;
};

// Draws on an image through cairo; the pixels come back when the canvas goes.
class Canvas
{
public:
	explicit Canvas(Image& image) : m_image(image)
	{
		m_surface.reset(cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width, image.height));
		cairo_surface_flush(m_surface.get());
		for (int y = 0; y < image.height; ++y)
			for (int x = 0; x < image.width; ++x)
			{
				const uint8_t* p = image.rgba.data() + 4 * (size_t(y) * size_t(image.width) + size_t(x));
				pixel(x, y) = uint32_t(p[0]) << 16 | uint32_t(p[1]) << 8 | p[2];
			}
		cairo_surface_mark_dirty(m_surface.get());
		m_cairo.reset(cairo_create(m_surface.get()));
	}

	~Canvas()
	{
		cairo_surface_flush(m_surface.get());
		for (int y = 0; y < m_image.height; ++y)
			for (int x = 0; x < m_image.width; ++x)
			{
				uint8_t* p = m_image.rgba.data() + 4 * (size_t(y) * size_t(m_image.width) + size_t(x));
				const uint32_t v = pixel(x, y);
				p[0] = uint8_t(v >> 16);
				p[1] = uint8_t(v >> 8);
				p[2] = uint8_t(v);
				p[3] = 255;
			}
	}
	Canvas(const Canvas&) = delete;
	Canvas& operator=(const Canvas&) = delete;

	double textWidth(const std::string& text, const Font& font)
	{
		select(font);
		cairo_text_extents_t extents;
		cairo_text_extents(m_cairo.get(), text.c_str(), &extents);
		return extents.x_advance;
	}

	// Baseline starts at (x, y).
	void text(const std::string& text, double x, double y, const Font& font, const Color& color)
	{
		select(font);
		source(color);
		cairo_move_to(m_cairo.get(), x, y);
		cairo_show_text(m_cairo.get(), text.c_str());
	}

	void box(double x, double y, double width, double height, const Color& color)
	{
		source(color);
		cairo_rectangle(m_cairo.get(), x, y, width, height);
		cairo_fill(m_cairo.get());
	}

private:
	struct Free
	{
		void operator()(cairo_surface_t* s) const { cairo_surface_destroy(s); }
		void operator()(cairo_t* c) const { cairo_destroy(c); }
	};

	void select(const Font& font)
	{
		cairo_select_font_face(m_cairo.get(), "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
							   font.weight == Weight::Bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
		cairo_set_font_size(m_cairo.get(), font.size);
	}
	void source(const Color& c) { cairo_set_source_rgba(m_cairo.get(), c.r, c.g, c.b, c.a); }
	uint32_t& pixel(int x, int y)
	{
		unsigned char* row = cairo_image_surface_get_data(m_surface.get()) +
							 size_t(y) * size_t(cairo_image_surface_get_stride(m_surface.get()));
		return reinterpret_cast<uint32_t*>(row)[x];
	}

	Image& m_image;
	std::unique_ptr<cairo_surface_t, Free> m_surface;
	std::unique_ptr<cairo_t, Free> m_cairo;
};

// Sizes grow with the picture, from a 960-pixel-wide one; smaller text than that could not be read.
double unit(const Image& image)
{
	return std::max(1.0, image.width / 960.0);
}

void paste(Image& target, const Image& source, int left, int top)
{
	for (int y = 0; y < source.height; ++y)
		std::copy_n(source.rgba.begin() + std::ptrdiff_t(4) * y * source.width, 4 * source.width,
					target.rgba.begin() + std::ptrdiff_t(4) * ((std::ptrdiff_t(top) + y) * target.width + left));
}

struct TextRow
{
	std::string text;
	Font font;
	Color color;
};

// Rows of text on a panel, its top left corner at (x, y).
void drawRows(Canvas& canvas, const std::vector<TextRow>& rows, double x, double y, double scale)
{
	double width = 0, height = 0;
	for (const TextRow& row : rows)
	{
		width = std::max(width, canvas.textWidth(row.text, row.font));
		height += 1.35 * row.font.size;
	}
	if (rows.empty()) return;
	canvas.box(x, y, width + 2 * PAD * scale, height + PAD * scale, PANEL);
	double base = y + 0.4 * PAD * scale;
	for (const TextRow& row : rows)
	{
		base += 1.35 * row.font.size;
		canvas.text(row.text, x + PAD * scale, base - 0.3 * row.font.size, row.font, row.color);
	}
}

// Rows that are too wide, broken at spaces.
std::vector<TextRow> wrapped(Canvas& canvas, const std::vector<TextRow>& rows, double width)
{
	std::vector<TextRow> result;
	for (const TextRow& row : rows)
	{
		std::string line;
		std::istringstream words(row.text);
		for (std::string word; words >> word;)
		{
			const std::string longer = line.empty() ? word : line + " " + word;
			if (!line.empty() && canvas.textWidth(longer, row.font) > width)
			{
				result.push_back({line, row.font, row.color});
				line = word;
			}
			else
				line = longer;
		}
		result.push_back({line, row.font, row.color});
	}
	return result;
}

double rowsHeight(const std::vector<TextRow>& rows, double scale)
{
	double height = PAD * scale;
	for (const TextRow& row : rows) height += 1.35 * row.font.size;
	return height;
}

// In the upper right corner. Returns the width that it takes from what stands on the left.
double drawLegend(Canvas& canvas, const Image& image, const OverlayText& text, double scale)
{
	if (text.legend.empty()) return 0;
	const Font head = {13 * scale, Weight::Bold}, body = {13 * scale, Weight::Normal};
	const double swatch = 13 * scale, rowHeight = 19 * scale;
	double width = canvas.textWidth(text.legendTitle, head);
	for (const LegendEntry& e : text.legend)
		width = std::max(width, canvas.textWidth(e.label, body) + swatch + 8 * scale);
	width += 2 * PAD * scale;
	const double x = image.width - width - PAD * scale, y = PAD * scale;
	canvas.box(x, y, width, rowHeight * (double(text.legend.size()) + 1) + PAD * scale, PANEL);
	double base = y + 0.5 * PAD * scale + 0.72 * rowHeight;
	canvas.text(text.legendTitle, x + PAD * scale, base, head, INK);
	for (const LegendEntry& e : text.legend)
	{
		base += rowHeight;
		canvas.box(x + PAD * scale, base - 0.85 * swatch, swatch, swatch, e.color);
		canvas.text(e.label, x + PAD * scale + swatch + 8 * scale, base, body, INK);
	}
	return width + PAD * scale;
}

// Metres: the largest of 1, 2, 5 x 10^k that is at most a fifth of the picture wide.
double scaleBarLength(double pixelsPerMetre, int width)
{
	const double limit = 0.2 * width / pixelsPerMetre;
	const double decade = std::pow(10.0, std::floor(std::log10(limit)));
	for (const double step : {5.0, 2.0})
		if (step * decade <= limit) return step * decade;
	return decade;
}

void drawScaleBar(Canvas& canvas, const Image& image, double pixelsPerMetre, double scale)
{
	if (!(pixelsPerMetre > 0)) return;
	const double metres = scaleBarLength(pixelsPerMetre, image.width), bar = metres * pixelsPerMetre;
	const std::string label = metricLength(metres);
	const Font font = {13 * scale, Weight::Normal};
	const double labelWidth = canvas.textWidth(label, font), width = std::max(bar, labelWidth) + 2 * PAD * scale;
	const double height = 36 * scale, x = image.width - width - PAD * scale, y = image.height - height - PAD * scale;
	canvas.box(x, y, width, height, PANEL);
	const double left = x + (width - bar) / 2, line = y + height - 10 * scale, tick = 2 * scale;
	canvas.box(left, line - tick / 2, bar, tick, INK);
	canvas.box(left, line - 4 * scale, tick, 8 * scale, INK);
	canvas.box(left + bar - tick, line - 4 * scale, tick, 8 * scale, INK);
	canvas.text(label, x + (width - labelWidth) / 2, y + 16 * scale, font, INK);
}
}  // namespace

void drawOverlay(Image& image, const OverlayText& text)
{
	const double scale = unit(image);
	Canvas canvas(image);
	std::vector<TextRow> head;
	if (!text.title.empty()) head.push_back({text.title, {19 * scale, Weight::Bold}, INK});
	if (!text.subtitle.empty()) head.push_back({text.subtitle, {13 * scale, Weight::Normal}, PALE_INK});
	for (const std::string& line : text.lines) head.push_back({line, {14 * scale, Weight::Normal}, INK});
	const double width = image.width - 4 * PAD * scale;
	head = wrapped(canvas, head, width - drawLegend(canvas, image, text, scale));
	drawRows(canvas, head, PAD * scale, PAD * scale, scale);
	std::vector<TextRow> foot;
	if (!text.footnote.empty()) foot.push_back({text.footnote, {12 * scale, Weight::Normal}, PALE_INK});
	if (!text.footer.empty()) foot.push_back({text.footer, {14 * scale, Weight::Bold}, INK});
	foot = wrapped(canvas, foot, width);
	drawRows(canvas, foot, PAD * scale, image.height - PAD * scale - rowsHeight(foot, scale), scale);
	drawScaleBar(canvas, image, text.pixelsPerMetre, scale);
}

Image captioned(const Image& picture, const OverlayText& text)
{
	constexpr double kAbove = 168, kBelow = 78;  // seven rows of words with a title; three
	const int above = int(kAbove * unit(picture)), below = int(kBelow * unit(picture));
	Image image(picture.width, above + picture.height + below, PAPER);
	paste(image, picture, 0, above);
	drawOverlay(image, text);
	return image;
}

namespace
{
constexpr int GUTTER = 10, CAPTION_HEIGHT = 26, TITLE_HEIGHT = 42;

struct Grid
{
	int columns, rows, cellWidth, cellHeight, titleHeight, captionHeight;
	int left(int i) const { return GUTTER + (i % columns) * (cellWidth + GUTTER); }
	int top(int i) const { return titleHeight + GUTTER + (i / columns) * (cellHeight + captionHeight + GUTTER); }
	int width() const { return left(columns - 1) + cellWidth + GUTTER; }
	int height() const { return titleHeight + GUTTER + rows * (cellHeight + captionHeight + GUTTER); }
};

Image composed(const std::vector<CaptionedImage>& cells, int columns, const std::string& title, bool captionsOnTop)
{
	Grid grid = {std::max(1, std::min(columns, int(cells.size()))), 0, 1, 1, title.empty() ? 0 : TITLE_HEIGHT, 0};
	grid.rows = (int(cells.size()) + grid.columns - 1) / grid.columns;
	for (const CaptionedImage& cell : cells)
	{
		grid.cellWidth = std::max(grid.cellWidth, cell.image.width);
		grid.cellHeight = std::max(grid.cellHeight, cell.image.height);
		if (!cell.caption.empty()) grid.captionHeight = CAPTION_HEIGHT;
	}
	Image sheet(grid.width(), grid.height(), PAPER);
	for (int i = 0; i < int(cells.size()); ++i)
		paste(sheet, cells[size_t(i)].image, grid.left(i), grid.top(i) + (captionsOnTop ? grid.captionHeight : 0));
	Canvas canvas(sheet);
	canvas.text(title, GUTTER, TITLE_HEIGHT - 13, {20, Weight::Bold}, INK);
	const Font font = {15, captionsOnTop ? Weight::Bold : Weight::Normal};
	for (int i = 0; i < int(cells.size()); ++i)
	{
		const int base = grid.top(i) + (captionsOnTop ? 0 : grid.cellHeight) + grid.captionHeight - 8;
		canvas.text(cells[size_t(i)].caption, grid.left(i) + 2, base, font, INK);
	}
	return sheet;
}
}  // namespace

Image contactSheet(const std::vector<CaptionedImage>& cells, int columns, int cellWidth, const std::string& title)
{
	std::vector<CaptionedImage> scaled = cells;
	for (CaptionedImage& cell : scaled)
		if (cellWidth > 0 && cell.image.width > 0)
			cell.image = resized(cell.image, cellWidth, std::max(1, cell.image.height * cellWidth / cell.image.width));
	return composed(scaled, columns, title, false);
}

Image sideBySide(const std::vector<CaptionedImage>& cells, const std::string& title)
{
	return composed(cells, int(cells.size()), title, true);
}
}  // namespace clod::demo
