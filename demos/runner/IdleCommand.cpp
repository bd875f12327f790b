// SPDX-License-Identifier: Zlib
// clod-bench idle: what a pair costs while nothing happens, beside two small convex hulls of Bullet.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <memory>

#include "demos/peers/IdleBench.h"
#include "demos/runner/Commands.h"
#include "demos/runner/PairSubject.h"
#include "demos/runner/Replay.h"
#include "demos/runner/Selection.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
struct IdleCommandOptions
{
	cli::CommonOptions common;
	CacheOptions cache;
	PairInput input;
	IdleOptions idle;
};

std::vector<Threshold> idleThresholds()
{
	std::vector<Threshold> thresholds(3);
	thresholds[0].metric = ContactMetric::exactly();
	thresholds[1].metric = ContactMetric::errorShare(kDefaultMaxError);
	thresholds[2].metric = ContactMetric::deviationShare(0.035);
	for (Threshold& threshold : thresholds) threshold.label = labelOf(threshold, 1);
	return thresholds;
}

nlohmann::ordered_json describe(const std::vector<IdleRow>& rows)
{
	nlohmann::ordered_json json = nlohmann::ordered_json::array();
	for (const IdleRow& row : rows)
	{
		const auto isHulls = [&](const IdleRow& r) { return r.state == row.state; };
		// The hulls are the last of their state.
		const IdleRow& hulls = *std::find_if(rows.rbegin(), rows.rend(), isHulls);
		json.push_back({{"state", name(row.state)},
						{"who", row.who},
						{"dispatch_us", spread(row.microseconds)},
						{"dispatch_mean_us", spread(row.means)},
						{"points", row.points},
						{"ratio_to_hulls", quantile(row.microseconds, 0.5) / quantile(hulls.microseconds, 0.5)}});
	}
	return json;
}

void print(const nlohmann::ordered_json& rows)
{
	fmt::print("{:<22}{:<30}{:>7}{:>12}{:>10}{:>10}{:>10}{:>9}{:>10}\n", "state", "pair", "poses", "median us", "q1",
			   "q3", "mean us", "points", "to hulls");
	for (const auto& row : rows)
	{
		const auto& us = row["dispatch_us"];
		fmt::print("{:<22}{:<30}{:>7}{:>12.2f}{:>10.2f}{:>10.2f}{:>10.2f}{:>9.1f}{:>10.2f}\n",
				   row["state"].get<std::string>(), row["who"].get<std::string>(), us["count"].get<int>(),
				   us["median"].get<double>(), us["q1"].get<double>(), us["q3"].get<double>(),
				   row["dispatch_mean_us"]["mean"].get<double>(), row["points"].get<double>(),
				   row["ratio_to_hulls"].get<double>());
	}
}

void runIdle(const IdleCommandOptions& options)
{
	cli::requireWritable({options.common.json});
	HierarchyCache cache(options.cache, options.common.quiet);
	cli::Progress progress(options.common.quiet);
	const PairSubject subject = pairSubject(options.input, cache, progress);
	progress.finish();
	const HierarchyPointer &a = subject.models.a, &b = subject.models.b;
	const std::vector<IdleRow> rows = measureIdle(
		a, b, subject.poses, idleThresholds(), pairFrame(*a, *b, subject.worldScale, subject.tolerance), options.idle);
	if (rows.empty()) throw cli::Failure(cli::ExitCode::badInput, "no row of " + subject.title + " touches");
	nlohmann::ordered_json report = startReport("idle");
	report["subject"] = subject.title;
	report["models"] = {describeHierarchy(*a, "a"), describeHierarchy(*b, "b")};
	report["dispatches"] = options.idle.dispatches;
	report["tolerance"] = subject.tolerance;
	report["rows"] = describe(rows);
	if (options.common.textOnStdout()) print(report["rows"]);
	writeReport(options.common.json, report);
}
}  // namespace

void addIdleCommand(CLI::App& program)
{
	auto options = std::make_shared<IdleCommandOptions>();
	CLI::App* command = program.add_subcommand(
		"idle", "What a pair costs while it is apart or unchanged, beside two convex hulls of 32 vertices in Bullet");
	command->footer(
		"Example: clod-bench idle spoon-cup --steps 400\n"
		"         clod-bench idle cup.clod spoon.clod poses.csv");
	addPairInput(*command, options->input);
	command->add_option("--poses", options->idle.poses, "At most so many of each state")
		->type_name("N")
		->check(CLI::Range(1, 100'000))
		->capture_default_str();
	command->add_option("--dispatches", options->idle.dispatches, "Measured at each pose")
		->type_name("N")
		->check(CLI::Range(1, 1'000'000))
		->capture_default_str();
	addCache(*command, options->cache);
	cli::addQuiet(*command, options->common);
	cli::addJson(*command, options->common);
	command->callback([options] { runIdle(*options); });
}
}  // namespace clod::demo
