// SPDX-License-Identifier: Zlib
// A page that needs nothing but itself: escaped text, files as data, and plots as SVG whose points tell their values
// when pointed at.
#pragma once
#include <string>
#include <vector>

namespace clod::demo
{
std::string escaped(const std::string& text);
// The file's bytes as a data: address; empty where it cannot be read.
std::string dataAddress(const std::string& path, const std::string& mediaType);

// Cells are HTML; the first column is a row's head.
struct HtmlTable
{
	std::string caption;
	std::vector<std::string> head;
	std::vector<std::vector<std::string>> rows;
};
std::string toHtml(const HtmlTable& table);

struct PlotPoint
{
	double x, y;
	std::string label;  // shown when pointed at
};
struct PlotSeries
{
	std::string name, color;  // #rrggbb
	std::vector<PlotPoint> points;
	bool isLine = false;  // points joined and not marked
};
struct Plot
{
	std::string title, description;  // the latter for those who do not see it
	std::string xAxis, yAxis;
	bool isXLogarithmic = false, isYLogarithmic = false;
	double smallestY = 0;  // on a logarithmic axis, what lies below is drawn here
	std::vector<PlotSeries> series;
};
// Points that are not finite are left out.
std::string toSvg(const Plot& plot);

// The document: a title and its body.
std::string page(const std::string& title, const std::string& body);
}  // namespace clod::demo
