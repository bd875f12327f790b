// SPDX-License-Identifier: Zlib
#include "demos/trial/TrialReport.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

#include "demos/runner/Statistics.h"
#include "demos/trial/Html.h"

namespace clod::demo
{
namespace
{
constexpr double kSmallestPercent = 0.001;  // of errors on a logarithmic axis
constexpr const char* kWhatATimeIs =
	"A time is what a step pays for the pair in Bullet: contacts and their points, without the solver.";
constexpr double kLeastOverlapPercent = 0.01, kSmallestMilliseconds = 0.01;  // on theirs

std::string percent(double share)
{
	if (std::isnan(share)) return "-";
	if (std::isinf(share)) return "not proved";
	if (share == 0) return "0 %";
	return share >= 0.1 ? fmt::format("{:.0f} %", 100 * share) : fmt::format("{:.2g} %", 100 * share);
}

std::string milliseconds(double microseconds)
{
	return microseconds < 1e6 ? fmt::format("{:.3g} ms", microseconds / 1000) : fmt::format("{:.0f} ms", microseconds / 1000);
}

std::string limitName(double share)
{
	return share > 0 ? fmt::format("{:g} %", 100 * share) : std::string("exact");
}

std::string codeOf(double share)
{
	return share > 0 ? fmt::format("clod::ContactMetric::errorShare({:g})", share)
					 : std::string("clod::ContactMetric::exactly()");
}

std::string verdict(const TrialRun& run)
{
	if (!run.ending.empty()) return run.ending;
	if (run.gone > 0) return fmt::format("{} bodies fell through or flew off", run.gone);
	return run.endSpeed < 0.1 ? "came to rest" : fmt::format("still moves, {:.2g} radii/s", run.endSpeed);
}

std::string meshesOf(const Trial& trial)
{
	HtmlTable table{"Lengths are the files' own unit.",
					{"mesh", "triangles", "radius", "levels", "in memory", "built in", "what was done to it"},
					{}};
	for (const TrialMesh& mesh : trial.meshes)
	{
		const Hierarchy& h = *mesh.hierarchy;
		std::string done = mesh.mended.empty() ? "taken as it is" : "";
		for (const std::string& change : mesh.mended) done += (done.empty() ? "" : "; ") + change;
		if (mesh.scale != 1) done += fmt::format("; scaled by {:.4g} to the others' size", mesh.scale);
		table.rows.push_back({escaped(mesh.name), fmt::format("{}", h.asset().triangleCount),
							  fmt::format("{:.4g}", double(h.asset().radius)), fmt::format("{}", h.levels().size),
							  fmt::format("{:.1f} MB", double(h.bytes().size()) / 1e6),
							  std::isnan(mesh.buildSeconds) ? "earlier" : fmt::format("{:.1f} s", mesh.buildSeconds),
							  escaped(done)});
	}
	std::string text = toHtml(table);
	for (const std::string& note : trial.notes) text += "<p>" + escaped(note) + ".</p>\n";
	return text;
}

std::string contendersOf(const Trial& trial)
{
	HtmlTable table{
		"Overlap is in % of the smallest radius, distance off the surface in % of the smaller radius of the two that "
		"touch, as certified limits are. Both are measured on the full meshes, by code that none of the methods uses.",
		{"method", "a step, median", "95 %", "deepest overlap", "points off the surface, median", "95 %", "end"},
		{}};
	for (std::size_t i = 0; i < trial.runs.size(); ++i)
	{
		const TrialRun& run = trial.runs[i];
		table.rows.push_back({fmt::format("{}<br><small>{}</small>", escaped(trial.contenders[i].name),
										  escaped(trial.contenders[i].setting)),
							  milliseconds(run.stepMedian), milliseconds(run.stepP95),
							  percent(run.deepest / trial.smallest), percent(run.offSurfaceMedian), percent(run.offSurfaceP95),
							  escaped(verdict(run))});
	}
	std::string text = toHtml(table);
	for (const LeftOut& out : trial.leftOut)
		text += fmt::format("<p>{} is not shown: {}.</p>\n", escaped(out.what), escaped(out.reason));
	return text;
}

// Both series span decades: on a linear axis everybody but the worst lies on the ground.
std::string seriesOf(const Trial& trial, const std::string& title, const std::string& axis, const char* unit,
					 double smallest, double (*value)(const TrialFrame&, const Trial&))
{
	Plot plot;
	plot.title = title;
	plot.description = "The table above has medians and extremes of the same runs.";
	plot.xAxis = "seconds";
	plot.yAxis = axis;
	plot.isYLogarithmic = true;
	plot.smallestY = smallest;
	for (std::size_t i = 0; i < trial.runs.size(); ++i)
	{
		PlotSeries series{trial.contenders[i].name, trial.contenders[i].color, {}, true};
		for (const TrialFrame& frame : trial.runs[i].frames)
		{
			const double y = value(frame, trial);
			series.points.push_back(
				{frame.state.time, y,
				 fmt::format("{}, {:.2f} s: {:.3g} {}", trial.contenders[i].name, frame.state.time, y, unit)});
		}
		plot.series.push_back(std::move(series));
	}
	return toSvg(plot);
}

std::string filmOf(const Trial& trial, const TrialPictures& pictures)
{
	const std::string text = "The same fall side by side, in real time: " +
							 [&]
	{
		std::string names;
		for (const Contender& c : trial.contenders) names += (names.empty() ? "" : ", ") + c.name;
		return names;
	}() +
							 ". Running: cost of a step, overlap of the full meshes and how far the worst contact "
							 "point is off their surfaces, in % of the radius. Red: contact points under load, seen through the bodies. Blue: the "
							 "hulls that collide.";
	if (pictures.files.empty()) return "";
	const std::string sheet = dataAddress(pictures.files.front(), "image/png");
	std::string figure = "<figure>";
	if (!pictures.film.empty())
		figure += fmt::format("<video controls loop muted playsinline preload='auto' aria-label='{}' src='{}'></video>",
							  escaped(text), dataAddress(pictures.film, "video/mp4"));
	else
		figure += fmt::format("<img alt='{}' src='{}'>", escaped(text), sheet);
	figure += "<figcaption>" + escaped(text);
	if (pictures.film.empty()) figure += " There is no film: ffmpeg is not installed.";
	return figure + "</figcaption></figure>\n";
}

struct FamilyLook
{
	const char *family, *name, *color;
};
constexpr FamilyLook kLooks[] = {{"clod-dispatch", "CLOD", "#000000"},
								 {"gimpact", "GImpact", "#D55E00"},
								 {"vhacd", "V-HACD hulls", "#009E73"},
								 {"hull", "convex hulls", "#0072B2"}};

std::string tradeoffOf(const Trial& trial)
{
	const Tradeoff& tradeoff = trial.tradeoff;
	if (tradeoff.points.empty()) return "<p>The two meshes were never in contact.</p>\n";
	Plot plot;
	plot.title = fmt::format("{} poses of {}, tumbling over each other in contact; errors of {:g} % or less are drawn as "
							 "that. Who leaves open how deep an overlap is has times in the table alone.",
							 tradeoff.rows, trial.pair, kSmallestPercent);
	plot.description = std::string("The table below the plot has every point. ") + kWhatATimeIs;
	plot.xAxis = "median time of a step for the pair, microseconds (left is faster)";
	plot.yAxis = "error of the gap, 95 %, in % of the radius";
	plot.isXLogarithmic = plot.isYLogarithmic = true;
	plot.smallestY = kSmallestPercent;
	HtmlTable table{
		"The same points.", {"method", "setting", "median, us", "95 %, us", "gap's error, median", "95 %"}, {}};
	for (const FamilyLook& look : kLooks)
	{
		PlotSeries series{look.name, look.color, {}, false};
		bool leavesOpen = false;
		for (const TradeoffPoint& p : tradeoff.points)
		{
			if (p.info.family != look.family) continue;
			const double error = p.accuracy.gapP95 / tradeoff.radius;
			leavesOpen |= !std::isfinite(error);
			series.points.push_back(
				{p.median, 100 * error,
				 fmt::format("{}, {}: {:.1f} us, error {}", look.name, p.info.setting, p.median, percent(error))});
			table.rows.push_back({look.name, escaped(p.info.setting), fmt::format("{:.1f}", p.median),
								  fmt::format("{:.1f}", p.p95), percent(p.accuracy.gapMedian / tradeoff.radius),
								  std::isfinite(error) ? percent(error) : "left open"});
		}
		if (!series.points.empty() && !leavesOpen) plot.series.push_back(std::move(series));
	}
	return toSvg(plot) + "<details><summary>As a table</summary>" + toHtml(table) + "</details>\n";
}

std::string outcome(bool holds, const std::string& words)
{
	return fmt::format("<span class='{}'>{}</span>", holds ? "good" : "bad", escaped(words));
}

std::string recommendationsOf(const Trial& trial)
{
	std::string text;
	const Recommendation &a = trial.accuracy, &c = trial.cost;
	if (a.isFound)
		text += fmt::format(
			"<h3>For an accuracy of {}</h3><pre><code>shape.setMetric({});</code></pre><p>{}; {:.0f} hulls and boxes "
			"compared and {:.0f} us a step in the median, {:.0f} us in 95 %. On {} fresh poses: {}; {}.</p>\n",
			percent(a.wanted), codeOf(a.chosen.share),
			a.chosen.share > 0 ? "Certified to " + limitName(a.chosen.share) + " of the smaller radius"
							   : std::string("Exact, as nothing coarser is cheaper here"),
			a.chosen.tests, a.chosen.microseconds, a.chosen.p95, a.rows,
			outcome(a.keepsAccuracy(), fmt::format("largest error {}, largest certified {}", percent(a.fresh.error),
												   percent(a.fresh.certified))),
			outcome(a.keepsCost(), fmt::format("{:.0f} compared in the median", a.fresh.tests)));
	text += fmt::format("<h3>For a cost of {:g} us a step</h3>", c.wanted);
	if (!c.isFound) return text + "<p>No setting is so cheap here: see the cheapest in the table below.</p>\n";
	return text + fmt::format(
					  "<pre><code>shape.setMetric({});</code></pre><p>{:.0f} us in the median where it was chosen, "
					  "{:.0f} us on {} fresh poses; {}; {}.</p>\n",
					  codeOf(c.chosen.share), c.chosen.microseconds, c.fresh.microseconds, c.rows,
					  outcome(c.keepsCost(), fmt::format("{:.0f} hulls and boxes compared against {:.0f}",
														 c.fresh.tests, c.chosen.tests)),
					  outcome(c.keepsAccuracy(), fmt::format("largest error {}, limit {}", percent(c.fresh.error),
															 limitName(c.chosen.share))));
}

std::string limitsOf(const Trial& trial)
{
	HtmlTable table{
		fmt::format("Every certified limit on {} poses of {} about to touch. {}", trial.poses, trial.pair, kWhatATimeIs),
		{"limit", "largest true error", "largest certified", "hulls and boxes compared", "a step, us", "95 %",
		 "touching pairs of patches"},
		{}};
	for (const LimitRow& limit : trial.limits)
		table.rows.push_back({limitName(limit.share), percent(limit.error), percent(limit.certified),
							  fmt::format("{:.0f}", limit.tests), fmt::format("{:.1f}", limit.microseconds),
							  fmt::format("{:.1f}", limit.p95), fmt::format("{:.0f}", limit.contacts)});
	return "<details><summary>All settings</summary>" + toHtml(table) + "</details>\n";
}

std::string worstOf(const Trial& trial, const TrialPictures& pictures)
{
	if (pictures.worst.empty()) return "";
	std::string text = "<h2>Each method's worst moment</h2>\n<div class='pictures'>\n";
	for (std::size_t i = 0; i < trial.runs.size(); ++i)
	{
		if (pictures.worst[i].empty()) continue;
		const TrialFrame& frame = trial.runs[i].frames[trial.runs[i].worst];
		std::string how = "nothing overlaps";
		if (frame.deepest > 0)
			how = fmt::format("the meshes overlap by {} of the radius", percent(frame.deepest / trial.smallest));
		else if (!std::isnan(frame.offSurface))
			how += fmt::format(", a contact point is off the surface by {} of the radius", percent(frame.offSurface));
		const std::string words = fmt::format("{} at {:.2f} s: {}", trial.contenders[i].name, frame.state.time, how);
		text += fmt::format("<figure><img alt='{0}' src='{1}'><figcaption>{0}</figcaption></figure>\n", escaped(words),
							dataAddress(pictures.worst[i], "image/png"));
	}
	return text + "</div>\n";
}

nlohmann::ordered_json toJson(const LimitRow& limit)
{
	return {{"limit", limit.share},
			{"largest_error", limit.error},
			{"largest_certified", limit.certified},
			{"broken", limit.broken},
			{"tests", limit.tests},
			{"dispatch_us", {{"median", limit.microseconds}, {"p95", limit.p95}}}};
}

nlohmann::ordered_json toJson(const Recommendation& r)
{
	return {{"wanted", r.wanted},         {"found", r.isFound},       {"chosen", toJson(r.chosen)},
			{"fresh_poses", r.rows},      {"fresh", toJson(r.fresh)}, {"keeps_accuracy", r.keepsAccuracy()},
			{"keeps_cost", r.keepsCost()}};
}
}  // namespace

std::string reportPage(const Trial& trial, const TrialPictures& pictures)
{
	std::string names;
	for (const TrialMesh& mesh : trial.meshes) names += (names.empty() ? "" : ", ") + mesh.name;
	std::string body = "<h1>" + escaped(names) + ": collision by contact levels of detail</h1>\n";
	body +=
		"<p>The meshes fall on each other, come to rest, and slide as the floor tilts. All methods have the same masses, "
		"inertia, friction, solver and time step; only what collides differs.</p>\n";
	body += filmOf(trial, pictures) + "<h2>What happened</h2>\n" + contendersOf(trial);
	body += seriesOf(trial, "Cost of a whole step as the bodies fall, rest and slide.", "milliseconds", "ms",
					 kSmallestMilliseconds, [](const TrialFrame& f, const Trial&) { return f.stepMicroseconds / 1000; });
	body += seriesOf(trial,
					 fmt::format("How deep the full meshes are in each other; at the bottom: {:g} % or less.", kLeastOverlapPercent),
					 "% of the smallest radius", "%", kLeastOverlapPercent,
					 [](const TrialFrame& f, const Trial& t) { return 100 * f.deepest / t.smallest; });
	body += "<h2>Which setting to take</h2>\n" + recommendationsOf(trial) + limitsOf(trial);
	body += "<h2>Accuracy against time</h2>\n" + tradeoffOf(trial);
	body += worstOf(trial, pictures);
	body += "<h2>The meshes</h2>\n" + meshesOf(trial);
	body += fmt::format(
		"<h2>How this was measured</h2>\n<p>Made by <code>{}</code> in {:.0f} s. One thread. Steps of 1/{:.0f} "
		"s, {} solver iterations, friction {:g} a body; the largest radius is played as 0.1 m. Peers have a "
		"collision margin of 0.25 % of the radius, ours has none. Times are of this machine and vary; compare "
		"them within this page.</p><pre>{}</pre>\n",
		escaped(trial.command), trial.seconds, 1 / trial.scene.info.dt, trial.scene.world.solverIterations,
		trial.scene.world.friction, escaped(machine().dump(1)));
	return page(names + ": contact levels of detail", body);
}

void addToReport(nlohmann::ordered_json& report, const Trial& trial)
{
	report["smallest_radius"] = trial.smallest;
	for (std::size_t i = 0; i < trial.runs.size(); ++i)
	{
		const TrialRun& run = trial.runs[i];
		report["runs"].push_back(
			{{"method", trial.contenders[i].name},
			 {"setting", trial.contenders[i].setting},
			 {"frames", run.frames.size()},
			 {"step_us", {{"median", run.stepMedian}, {"p95", run.stepP95}}},
			 {"deepest", run.deepest},
			 {"points_off_share", {{"median", run.offSurfaceMedian}, {"p95", run.offSurfaceP95}}},
			 {"end_speed_radii_per_s", run.endSpeed},
			 {"bodies_gone", run.gone},
			 {"ending", run.ending}});
	}
	report["left_out"] = nlohmann::ordered_json::array();
	for (const LeftOut& out : trial.leftOut) report["left_out"].push_back({{"what", out.what}, {"reason", out.reason}});
	for (const LimitRow& limit : trial.limits) report["limits"].push_back(toJson(limit));
	report["for_accuracy"] = toJson(trial.accuracy);
	report["for_cost"] = toJson(trial.cost);
}

std::string printable(const Trial& trial)
{
	std::string text;
	for (std::size_t i = 0; i < trial.runs.size(); ++i)
		text +=
			fmt::format("{:<12} a step {:>9}, deepest overlap {:>8} of the radius, points off the surface {:>8}; {}\n",
						trial.contenders[i].name, milliseconds(trial.runs[i].stepMedian),
						percent(trial.runs[i].deepest / trial.smallest),
						percent(trial.runs[i].offSurfaceP95), verdict(trial.runs[i]));
	for (const LeftOut& out : trial.leftOut) text += fmt::format("left out: {}: {}\n", out.what, out.reason);
	const auto line = [](const Recommendation& r, const std::string& wanted, const std::string& holds)
	{
		if (!r.isFound) return fmt::format("for {}: no setting is so cheap\n", wanted);
		std::string kept = holds;
		if (!r.keepsCost())
			kept = fmt::format(
				"the accuracy holds, but {:.2g} times the hulls and boxes are compared than where it was chosen",
				r.fresh.tests / r.chosen.tests);
		if (!r.keepsAccuracy()) kept = "DOES NOT HOLD";
		return fmt::format("for {}: {}; on {} fresh poses error {}, {:.0f} us a step: {}\n", wanted,
						   codeOf(r.chosen.share), r.rows, percent(r.fresh.error), r.fresh.microseconds, kept);
	};
	return text + line(trial.accuracy, "an accuracy of " + percent(trial.accuracy.wanted), "holds") +
		   line(trial.cost, fmt::format("a cost of {:g} us", trial.cost.wanted),
				fmt::format("holds to {:.0f} %", 100 * kCostSlack));
}
}  // namespace clod::demo
