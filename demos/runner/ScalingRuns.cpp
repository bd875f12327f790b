// SPDX-License-Identifier: Zlib
// Replays at several resolutions, their figures and their plot.
#include "demos/runner/ScalingRuns.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

#include "cli/Failure.h"
#include "cli/Files.h"
#include "demos/runner/Gnuplot.h"
#include "demos/runner/Replay.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
constexpr const char* kColors[] = {"#000000", "#D55E00", "#0072B2", "#009E73"};  // Okabe & Ito

using Rows = std::vector<ReplayRow>;

// Rows that move and touch at every resolution, whatever the selection calls a gap there.
std::vector<bool> commonRows(const std::vector<Rows>& runs, double tolerance)
{
	std::vector<bool> chosen(runs.front().size(), true);
	for (const Rows& rows : runs)
		for (std::size_t i = 0; i < rows.size(); ++i)
			if (!rows[i].contact(tolerance) || rows[i].motion() != Motion::moving) chosen[i] = false;
	return chosen;
}

std::vector<double> column(const Rows& rows, const std::vector<bool>& chosen, double (*value)(const ReplayRow&))
{
	std::vector<double> values;
	for (std::size_t i = 0; i < rows.size(); ++i)
		if (chosen[i]) values.push_back(value(rows[i]));
	return values;
}

// The finest level of A, or of B, that answered in any of the rows.
std::uint32_t finestAsked(const Hierarchy& hierarchy, bool isA, const Rows& rows, const std::vector<bool>& chosen)
{
	std::uint32_t finest = hierarchy.coarsestClodLevel();
	for (std::size_t i = 0; i < rows.size(); ++i)
		if (chosen[i]) finest = std::min(finest, isA ? rows[i].finestA : rows[i].finestB);
	return finest;
}

// The coarsest level that errs by no more: of the same detail, whatever the mesh.
std::uint32_t levelWithin(const Hierarchy& hierarchy, float deviation)
{
	std::uint32_t level = 0;
	while (level < hierarchy.coarsestClodLevel() && hierarchy.levels()[level + 1].maxDeviation <= deviation) ++level;
	return level;
}

// Where that level and what is coarser are loaded alone.
std::size_t loadedBytes(const Hierarchy& hierarchy, std::uint32_t finest)
{
	const cli::PartialFile file(temporaryDirectory() + "/levels.clod");
	if (const std::string problem = cli::writeFile(file.temporaryPath(), hierarchy.bytes()); !problem.empty())
		throw cli::Failure(cli::ExitCode::failure, problem);
	const auto loaded = Hierarchy::load(file.temporaryPath(), finest);
	if (!loaded) throw cli::Failure(cli::ExitCode::failure, loaded.error());
	return loaded.value()->bytes().size();
}

// smallest: the first pair, and its rows.
void addLoadedBytes(const ScaledPair& pair, const Rows& rows, const ScaledPair& smallest, const Rows& smallestRows,
					const std::vector<bool>& chosen, nlohmann::ordered_json& size)
{
	std::size_t loaded = 0, alike = 0;
	for (const bool isA : {true, false})
	{
		const Hierarchy &hierarchy = *(isA ? pair.a : pair.b), &least = *(isA ? smallest.a : smallest.b);
		loaded += loadedBytes(hierarchy, finestAsked(hierarchy, isA, rows, chosen));
		const float deviation = least.levels()[finestAsked(least, isA, smallestRows, chosen)].maxDeviation;
		alike += loadedBytes(hierarchy, levelWithin(hierarchy, deviation));
	}
	size["loaded_bytes"] = loaded;
	size["alike_bytes"] = alike;
}

