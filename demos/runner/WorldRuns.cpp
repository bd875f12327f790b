// SPDX-License-Identifier: Zlib
#include "demos/runner/WorldRuns.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

#include "cli/Csv.h"
#include "cli/Failure.h"
#include "cli/Files.h"
#include "demos/runner/Gnuplot.h"
#include "demos/runner/HeapBytes.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
constexpr const char* kContenderColors[] = {"#000000", "#E69F00", "#56B4E9", "#009E73", "#D55E00", "#CC79A7", "#0072B2"};  // Okabe & Ito

using Json = nlohmann::ordered_json;

// Rows of one contender on so many threads.
std::string lineOf(const Json& row)
{
	const unsigned threads = row["threads"].get<unsigned>();
	return row["contender"].get<std::string>() + (threads > 1 ? fmt::format(", {} threads", threads) : "");
}

std::vector<std::pair<std::string, std::vector<Json>>> linesOf(const std::vector<Json>& rows)
{
	std::vector<std::pair<std::string, std::vector<Json>>> lines;
	for (const Json& row : rows)
	{
		const std::string name = lineOf(row);
		auto line = std::find_if(lines.begin(), lines.end(), [&](const auto& l) { return l.first == name; });
		if (line == lines.end()) line = lines.insert(lines.end(), {name, {}});
		line->second.push_back(row);
	}
	return lines;
}

// Those that came to the steps that were to be measured: others are of worlds that have only begun.
std::vector<Json> measured(std::vector<Json> rows)
{
	rows.erase(std::remove_if(rows.begin(), rows.end(), [](const Json& row) { return row.contains("began_only") && row["began_only"]; }), rows.end());
	return rows;
}

std::string cell(const Json& value)
{
	return value.is_null() ? "" : value.is_string() ? cli::quotedField(value.get<std::string>()) : fmt::format("{:.6g}", value.get<double>());
}

std::string panel(std::size_t sweep, const WorldSweep& figures, const char* member, double scale)
{
	std::string data, plot;
	std::size_t count = 0;
	for (const auto& [name, rows] : linesOf(figures.rows))
	{
		std::string points;
		for (const Json& row : measured(rows))
			if (!row[member].is_null())
				points += fmt::format("{} {}\n", row[figures.axis].get<double>(), scale * row[member].get<double>());
		if (points.empty()) continue;
		data += fmt::format("$d{}_{}_{} << END\n{}END\n", member, sweep, count, points);
		plot += fmt::format("{}$d{}_{}_{} using 1:2 with linespoints lw 2 pt {} lc rgb \"{}\" title \"{}\"",
							count == 0 ? "plot " : ", ", member, sweep, count, 4 + count,
							kContenderColors[count % std::size(kContenderColors)], name);
		++count;
	}
	return count == 0 ? std::string("set multiplot next\n") : data + plot + "\n";
}
}  // namespace

Json measureWorld(const SceneDefinition& definition, const std::vector<std::shared_ptr<const Hierarchy>>& models,
				  const WorldContender& contender, const WorldRunOptions& options)
{
	SceneSettings settings;
	settings.models = models;
	settings.shapes = contender.shapes;
	settings.metric = contender.metric;
	settings.dt = definition.info.dt;
	settings.threads = options.threads;
	settings.timedBy = options.threads == 1 ? TimedBy::thread : TimedBy::clock;
	settings.printsWarnings = false;
	const double before = heapBytes();
	const std::unique_ptr<Scene> scene = makeScene(definition, settings);
	std::vector<double> steps, dispatches;
	const Stopwatch watch(settings.timedBy);
	bool isOver = false, hasOnlyBegun = false;
	for (int step = 0; step < options.to && !isOver; ++step)
	{
		scene->step();
		isOver = watch.microseconds() > 1e6 * options.mostSeconds;
		hasOnlyBegun = step < options.from;
		if (hasOnlyBegun && !isOver) continue;
		const StepTimes times = scene->lastTimes();
		steps.push_back(times.step);
		dispatches.push_back(times.dispatch);
	}
	const double bytes = heapBytes() - before;
	const SceneState state = scene->state();
	Json row = {{"scene", definition.info.name},
				{"contender", contender.name},
				{"threads", options.threads},
				{"bodies", std::count_if(definition.bodies.begin(), definition.bodies.end(),
										 [](const BodyDefinition& body) { return body.mass > 0; })},
				{"triangles", nullptr},
				{"covered", nullptr},
				{"steps", steps.size()},
				{"step_us", quantile(steps, 0.5)},
				{"dispatch_us", quantile(dispatches, 0.5)},
				{"bytes", nullptr},
				{"pairs", state.pairs.size()},
				{"points", state.points.size()},
				{"finest_level", nullptr},
				{"coarsest_level", nullptr},
				{"in_place", state.inPlace},
				{"began_only", hasOnlyBegun}};
	double triangles = 0;
	for (const SceneBody& body : definition.info.bodies) triangles += models[body.model]->asset().triangleCount;
	row["triangles"] = triangles;
	if (!std::isnan(bytes)) row["bytes"] = bytes;
	if (contender.shapes.empty()) row["finest_level"] = state.finestLevel, row["coarsest_level"] = state.coarsestLevel;
	return row;
}

