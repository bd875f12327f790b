// SPDX-License-Identifier: Zlib
#include "demos/trial/Html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/Files.h"

namespace clod::demo
{
namespace
{
constexpr double kWidth = 860, kHeight = 420, kLeft = 74, kRight = 16, kTop = 16, kBottom = 52;
constexpr double kLegendRow = 20;
constexpr std::size_t kMostBytes = std::size_t(1) << 28;

constexpr const char* kStyle = R"(
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1f29; background: #fff; margin: 0 auto; max-width: 60rem; padding: 1rem; }
h1, p { overflow-wrap: anywhere; } h1 { font-size: 1.6rem; line-height: 1.25; } h2 { font-size: 1.25rem; margin-top: 2.2rem; }
img, video, svg { width: 100%; height: auto; display: block; background: #fff; }
figure { margin: 1rem 0; } figcaption { color: #4d5461; font-size: .9rem; }
figure, .scroll { overflow-x: auto; } svg { min-width: 40rem; } table { border-collapse: collapse; width: 100%; font-size: .92rem; }
caption { color: #4d5461; padding-bottom: .3rem; } caption, figcaption { position: sticky; left: 0; }
caption { text-align: left; max-width: calc(100vw - 2rem); }
th, td { text-align: left; padding: .3rem .7rem .3rem 0; border-bottom: 1px solid #d8dce3; vertical-align: top; overflow-wrap: break-word; min-width: 4.5rem; }
pre { background: #f3f5f8; padding: .8rem; overflow-x: auto; } code { font-family: ui-monospace, monospace; font-size: .9em; }
th[scope=row] { min-width: 8rem; } small { font-weight: 400; }
.good { color: #1b6b3a; } .bad { color: #a32020; }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 22rem), 1fr)); gap: 1rem; }
svg text { font: 13px system-ui, sans-serif; fill: #1a1f29; } svg .dot { opacity: .9; } svg .dot:hover { stroke: #000; stroke-width: 2; }
)";

struct Axis
{
	double low = 0, high = 1;
	bool isLogarithmic = false;
	double from = 0, to = 1;  // pixels
	double place(double value) const
	{
		const double share = isLogarithmic
								 ? (std::log10(value) - std::log10(low)) / (std::log10(high) - std::log10(low))
								 : (value - low) / (high - low);
		return from + share * (to - from);
	}
	std::vector<double> ticks() const
	{
		std::vector<double> ticks;
		if (isLogarithmic)
		{
			const bool isShort = high / low < 1e3;
			for (double decade = std::pow(10, std::floor(std::log10(low))); decade <= high * 1.0001; decade *= 10)
				for (const double step : {1.0, 2.0, 5.0})
					if ((step == 1 || isShort) && decade * step >= low * 0.9999 && decade * step <= high * 1.0001)
						ticks.push_back(decade * step);
			return ticks;
		}
		const double rough = (high - low) / 6, decade = std::pow(10, std::floor(std::log10(rough)));
		double step = 10 * decade;
		for (const double factor : {5.0, 2.0, 1.0})
			if (factor * decade >= rough) step = factor * decade;
		for (double k = std::ceil(low / step); k * step <= high * 1.0001; ++k) ticks.push_back(k * step);
		return ticks;
	}
};

Axis axisOf(const std::vector<double>& values, bool isLogarithmic, double from, double to)
{
	Axis axis{0, 1, isLogarithmic, from, to};
	if (values.empty()) return axis;
	const auto [low, high] = std::minmax_element(values.begin(), values.end());
	if (isLogarithmic)
	{
		axis.low = *low / 1.3;
		axis.high = *high * 1.3;
		return axis;
	}
	axis.low = std::min(0.0, *low);
	axis.high = *high > axis.low ? *high + 0.05 * (*high - axis.low) : axis.low + 1;
	return axis;
}

bool isDrawn(const Plot& plot, const PlotPoint& point)
{
	return std::isfinite(point.x) && std::isfinite(point.y) && (!plot.isXLogarithmic || point.x > 0);
}

double drawnY(const Plot& plot, double y)
{
	return plot.isYLogarithmic ? std::max(y, plot.smallestY) : y;
}

std::string drawAxes(const Plot& plot, const Axis& x, const Axis& y)
{
	std::string text;
	for (const double tick : x.ticks())
		text += fmt::format(
			"<line x1='{0:.1f}' x2='{0:.1f}' y1='{1}' y2='{2}' stroke='#e1e4ea'/>"
			"<text x='{0:.1f}' y='{3}' text-anchor='middle'>{4:g}</text>\n",
			x.place(tick), kTop, kHeight - kBottom, kHeight - kBottom + 18, tick);
	for (const double tick : y.ticks())
		text += fmt::format(
			"<line x1='{0}' x2='{1}' y1='{2:.1f}' y2='{2:.1f}' stroke='#e1e4ea'/>"
			"<text x='{3}' y='{4:.1f}' text-anchor='end'>{5:g}</text>\n",
			kLeft, kWidth - kRight, y.place(tick), kLeft - 6, y.place(tick) + 4, tick);
	text += fmt::format("<text x='{}' y='{}' text-anchor='middle'>{}</text>\n", (kLeft + kWidth - kRight) / 2,
						kHeight - 12, escaped(plot.xAxis));
	text += fmt::format("<text transform='translate(16 {}) rotate(-90)' text-anchor='middle'>{}</text>\n",
						(kTop + kHeight - kBottom) / 2, escaped(plot.yAxis));
	return text;
}

std::string drawSeries(const Plot& plot, const PlotSeries& series, const Axis& x, const Axis& y)
{
	std::string line, dots;
	for (const PlotPoint& point : series.points)
	{
		if (!isDrawn(plot, point)) continue;
		const double left = x.place(point.x), top = y.place(drawnY(plot, point.y));
		line += fmt::format("{:.1f},{:.1f} ", left, top);
		dots += fmt::format(
			"<circle class='dot' cx='{:.1f}' cy='{:.1f}' r='{}' fill='{}'{}><title>{}</title></circle>\n", left, top,
			series.isLine ? 6 : 5, series.color, series.isLine ? " fill-opacity='0'" : "", escaped(point.label));
	}
	if (series.isLine)
		dots = fmt::format("<polyline points='{}' fill='none' stroke='{}' stroke-width='1.6'/>\n", line, series.color) +
			   dots;
	return dots;
}

std::string drawLegend(const Plot& plot)
{
	std::string text;
	double top = kHeight + 6;
	for (const PlotSeries& series : plot.series)
	{
		text += fmt::format("<rect x='{}' y='{}' width='14' height='10' fill='{}'/><text x='{}' y='{}'>{}</text>\n",
							kLeft, top, series.color, kLeft + 22, top + 10, escaped(series.name));
		top += kLegendRow;
	}
	return text;
}

std::string base64(const std::vector<std::byte>& bytes)
{
	constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
	std::string text;
	text.reserve((bytes.size() + 2) / 3 * 4);
	for (std::size_t i = 0; i < bytes.size(); i += 3)
	{
		const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
		std::uint32_t word = 0;
		for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (k < count ? std::uint32_t(bytes[i + k]) : 0);
		for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[word >> (18 - 6 * k) & 63] : '=';
	}
	return text;
}
}  // namespace

std::string escaped(const std::string& text)
{
	std::string result;
	for (const char c : text) switch (c)
		{
			case '&':
				result += "&amp;";
				break;
			case '<':
				result += "&lt;";
				break;
			case '>':
				result += "&gt;";
				break;
			case '"':
				result += "&quot;";
				break;
			case '\'':
				result += "&#39;";
				break;
			default:
				result += c;
		}
	return result;
}

std::string dataAddress(const std::string& path, const std::string& mediaType)
{
	const Result<std::vector<std::byte>> bytes = cli::readFile(path, kMostBytes);
	return bytes ? "data:" + mediaType + ";base64," + base64(bytes.value()) : std::string();
}

std::string toHtml(const HtmlTable& table)
{
	std::string text = "<div class='scroll'><table><caption>" + escaped(table.caption) + "</caption><thead><tr>";
	for (const std::string& cell : table.head) text += "<th scope='col'>" + cell + "</th>";
	text += "</tr></thead><tbody>\n";
	for (const std::vector<std::string>& row : table.rows)
	{
		text += "<tr>";
		for (std::size_t i = 0; i < row.size(); ++i)
			text += i == 0 ? "<th scope='row'>" + row[i] + "</th>" : "<td>" + row[i] + "</td>";
		text += "</tr>\n";
	}
	return text + "</tbody></table></div>\n";
}

std::string toSvg(const Plot& plot)
{
	std::vector<double> xs, ys;
	for (const PlotSeries& series : plot.series)
		for (const PlotPoint& point : series.points)
			if (isDrawn(plot, point)) xs.push_back(point.x), ys.push_back(drawnY(plot, point.y));
	const Axis x = axisOf(xs, plot.isXLogarithmic, kLeft, kWidth - kRight);
	const Axis y = axisOf(ys, plot.isYLogarithmic, kHeight - kBottom, kTop);
	std::string text = fmt::format("<figure><svg role='img' viewBox='0 0 {} {}'><title>{}</title><desc>{}</desc>\n",
								   kWidth, kHeight + kLegendRow * double(plot.series.size()) + 8, escaped(plot.title),
								   escaped(plot.description));
	text += drawAxes(plot, x, y);
	for (const PlotSeries& series : plot.series) text += drawSeries(plot, series, x, y);
	text += drawLegend(plot);
	return text + "</svg><figcaption>" + escaped(plot.title) +
		   " Point at a mark for its values.</figcaption></figure>\n";
}

std::string page(const std::string& title, const std::string& body)
{
	return "<!DOCTYPE html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'>\n"
		   "<meta name='viewport' content='width=device-width, initial-scale=1'>\n<title>" +
		   escaped(title) + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<main>\n" + body +
		   "</main>\n</body>\n</html>\n";
}
}  // namespace clod::demo