nlohmann::ordered_json describe(const ScaledPair& pair, const Rows& rows, const std::vector<bool>& chosen)
{
	const auto median = [&](double (*value)(const ReplayRow&)) { return quantile(column(rows, chosen, value), 0.5); };
	nlohmann::ordered_json size = {
		{"resolution", pair.resolution},
		{"triangles_a", pair.a->asset().triangleCount},
		{"triangles_b", pair.b->asset().triangleCount},
		{"bytes", pair.a->bytes().size() + pair.b->bytes().size()},
		{"build_seconds", nullptr},
		{"rows", std::count(chosen.begin(), chosen.end(), true)},
		{"query_us", spread(column(rows, chosen, [](const ReplayRow& r) { return r.queryMicroseconds; }))},
		{"gap_us", spread(column(rows, chosen, [](const ReplayRow& r) { return r.gapMicroseconds; }))},
		{"front", median([](const ReplayRow& r) { return double(r.stats.front); })},
		{"contacts", median([](const ReplayRow& r) { return double(r.contacts); })},
		{"finest_level", median([](const ReplayRow& r) { return double(r.stats.finestLevel); })},
		{"coarsest_level", median([](const ReplayRow& r) { return double(r.stats.coarsestLevel); })},
		{"error_bound", median([](const ReplayRow& r) { return r.errorBound; })}};
	if (!std::isnan(pair.buildSeconds)) size["build_seconds"] = pair.buildSeconds;
	return size;
}

void keepLeast(Rows& least, const Rows& pass)
{
	if (least.empty()) least = pass;
	for (std::size_t i = 0; i < pass.size(); ++i)
	{
		least[i].queryMicroseconds = std::min(least[i].queryMicroseconds, pass[i].queryMicroseconds);
		least[i].gapMicroseconds = std::min(least[i].gapMicroseconds, pass[i].gapMicroseconds);
	}
}

double triangles(const nlohmann::ordered_json& size)
{
	return size["triangles_a"].get<double>() + size["triangles_b"].get<double>();
}

std::string panel(const nlohmann::ordered_json& selections, const char* title, int columnIndex)
{
	std::string plots = fmt::format("set title \"{}\"\n", title);
	for (std::size_t i = 0; i < selections.size(); ++i)
		plots += fmt::format("{}$selection{} using 1:{} with linespoints lw 2 pt {} lc rgb \"{}\" title \"{}\"",
							 i == 0 ? "plot " : ", ", i, columnIndex, 5 + 2 * i, kColors[i % std::size(kColors)],
							 selections[i]["selection"].get<std::string>());
	return plots + "\n";
}
}  // namespace

nlohmann::ordered_json measureScaling(const std::vector<ScaledPair>& pairs, const std::vector<PoseRow>& poses,
									  const std::vector<ScalingSelection>& selections, const ScalingOptions& options,
									  const std::function<void(double)>& progress)
{
	std::vector<std::vector<Rows>> runs(selections.size(), std::vector<Rows>(pairs.size()));
	const double all = double(options.repeat) * double(selections.size() * pairs.size());
	double done = 0;
	for (int pass = 0; pass < options.repeat; ++pass)
		for (std::size_t s = 0; s < selections.size(); ++s)
			for (std::size_t p = 0; p < pairs.size(); ++p)
			{
				ReplayOptions asked;
				asked.metric = selections[s].metric;
				asked.tolerance.value = options.tolerance;
				asked.dt = options.dt;
				const Rows rows = replay({pairs[p].a.get(), pairs[p].b.get()}, poses, asked,
										 [&](double fraction) { progress((done + fraction) / all); });
				keepLeast(runs[s][p], rows);
				++done;
			}
	nlohmann::ordered_json json = nlohmann::ordered_json::array();
	const std::vector<bool> chosen = commonRows(runs.front(), options.tolerance);
	if (std::none_of(chosen.begin(), chosen.end(), [](bool b) { return b; })) return json;
	for (std::size_t s = 0; s < selections.size(); ++s)
	{
		nlohmann::ordered_json sizes = nlohmann::ordered_json::array();
		for (std::size_t p = 0; p < pairs.size(); ++p)
		{
			sizes.push_back(describe(pairs[p], runs[s][p], chosen));
			addLoadedBytes(pairs[p], runs[s][p], pairs[0], runs[s][0], chosen, sizes[p]);
			sizes[p]["growth"] =
				sizes[p]["query_us"]["median"].get<double>() / sizes[0]["query_us"]["median"].get<double>();
		}
		json.push_back({{"selection", selections[s].name}, {"sizes", sizes}});
	}
	return json;
}

