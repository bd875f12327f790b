// SPDX-License-Identifier: Zlib
// Selection flags to the query's settings.
#include "demos/runner/Selection.h"

#include <fmt/format.h>

#include "demos/cli/Program.h"

namespace clod::demo
{
namespace
{
// Options of the contract that this version does not have: refused by name, never ignored.
void addRefused(CLI::App& command, const std::string& name, const std::string& type)
{
	const auto refuse = [name](const std::string&) -> std::string
	{ return name + " is not available in this version"; };
	command.add_option(name)
		->type_name(type)
		->description("Not available in this version")
		->check(refuse)
		->group("Not available in this version");
}

std::string checkCombine(const std::string& word)
{
	if (word == "strict") return {};
	return word == "relaxed" ? "'relaxed' is not available in this version; use strict"
							 : "'" + word + "' is not strict";
}

std::string checkPercent(const std::string& text)
{
	const bool unit =
		!text.empty() && text.back() != '%' && text.back() != '.' && (text.back() < '0' || text.back() > '9');
	return unit ? "--size takes per cent of the radius, not '" + text + "'; use --s0 for a length" : "";
}

cli::Length shareOf(const cli::Length& percent)
{
	// --size 3.5 and --size 3.5% mean the same share of the radius.
	if (percent.shareOfRadius) return percent;
	return {percent.value / 100, true, percent.text + "%"};
}
}  // namespace

void addSelection(CLI::App& command, Selection& selection)
{
	CLI::Option* exact =
		command.add_flag("--exact", selection.exact, "Leaf level only: every contact at full resolution");
	CLI::Option* s0 = cli::addLength(command, "--s0", selection.s0, "The paper's threshold on the weighted deviation");
	CLI::Option* size =
		cli::addLength(command, "--size", selection.size, "The same threshold in per cent of the radius (3.5 = 3.5%)")
			->type_name("PCT")
			->check(checkPercent);
	CLI::Option* error = cli::addLength(command, "--max-error", selection.maxError,
										"Certified limit of the gap's error, never exceeded (default 0.5% when no "
										"selection is given)");
	exact->excludes(s0)->excludes(size)->excludes(error);
	s0->excludes(size);
	command.add_option("--combine", selection.combine, "How several thresholds combine: strict = all must allow")
		->check(checkCombine)
		->capture_default_str();
	command.add_flag("--paper", selection.paper,
					 "The paper's culling and contact rules; meshes are then built with --paper");
	command.add_flag("--fresh", selection.fresh, "Drop all caches before every query");
	addRefused(command, "--velocity", "K");
	addRefused(command, "--view", "PIXELS");
	addRefused(command, "--budget-tests", "N");
	addRefused(command, "--budget-us", "T");
}

ContactMetric toMetric(const Selection& selection)
{
	ContactMetric metric;
	metric.exact = selection.exact;
	const auto set = [](const cli::Length& length, double& absolute, double& share)
	{ (length.shareOfRadius ? share : absolute) = length.value; };
	if (selection.s0) set(*selection.s0, metric.weightedDeviation, metric.weightedDeviationShare);
	if (selection.size) set(shareOf(*selection.size), metric.weightedDeviation, metric.weightedDeviationShare);
	if (selection.maxError) set(*selection.maxError, metric.maxError, metric.maxErrorShare);
	const bool any = selection.exact || selection.s0 || selection.size || selection.maxError;
	if (!any) metric.maxErrorShare = kDefaultMaxError;
	return metric;
}

std::string describe(const Selection& selection, double radius)
{
	if (selection.exact) return "exact";
	std::string text;
	const auto add = [&](const std::string& words) { text += (text.empty() ? "" : ", ") + words; };
	if (selection.s0) add("s0 " + cli::describe(*selection.s0, radius));
	if (selection.size) add("s0 " + cli::describe(shareOf(*selection.size), radius));
	if (selection.maxError) add("certified error at most " + cli::describe(*selection.maxError, radius));
	if (text.empty())
		add("certified error at most " + cli::describe(cli::Length{kDefaultMaxError, true, "0.5%"}, radius));
	return text;
}

nlohmann::ordered_json toJson(const Selection& selection, double radius)
{
	MetricFrame frame;
	frame.radius = radius;
	const Metric metric = resolve(toMetric(selection), frame);
	return {{"description", describe(selection, radius)},
			{"exact", metric.exact},
			{"s0", metric.weightedDeviation},
			{"max_error", metric.maxError},
			{"combine", selection.combine},
			{"paper", selection.paper},
			{"fresh", selection.fresh}};
}
}  // namespace clod::demo
