// SPDX-License-Identifier: Zlib
// Replay of recorded poses through the query layer.
#include "demos/runner/Replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <limits>

#include "demos/cli/Program.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
// Everything a query answers that must not depend on its caches.
bool sameAnswer(const ReplayRow& l, const ReplayRow& r)
{
	return l.contacts == r.contacts && l.minDistance == r.minDistance && l.errorBound == r.errorBound &&
		   l.deep == r.deep && l.stats.finestLevel == r.stats.finestLevel &&
		   l.stats.coarsestLevel == r.stats.coarsestLevel;
}

std::vector<double> column(const std::vector<ReplayRow>& rows, double (*value)(const ReplayRow&))
{
	std::vector<double> values;
	std::transform(rows.begin(), rows.end(), std::back_inserter(values), value);
	return values;
}

nlohmann::ordered_json figures(const std::vector<ReplayRow>& rows)
{
	if (rows.empty()) return {{"rows", 0}};
	return {{"rows", rows.size()},
			{"query_us", spread(column(rows, [](const ReplayRow& r) { return r.queryMicroseconds; }))},
			{"front", spread(column(rows, [](const ReplayRow& r) { return double(r.stats.front); }))},
			{"hull_tests", spread(column(rows, [](const ReplayRow& r) { return double(r.tests()); }))},
			{"contacts", spread(column(rows, [](const ReplayRow& r) { return double(r.contacts); }))},
			{"min_distance", spread(column(rows, [](const ReplayRow& r) { return r.minDistance; }))},
			{"error_bound", spread(column(rows, [](const ReplayRow& r) { return r.errorBound; }))}};
}
}  // namespace

ReplayRow measure(std::int64_t step, const QueryResult& result, double microseconds)
{
	ReplayRow row;
	row.step = step;
	row.queryMicroseconds = microseconds;
	row.contacts = result.contacts.size();
	row.minDistance = result.minDistance;
	row.errorBound = result.errorBound;
	row.deep = result.deep;
	row.stats = result.stats;
	return row;
}

std::string number(double value)
{
	if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
	char buffer[32];
	return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

std::vector<double> relativeSpeeds(const Hierarchy& a, const Hierarchy& b, const std::vector<PoseRow>& poses, double dt)
{
	std::vector<double> speeds(poses.size(), 0.0);
	const Asset& asset = b.asset();
	const Vec3 center{asset.sphereCenter[0], asset.sphereCenter[1], asset.sphereCenter[2]};
	const double unit = smallerRadius(a, b) * dt;
	for (std::size_t i = 1; i < poses.size(); ++i)
	{
		const Transform from = relativePose(poses[i - 1], meshFromBody(a), meshFromBody(b));
		const Transform to = relativePose(poses[i], meshFromBody(a), meshFromBody(b));
		speeds[i] = displacement(from, to, center, asset.radius) / unit;
	}
	return speeds;
}

std::vector<ReplayRow> replay(const Hierarchy& a, const Hierarchy& b, const std::vector<PoseRow>& poses,
							  const ReplayOptions& options, const std::function<void(double)>& progress)
{
	using Clock = std::chrono::steady_clock;
	const std::vector<double> speeds = relativeSpeeds(a, b, poses, options.dt);
	std::vector<ReplayRow> rows;
	QueryResult result;
	for (int pass = 0; pass < options.repeat; ++pass)
	{
		PairCache cache;
		for (std::size_t i = 0; i < poses.size(); ++i)
		{
			const Transform aFromB = relativePose(poses[i], meshFromBody(a), meshFromBody(b));
			if (options.fresh) cache.clear();
			const auto start = Clock::now();
			query(a, b, aFromB, options.settings, cache, result);
			const std::chrono::duration<double, std::micro> elapsed = Clock::now() - start;
			ReplayRow row = measure(poses[i].step, result, elapsed.count());
			row.speed = speeds[i];
			if (pass == 0)
				rows.push_back(row);
			else if (!sameAnswer(row, rows[i]))
				throw cli::Failure(
					cli::ExitCode::verificationFailed,
					fmt::format("row {} (step {}): pass {} answers differently from the first", i, row.step, pass + 1));
			rows[i].queryMicroseconds = std::min(rows[i].queryMicroseconds, row.queryMicroseconds);
			progress((pass + double(i + 1) / double(poses.size())) / options.repeat);
		}
	}
	return rows;
}

std::string formatReplay(const std::vector<ReplayRow>& rows)
{
	std::string text =
		"step,query_us,front,hull_tests,contacts,min_distance,error_bound,finest_level,coarsest_level,"
		"box_tests,gjk_runs,skipped_by_slack,point_queries,restarts,deep,speed_radii_per_s,motion\n";
	for (const ReplayRow& r : rows)
		text += fmt::format("{},{:.3f},{},{},{},{},{},{},{},{},{},{},{},{},{},{:.5g},{}\n", r.step, r.queryMicroseconds,
							r.stats.front, r.tests(), r.contacts, number(r.minDistance), number(r.errorBound),
							r.stats.finestLevel, r.stats.coarsestLevel, r.stats.boxTests, r.stats.hullTests,
							r.stats.skippedBySlack, r.stats.pointQueries, r.stats.restarts, int(r.deep), r.speed,
							name(r.motion()));
	return text;
}

nlohmann::ordered_json summarize(const std::vector<ReplayRow>& rows, double tolerance)
{
	std::vector<ReplayRow> moving, contact;
	std::copy_if(rows.begin(), rows.end(), std::back_inserter(contact),
				 [&](const ReplayRow& r) { return r.contact(tolerance); });
	std::copy_if(contact.begin(), contact.end(), std::back_inserter(moving),
				 [&](const ReplayRow& r) { return r.motion() == Motion::moving; });
	return {{"all_rows", figures(rows)}, {"contact_rows", figures(contact)}, {"moving_contact_rows", figures(moving)}};
}
}  // namespace clod::demo
