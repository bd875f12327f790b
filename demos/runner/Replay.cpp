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
			{"gap_us", spread(column(rows, [](const ReplayRow& r) { return r.gapMicroseconds; }))},
			{"front", spread(column(rows, [](const ReplayRow& r) { return double(r.stats.front); }))},
			{"hull_tests", spread(column(rows, [](const ReplayRow& r) { return double(r.tests()); }))},
			{"contacts", spread(column(rows, [](const ReplayRow& r) { return double(r.contacts); }))},
			{"min_distance", spread(column(rows, [](const ReplayRow& r) { return r.minDistance; }))},
			{"error_bound", spread(column(rows, [](const ReplayRow& r) { return r.errorBound; }))}};
}
}  // namespace

double MeasuredQuery::timed(const Transform& aFromB, const Settings& settings, PairCache& cache,
							QueryResult& result) const
{
	if (m_fresh) cache.clear();
	const auto start = std::chrono::steady_clock::now();
	query(m_a, m_b, aFromB, settings, cache, result);
	return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

ReplayRow MeasuredQuery::at(const PoseRow& poses)
{
	const Transform aFromB = relativePose(poses, meshFromBody(m_a), meshFromBody(m_b));
	Settings contactsOnly = m_settings;
	contactsOnly.contactsOnly = true;
	contactsOnly.distance = false;
	ReplayRow row;
	row.step = poses.step;
	row.queryMicroseconds = timed(aFromB, contactsOnly, m_contactCache, m_contacts);
	row.gapMicroseconds = timed(aFromB, m_settings, m_gapCache, m_gap);
	row.contacts = m_contacts.contacts.size();
	row.minDistance = m_gap.minDistance;
	row.errorBound = m_gap.errorBound;
	row.deep = m_gap.deep;
	row.stats = m_contacts.stats;
	row.stats.pointQueries = m_gap.stats.pointQueries;
	// With a signed gap asked for at any separation, the time is that of the gap.
	if (m_settings.distance) row.queryMicroseconds = row.gapMicroseconds;
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
	const std::vector<double> speeds = relativeSpeeds(a, b, poses, options.dt);
	std::vector<ReplayRow> rows;
	for (int pass = 0; pass < options.repeat; ++pass)
	{
		MeasuredQuery measured(a, b, options.settings, options.fresh);
		for (std::size_t i = 0; i < poses.size(); ++i)
		{
			ReplayRow row = measured.at(poses[i]);
			row.speed = speeds[i];
			if (pass == 0)
				rows.push_back(row);
			else if (!sameAnswer(row, rows[i]))
				throw cli::Failure(
					cli::ExitCode::verificationFailed,
					fmt::format("row {} (step {}): pass {} answers differently from the first", i, row.step, pass + 1));
			rows[i].queryMicroseconds = std::min(rows[i].queryMicroseconds, row.queryMicroseconds);
			rows[i].gapMicroseconds = std::min(rows[i].gapMicroseconds, row.gapMicroseconds);
			progress((pass + double(i + 1) / double(poses.size())) / options.repeat);
		}
	}
	return rows;
}

std::string formatReplay(const std::vector<ReplayRow>& rows)
{
	std::string text =
		"step,query_us,front,hull_tests,contacts,min_distance,error_bound,finest_level,coarsest_level,"
		"gap_us,box_tests,gjk_runs,skipped_by_slack,point_queries,restarts,deep,speed_radii_per_s,motion,front_inner,"
		"duplicates\n";
	for (const ReplayRow& r : rows)
		text += fmt::format("{},{:.3f},{},{},{},{},{},{},{},{:.3f},{},{},{},{},{},{},{:.5g},{},{},{}\n", r.step,
							r.queryMicroseconds, r.stats.front, r.tests(), r.contacts, number(r.minDistance),
							number(r.errorBound), r.stats.finestLevel, r.stats.coarsestLevel, r.gapMicroseconds,
							r.stats.boxTests, r.stats.hullTests, r.stats.skippedBySlack, r.stats.pointQueries,
							r.stats.restarts, int(r.deep), r.speed, name(r.motion()), r.stats.frontInner,
							r.stats.duplicates);
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
