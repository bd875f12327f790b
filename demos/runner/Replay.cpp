// SPDX-License-Identifier: Zlib
// Replay of recorded poses through the query layer.
#include "demos/runner/Replay.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <limits>

#include "cli/Failure.h"
#include "demos/paper/PaperQuery.h"
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

// How many elements are in one of two sorted lists only.
template <class Element>
std::size_t countDifferences(const std::vector<Element>& l, const std::vector<Element>& r)
{
	std::size_t common = 0;
	for (auto i = l.begin(), j = r.begin(); i != l.end() && j != r.end();)
	{
		common += *i == *j;
		const bool leftIsBehind = *i <= *j, rightIsBehind = *j <= *i;
		i += leftIsBehind;
		j += rightIsBehind;
	}
	return l.size() + r.size() - 2 * common;
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

double MeasuredQuery::timedContacts(const Transform& aFromB, const ContactSettings& settings)
{
	if (m_fresh) m_contactCache.clear();
	const auto start = std::chrono::steady_clock::now();
	contacts(m_a, m_b, aFromB, settings, m_contactCache, m_contacts);
	return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

double MeasuredQuery::timedGap(const Transform& aFromB, const GapSettings& settings)
{
	if (m_fresh) m_gapCache.clear();
	const auto start = std::chrono::steady_clock::now();
	if (m_paper)
		paperQuery(m_a, m_b, aFromB, settings, m_gap);
	else
		signedGap(m_a, m_b, aFromB, settings, m_gapCache, m_gap);
	return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

ReplayRow MeasuredQuery::at(const PoseRow& poses, const GapSettings& settings)
{
	const Transform aFromB = relativePose(poses, meshFromBody(m_a), meshFromBody(m_b));
	ReplayRow row;
	row.step = poses.step;
	row.bodyA = poses.bodyA;
	row.bodyB = poses.bodyB;
	if (m_paper)
	{
		// One walk does both.
		row.queryMicroseconds = row.gapMicroseconds = timedGap(aFromB, settings);
		m_contacts = m_gap;
	}
	else
	{
		GapSettings withGap = settings;
		withGap.metric.coarsening = m_control.coarsening(settings.budget);
		row.queryMicroseconds = timedContacts(aFromB, withGap);
		m_control.observe({double(m_contacts.stats.boxTests) + m_contacts.stats.hullTests, row.queryMicroseconds,
						   m_contacts.stats.cutShort > 0});
		// The gap is searched at what the budget has bought for the contacts.
		withGap.budget = {};
		if (m_contacts.stats.cutShort > 0) withGap.metric.coarsening = kOff;
		if (!m_contactsOnly) row.gapMicroseconds = timedGap(aFromB, withGap);
	}
	if (m_contactsOnly) m_gap = m_contacts;
	row.contacts = m_contacts.contacts.size();
	m_current.clear();
	for (const Contact& contact : m_contacts.contacts)
	{
		m_current.emplace_back(contact.nodeA, contact.nodeB);
		row.finestA = std::min(row.finestA, m_a.node(contact.nodeA).level);
		row.finestB = std::min(row.finestB, m_b.node(contact.nodeB).level);
	}
	row.churn = countDifferences(m_previous, m_current);
	std::swap(m_previous, m_current);
	row.minDistance = m_gap.minDistance;
	row.errorBound = m_gap.errorBound;
	row.deep = m_gap.deep;
	row.excess = m_contacts.excess;
	row.stats = m_contacts.stats;
	row.stats.pointQueries = m_gap.stats.pointQueries;
	row.stats.gapSearches = m_gap.stats.gapSearches;
	row.stats.depthsCutShort = m_gap.stats.depthsCutShort;
	// With a signed gap asked for at any separation, the time is that of the gap.
	if (settings.distance) row.queryMicroseconds = row.gapMicroseconds;
	return row;
}

std::string number(double value)
{
	if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
	char buffer[32];
	return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

double relativeSpeed(const Hierarchy& a, const Hierarchy& b, const PoseRow& from, const PoseRow& to, double seconds)
{
	const Asset& asset = b.asset();
	const Vec3 center{asset.sphereCenter[0], asset.sphereCenter[1], asset.sphereCenter[2]};
	const Transform before = relativePose(from, meshFromBody(a), meshFromBody(b));
	const Transform after = relativePose(to, meshFromBody(a), meshFromBody(b));
	return displacement(before, after, center, asset.radius) / (smallerRadius(a, b) * seconds);
}

double secondsBetween(const PoseRow& from, const PoseRow& to, const RowClock& clock)
{
	return clock.mayPause ? double(std::max<std::int64_t>(1, to.step - from.step)) * clock.dt : clock.dt;
}

std::vector<double> relativeSpeeds(const Hierarchy& a, const Hierarchy& b, const std::vector<PoseRow>& poses,
								   const RowClock& clock)
{
	std::vector<double> speeds(poses.size(), 0.0);
	for (std::size_t i = 1; i < poses.size(); ++i)
		speeds[i] = relativeSpeed(a, b, poses[i - 1], poses[i], secondsBetween(poses[i - 1], poses[i], clock));
	return speeds;
}

RelativeMotion relativeMotion(const Hierarchy& a, const Hierarchy& b, const PoseRow& from, const PoseRow& to,
							  double seconds)
{
	const Transform before = relativePose(from, meshFromBody(a), meshFromBody(b));
	const Transform after = relativePose(to, meshFromBody(a), meshFromBody(b));
	// Of B seen from A.
	const Vec3 angular = (1 / seconds) * rotationVector(after.rotation * transposed(before.rotation));
	const Vec3 linear = (1 / seconds) * (after.translation - before.translation) - cross(angular, after.translation);
	return {-1.0 * linear, -1.0 * angular, seconds};
}

GapSettings settingsOf(const ReplayOptions& options, const Hierarchy& a, const Hierarchy& b, const PoseRow& poses,
					const RelativeMotion& motion)
{
	MetricFrame frame;
	frame.radius = smallerRadius(a, b);
	frame.worldFromA = worldFromBody(poses.a, meshFromBody(a));
	frame.motion = motion;
	ViewCamera camera;
	if (options.camera) camera = options.camera->at(poses.step), frame.camera = &camera;
	GapSettings settings;
	settings.budget = options.budget;
	settings.metric = resolve(options.metric, frame);
	settings.tolerance = options.tolerance.inMeshUnit(frame.radius);
	settings.distance = options.distance;
	if (options.gapError) settings.gapError = options.gapError->inMeshUnit(frame.radius);
	return settings;
}

std::string optionsError(const ReplayOptions& options, const Bodies& bodies)
{
	std::string problem = contactMetricError(options.metric, options.camera ? &options.camera->start : nullptr);
	for (const Hierarchy* a : bodies)
		for (const Hierarchy* b : bodies)
			if (problem.empty())
			{
				const GapSettings settings = settingsOf(options, *a, *b, {}, {});
				problem = options.paper ? paperQueryError(*a, *b, settings) : settingsError(settings);
			}
	return problem;
}

PairQueries::PairQueries(Bodies bodies, const ReplayOptions& options) : m_bodies(std::move(bodies)), m_options(options)
{
}

ReplayRow PairQueries::at(const PoseRow& poses)
{
	const Hierarchy &a = *m_bodies[poses.bodyA], &b = *m_bodies[poses.bodyB];
	const std::pair<std::uint32_t, std::uint32_t> key{poses.bodyA, poses.bodyB};
	auto found = m_pairs.find(key);
	if (found == m_pairs.end()) found = m_pairs.emplace(key, Pair{MeasuredQuery(a, b, m_options), {}}).first;
	Pair& pair = found->second;
	RelativeMotion motion;
	double speed = 0;
	if (pair.previous)
	{
		const double seconds = secondsBetween(*pair.previous, poses, {m_options.dt, m_bodies.size() > 2});
		motion = relativeMotion(a, b, *pair.previous, poses, seconds);
		speed = relativeSpeed(a, b, *pair.previous, poses, seconds);
	}
	motion.timeStep = m_options.dt;
	ReplayRow row = pair.query.at(poses, settingsOf(m_options, a, b, poses, motion));
	row.speed = speed;
	pair.previous = poses;
	return row;
}

std::vector<ReplayRow> replay(const Bodies& bodies, const std::vector<PoseRow>& poses, const ReplayOptions& options,
							  const std::function<void(double)>& progress)
{
	std::vector<ReplayRow> rows;
	for (int pass = 0; pass < options.repeat; ++pass)
	{
		PairQueries queries(bodies, options);
		for (std::size_t i = 0; i < poses.size(); ++i)
		{
			const ReplayRow row = queries.at(poses[i]);
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

namespace
{
void add(QueryStats& sum, const QueryStats& stats)
{
	sum.front += stats.front;
	sum.frontInner += stats.frontInner;
	sum.boxTests += stats.boxTests;
	sum.hullTests += stats.hullTests;
	sum.skippedBySlack += stats.skippedBySlack;
	sum.stillApart += stats.stillApart;
	sum.frontKept += stats.frontKept;
	sum.frontCame += stats.frontCame;
	sum.frontGone += stats.frontGone;
	sum.duplicates += stats.duplicates;
	sum.pointBoxes += stats.pointBoxes;
	sum.pointQueries += stats.pointQueries;
	sum.pending += stats.pending;
	sum.cutShort += stats.cutShort;
	sum.gapSearches += stats.gapSearches;
	sum.depthsCutShort += stats.depthsCutShort;
}

// Levels of accepted nodes, over the pairs that have any.
void setLevels(QueryStats& sum, const std::vector<ReplayRow>& pairs)
{
	constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
	std::uint32_t finest = none, touched = none;
	for (const ReplayRow& pair : pairs)
	{
		touched = std::min(touched, pair.stats.touchedFinestLevel);
		if (pair.contacts == 0) continue;
		finest = std::min(finest, pair.stats.finestLevel);
		sum.coarsestLevel = std::max(sum.coarsestLevel, pair.stats.coarsestLevel);
	}
	sum.finestLevel = finest == none ? 0 : finest;
	sum.touchedFinestLevel = touched == none ? 0 : touched;
}

// The least gap of all pairs and a bound that holds for it.
void setGap(ReplayRow& sum, const std::vector<ReplayRow>& pairs, double tolerance)
{
	constexpr double infinity = std::numeric_limits<double>::infinity();
	double low = infinity, high = infinity;  // of the true least gap; high only counts where a gap was found
	sum.minDistance = infinity;
	for (const ReplayRow& pair : pairs)
	{
		sum.minDistance = std::min(sum.minDistance, pair.minDistance);
		low = std::min(low, std::min(pair.minDistance, tolerance) - pair.errorBound);
		high = std::min(high, pair.minDistance + pair.errorBound);
	}
	if (pairs.empty()) return;
	sum.errorBound =
		std::isinf(sum.minDistance) ? tolerance - low : std::max(sum.minDistance - low, high - sum.minDistance);
}
}  // namespace

ReplayRow sumOfPairs(const std::vector<ReplayRow>& pairs, double tolerance)
{
	if (pairs.size() == 1) return pairs[0];
	ReplayRow sum;
	if (pairs.empty()) sum.minDistance = std::numeric_limits<double>::infinity();
	const bool touching =
		std::any_of(pairs.begin(), pairs.end(), [&](const ReplayRow& r) { return r.contact(tolerance); });
	for (const ReplayRow& pair : pairs)
	{
		sum.step = pair.step;
		sum.queryMicroseconds += pair.queryMicroseconds;
		sum.gapMicroseconds += pair.gapMicroseconds;
		sum.contacts += pair.contacts;
		sum.churn += pair.churn;
		sum.deep = sum.deep || pair.deep;
		add(sum.stats, pair.stats);
		sum.excess = std::max(sum.excess, pair.excess);
		if (!touching || pair.contact(tolerance)) sum.speed = std::max(sum.speed, pair.speed);
	}
	setLevels(sum.stats, pairs);
	setGap(sum, pairs, tolerance);
	return sum;
}

std::vector<ReplayRow> sumsByStep(const std::vector<ReplayRow>& rows, double tolerance)
{
	std::vector<ReplayRow> sums;
	for (std::size_t i = 0; i < rows.size();)
	{
		std::vector<ReplayRow> pairs;
		for (const std::int64_t step = rows[i].step; i < rows.size() && rows[i].step == step; ++i)
			pairs.push_back(rows[i]);
		sums.push_back(sumOfPairs(pairs, tolerance));
	}
	return sums;
}

const char* name(Regime regime)
{
	constexpr const char* names[] = {"apart", "impact", "sliding", "resting"};
	return names[std::size_t(regime)];
}

std::vector<Regime> regimesOf(const std::vector<ReplayRow>& rows, double tolerance)
{
	std::vector<Regime> regimes;
	int rowsInContact = 0;
	for (const ReplayRow& row : rows)
	{
		rowsInContact = row.contact(tolerance) ? rowsInContact + 1 : 0;
		if (rowsInContact == 0)
			regimes.push_back(Regime::apart);
		else if (rowsInContact <= kImpactRows)
			regimes.push_back(Regime::impact);
		else
			regimes.push_back(row.motion() == Motion::rest ? Regime::resting : Regime::sliding);
	}
	return regimes;
}

std::string formatReplay(const std::vector<ReplayRow>& rows)
{
	std::string text =
		"step,query_us,front,hull_tests,contacts,min_distance,error_bound,finest_level,coarsest_level,"
		"gap_us,box_tests,gjk_runs,skipped_by_slack,point_queries,gap_searches,deep,speed_radii_per_s,motion,front_"
		"inner,"
		"duplicates,body_a,body_b,churn,pending,excess,cut_short,touched_finest_level,still_apart,front_kept,front_came,"
		"front_gone,depths_cut_short\n";
	for (const ReplayRow& r : rows)
	{
		const QueryStats& q = r.stats;
		text += fmt::format("{},{:.3f},{},{},{},{},{},{},{},{:.3f},{},{},{},{},{},{},{:.5g},{},{},{},{},{},{},{},{}",
							r.step, r.queryMicroseconds, q.front, r.tests(), r.contacts, number(r.minDistance),
							number(r.errorBound), q.finestLevel, q.coarsestLevel, r.gapMicroseconds, q.boxTests,
							q.hullTests, q.skippedBySlack, q.pointQueries, q.gapSearches, int(r.deep), r.speed,
							name(r.motion()), q.frontInner, q.duplicates, r.bodyA, r.bodyB, r.churn, q.pending,
							number(r.excess));
		text += fmt::format(",{},{},{},{},{},{},{}\n", q.cutShort, q.touchedFinestLevel, q.stillApart, q.frontKept,
							q.frontCame, q.frontGone, q.depthsCutShort);
	}
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