double growthExponent(const std::vector<Json>& rows, const std::string& x, const std::string& y)
{
	double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
	for (const Json& row : rows)
	{
		if (row[x].is_null() || row[y].is_null() || !(row[x] > 0) || !(row[y] > 0)) continue;
		const double lx = std::log(row[x].get<double>()), ly = std::log(row[y].get<double>());
		n += 1, sx += lx, sy += ly, sxx += lx * lx, sxy += lx * ly;
	}
	const double spread = n * sxx - sx * sx;
	return n >= 2 && spread > 0 ? (n * sxy - sx * sy) / spread : std::nan("");
}

Json toJson(const WorldSweep& sweep)
{
	Json json = {{"title", sweep.title}, {"axis", sweep.axis}, {"rows", sweep.rows}, {"growth", Json::array()}};
	for (const auto& [name, rows] : linesOf(sweep.rows))
	{
		const double time = growthExponent(measured(rows), sweep.axis, "step_us"),
					 bytes = growthExponent(measured(rows), sweep.axis, "bytes");
		json["growth"].push_back({{"contender", name},
								  {"step_us", std::isnan(time) ? Json() : Json(time)},
								  {"bytes", std::isnan(bytes) ? Json() : Json(bytes)}});
	}
	return json;
}

std::string formatWorldCsv(const std::vector<WorldSweep>& sweeps)
{
	std::string text = "sweep";
	bool isFirst = true;
	for (const WorldSweep& sweep : sweeps)
		for (const Json& row : sweep.rows)
		{
			if (std::exchange(isFirst, false))
				for (const auto& [key, value] : row.items()) text += "," + key;
			text += "\n" + cli::quotedField(sweep.title);
			for (const auto& [key, value] : row.items()) text += "," + (value.is_boolean() ? (value ? "1" : "0") : cell(value));
		}
	return text + "\n";
}

const Json& WorldRecord::add(Json row)
{
	m_sweeps.back().rows.push_back(std::move(row));
	if (const std::string problem = cli::writeFile(m_csv, formatWorldCsv(m_sweeps)); !problem.empty())
		throw cli::Failure(cli::ExitCode::failure, problem);
	return m_sweeps.back().rows.back();
}

std::string formatWorldTable(const std::vector<WorldSweep>& sweeps)
{
	std::string text;
	for (const WorldSweep& sweep : sweeps)
	{
		text += fmt::format("{}\n{:<26}{:>10}{:>8}{:>12}{:>12}{:>10}{:>8}{:>9}{:>9}\n", sweep.title, "", sweep.axis, "steps",
							"step us", "dispatch us", "MB", "pairs", "points", "levels");
		for (const auto& [name, rows] : linesOf(sweep.rows))
		{
			for (const Json& row : rows)
				text += fmt::format(
					"{:<26}{:>10.0f}{:>8}{:>12.1f}{:>12.1f}{:>10}{:>8}{:>9}{:>9}{}\n", name, row[sweep.axis].get<double>(),
					row["steps"].get<int>(), row["step_us"].get<double>(), row["dispatch_us"].get<double>(),
					row["bytes"].is_null() ? "-" : fmt::format("{:.2f}", 1e-6 * row["bytes"].get<double>()),
					row["pairs"].get<int>(), row["points"].get<int>(),
					row["finest_level"].is_null()
						? "-"
						: fmt::format("{} to {}", row["finest_level"].get<int>(), row["coarsest_level"].get<int>()),
					row["began_only"] ? "  only begun" : "");
			const double time = growthExponent(measured(rows), sweep.axis, "step_us"),
						 bytes = growthExponent(measured(rows), sweep.axis, "bytes");
			if (!std::isnan(time))
				text += fmt::format("{:<26}  grows with {} to the {:.2f}, bytes to the {:.2f}\n", "", sweep.axis, time, bytes);
		}
	}
	return text;
}

bool plotWorlds(const std::vector<WorldSweep>& sweeps, const std::string& path)
{
	constexpr double kPanel = 640, kLabels = 105;  // pixels: width of a panel, and of what stands to the left of the first
	const double width = kPanel * double(sweeps.size());
	std::string text = pngTerminal(int(width), 1150);
	text += fmt::format("set multiplot layout 2,{1} margins {0},0.985,0.14,0.90 spacing {0},0.10 title \"Whole steps and memory of a world as it grows\" font \"DejaVu "
						"Sans,19\"\nset logscale xy\nset format \"%g\"\nset grid xtics ytics lc rgb \"#dddddd\"\n",
						kLabels / width, sweeps.size());
	for (const bool isTime : {true, false})
		for (std::size_t i = 0; i < sweeps.size(); ++i)
		{
			const std::string axis = sweeps[i].axis == "covered" ? "triangles under the body" : sweeps[i].axis;
			text += fmt::format("set title \"{}\"\nset xlabel \"{}\"\nset ylabel \"{}\"\n", isTime ? sweeps[i].title : "", axis,
								i > 0 ? "" : isTime ? "step, milliseconds" : "memory, MB");
			text += isTime && i == 0 ? "set key at screen 0.5,0.01 center bottom maxrows 2 Left reverse width 2\n" : "unset key\n";
			text += panel(i, sweeps[i], isTime ? "step_us" : "bytes", isTime ? 1e-3 : 1e-6);
		}
	return drawPlot(text + "unset multiplot\n", path);
}
}  // namespace clod::demo