std::string formatScalingCsv(const nlohmann::ordered_json& selections)
{
	std::string text =
		"selection,resolution,triangles_a,triangles_b,bytes,build_seconds,rows,query_us_median,query_us_q1,query_us_q3,"
		"query_us_p95,gap_us_median,front,contacts,finest_level,coarsest_level,error_bound,growth,loaded_bytes,alike_bytes\n";
	for (const auto& selection : selections)
		for (const auto& size : selection["sizes"])
		{
			const auto& us = size["query_us"];
			text += fmt::format(
				"{},{},{},{},{},{},{},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{},{},{},{},{},{:.4f},{},{}\n",
				selection["selection"].get<std::string>(), number(size["resolution"].get<double>()),
				size["triangles_a"].get<std::size_t>(), size["triangles_b"].get<std::size_t>(),
				size["bytes"].get<std::size_t>(),
				size["build_seconds"].is_null() ? "" : fmt::format("{:.2f}", size["build_seconds"].get<double>()),
				size["rows"].get<std::size_t>(), us["median"].get<double>(), us["q1"].get<double>(),
				us["q3"].get<double>(), us["p95"].get<double>(), size["gap_us"]["median"].get<double>(),
				size["front"].get<double>(), size["contacts"].get<double>(), size["finest_level"].get<double>(),
				size["coarsest_level"].get<double>(), number(size["error_bound"].get<double>()),
				size["growth"].get<double>(), size["loaded_bytes"].get<std::size_t>(),
				size["alike_bytes"].get<std::size_t>());
		}
	return text;
}

std::string formatScalingTable(const nlohmann::ordered_json& selections)
{
	std::string text =
		fmt::format("{:<18}{:>10}{:>10}{:>8}{:>11}{:>10}{:>11}{:>9}{:>10}{:>10}{:>10}{:>10}{:>10}{:>9}\n", "selection", "tris a",
					"tris b", "rows", "query us", "p95 us", "gap us", "front", "contacts", "levels", "MB", "needed", "alike",
					"growth");
	for (const auto& selection : selections)
		for (const auto& size : selection["sizes"])
			text += fmt::format(
				"{:<18}{:>10}{:>10}{:>8}{:>11.1f}{:>10.1f}{:>11.1f}{:>9.0f}{:>10.0f}{:>10}{:>10.1f}{:>10.2f}{:>10.2f}{:>9.2f}\n",
				selection["selection"].get<std::string>(), size["triangles_a"].get<std::size_t>(),
				size["triangles_b"].get<std::size_t>(), size["rows"].get<std::size_t>(),
				size["query_us"]["median"].get<double>(), size["query_us"]["p95"].get<double>(),
				size["gap_us"]["median"].get<double>(), size["front"].get<double>(), size["contacts"].get<double>(),
				fmt::format("{:g} to {:g}", size["finest_level"].get<double>(), size["coarsest_level"].get<double>()),
				1e-6 * size["bytes"].get<double>(), 1e-6 * size["loaded_bytes"].get<double>(),
				1e-6 * size["alike_bytes"].get<double>(), size["growth"].get<double>());
	return text;
}

bool plotScaling(const nlohmann::ordered_json& selections, const std::string& title, const std::string& path)
{
	std::string text = pngTerminal(1500, 700);
	for (std::size_t i = 0; i < selections.size(); ++i)
	{
		text += fmt::format("$selection{} << END\n", i);
		for (const auto& size : selections[i]["sizes"])
			text += fmt::format("{} {} {}\n", triangles(size), size["query_us"]["median"].get<double>(),
								size["front"].get<double>());
		text += "END\n";
	}
	text += "set multiplot layout 1,2 title \"" + title +
			"\" font \"DejaVu Sans,18\"\nset logscale xy\nset format y \"%g\"\nset format x \"%.0f\"\n"
			"set grid xtics ytics lc rgb \"#dddddd\"\nset key top left\nset rmargin 6\nset xlabel \"triangles of both bodies\"\n";
	text += panel(selections, "query, median microseconds", 2) + panel(selections, "pairs in the front, median", 3);
	return drawPlot(text + "unset multiplot\n", path);
}
}  // namespace clod::demo
