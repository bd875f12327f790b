// SPDX-License-Identifier: Zlib
// The trade-off as a picture: four panels over the median time, drawn by gnuplot.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "demos/peers/Tradeoff.h"
#include "demos/runner/Gnuplot.h"

namespace clod::demo
{
namespace
{
// Smaller errors are drawn at these: an axis in decades has no zero.
constexpr double kSmallestPercent = 0.001;  // % of the radius
constexpr double kSmallestAngle = 0.1;      // degrees

struct Look
{
	const char* family;
	const char* title;
	const char* color;
	int marker;  // gnuplot's point type
	const char* labels = "left offset 0.8,0.5";
};
// Okabe & Ito's colours, told apart by colour-blind readers too. Filled markers: whole dispatches; open: queries. On
// the full meshes our own query is met twice, hence the labels on the other side.
constexpr Look kLooks[] = {{"clod", "CLOD, contacts", "#000000", 4},
						   {"clod-gap", "CLOD, contacts and gap", "#000000", 2},
						   {"clod-dispatch", "CLOD in Bullet (dispatch)", "#000000", 5},
						   {"decimated-exact", "our exact query, decimated", "#999999", 8, "right offset -0.8,-0.6"},
						   {"coal-contacts", "Coal, all contacts", "#0072B2", 6},
						   {"coal-distance", "Coal, closest pair", "#56B4E9", 12},
						   {"gimpact", "GImpact (dispatch)", "#D55E00", 7},
						   {"bvh-gimpact", "triangle mesh x GImpact (dispatch)", "#E69F00", 9},
						   {"vhacd", "V-HACD hulls (dispatch)", "#009E73", 11},
						   {"coacd", "CoACD hulls (dispatch)", "#CC79A7", 13}};

struct Panel
{
	const char* title;
	const char* axis;
	double (*value)(const TradeoffPoint&, double radius);
	bool decades;
	const char* range;
};

double drawn(double value, double smallest)
{
	return std::max(value, smallest);
}

const Panel kPanels[] = {
	{"Error of the gap, median over the rows", "% of the smaller radius",
	 [](const TradeoffPoint& p, double r) { return drawn(100 * p.accuracy.gapMedian / r, kSmallestPercent); }, true,
	 "[0.0009:]"},
	{"Error of the gap, 95th percentile; lines: fronts", "% of the smaller radius",
	 [](const TradeoffPoint& p, double r) { return drawn(100 * p.accuracy.gapP95 / r, kSmallestPercent); }, true,
	 "[0.0009:]"},
	{"Error of the normals, median over the rows", "degrees",
	 [](const TradeoffPoint& p, double) { return drawn(p.accuracy.normalMedian, kSmallestAngle); }, true, "[0.09:100]"},
	{"Coverage: exact contacts with a reported one near, within 20 degrees", "% of the exact contacts",
	 [](const TradeoffPoint& p, double) { return 100 * p.accuracy.coveredMean; }, false, "[-2:106]"}};
constexpr std::size_t kFrontPanel = 1;  // fronts are of the p95 error

std::vector<TradeoffPoint> familyOf(const Tradeoff& tradeoff, const char* family)
{
	std::vector<TradeoffPoint> points;
	for (const TradeoffPoint& point : tradeoff.points)
		if (point.info.family == family) points.push_back(point);
	return points;
}

// Lines of `time value label label`: the second is of the ladder's middle, where the first would meet that of its end.
// Both are left empty but for landmarks.
std::string dataOf(const Tradeoff& tradeoff, const std::vector<TradeoffPoint>& points, const Panel& panel)
{
	std::string text;
	for (const TradeoffPoint& point : points)
	{
		const double value = panel.value(point, tradeoff.radius);
		const std::string& setting = point.info.setting;
		const bool isEnd = setting == "exact" || setting == "full", isMiddle = setting == "size 3.5 %";
		if (std::isfinite(value))
			text += fmt::format("{} {} \"{}\" \"{}\"\n", point.median, value, isEnd ? setting : "",
								isMiddle ? setting : "");
	}
	return text;
}

std::string quoted(const std::string& text)
{
	std::string result = "\"";
	for (const char c : text)
		if (c == '"' || c == '\\' || c == '\n')
			result += ' ';
		else
			result += c;
	return result + "\"";
}

// Every family that was measured, drawn in this panel or not.
std::string legendOf(const Tradeoff& tradeoff)
{
	std::string text;
	for (const Look& look : kLooks)
		if (!familyOf(tradeoff, look.family).empty())
			text += fmt::format(", \\\n  keyentry with points lc rgb \"{}\" pt {} ps 1.3 lw 1.5 title \"{}\"",
								look.color, look.marker, look.title);
	return text;
}

std::string drawPanel(const Tradeoff& tradeoff, std::size_t index)
{
	const Panel& panel = kPanels[index];
	std::string text = fmt::format("set title \"{}\"\nset ylabel \"{}\"\n{} logscale y\nset yrange {}\n", panel.title,
								   panel.axis, panel.decades ? "set" : "unset", panel.range);
	text += index == 0 ? "set key at screen 0.5,0.015 center bottom maxrows 4 Left reverse width 2\n" : "unset key\n";
	std::string plots;
	for (const Look& look : kLooks)
	{
		const std::vector<TradeoffPoint> points = familyOf(tradeoff, look.family);
		const std::string data = dataOf(tradeoff, points, panel), block = fmt::format("$points{}", &look - kLooks);
		if (data.empty()) continue;
		text += block + " << EOD\n" + data + "EOD\n";
		plots += fmt::format("{}{} using 1:2 with points lc rgb \"{}\" pt {} ps 1.3 lw 1.5 notitle",
							 plots.empty() ? "plot " : ", \\\n  ", block, look.color, look.marker);
		plots += fmt::format(", \\\n  {} using 1:2:3 with labels {} font \",11\" tc rgb \"{}\" notitle", block,
							 look.labels, look.color);
		plots += fmt::format(", \\\n  {} using 1:2:4 with labels right offset -0.8,0.5 font \",11\" tc rgb \"{}\" notitle",
							 block, look.color);
		const std::string front = dataOf(tradeoff, paretoFront(points), panel);
		if (index != kFrontPanel || front.empty()) continue;
		text += fmt::format("$front{} << EOD\n{}EOD\n", &look - kLooks, front);
		plots +=
			fmt::format(", \\\n  $front{} using 1:2 with steps lc rgb \"{}\" lw 1 notitle", &look - kLooks, look.color);
	}
	return text + plots + (index == 0 ? legendOf(tradeoff) : "") + "\n";
}

std::string scriptOf(const Tradeoff& tradeoff, const std::string& title)
{
	double fastest = std::numeric_limits<double>::infinity(), slowest = 0;
	for (const TradeoffPoint& point : tradeoff.points)
	{
		fastest = std::min(fastest, point.median);
		slowest = std::max(slowest, point.median);
	}
	std::string text = pngTerminal(1800, 1400);
	text += fmt::format(
		"set multiplot layout 2,2 margins 0.065,0.975,0.17,0.91 spacing 0.085,0.10 title {} font \"DejaVu Sans,20\"\n"
		"set logscale x\nset format \"%g\"\nset xlabel \"median time, microseconds (left is faster)\"\n"
		"set grid xtics ytics lc rgb \"#dddddd\"\nset xrange [{}:{}]\n",
		quoted(title), 0.7 * fastest, 2 * slowest);
	// Two decades have room for more than whole ones.
	std::string ticks;
	for (double decade = std::pow(10, std::floor(std::log10(fastest))); decade < 2 * slowest; decade *= 10)
		ticks += fmt::format("{}{:g}, {:g}, {:g}", ticks.empty() ? "" : ", ", decade, 2 * decade, 5 * decade);
	if (slowest < 300 * fastest) text += "set xtics (" + ticks + ")\n";
	for (std::size_t i = 0; i < std::size(kPanels); ++i) text += drawPanel(tradeoff, i);
	return text + "unset multiplot\n";
}
}  // namespace

bool plot(const Tradeoff& tradeoff, const std::string& title, const std::string& path)
{
	return drawPlot(scriptOf(tradeoff, title), path);
}
}  // namespace clod::demo
