// SPDX-License-Identifier: Zlib
// Runs the methods and writes what came out.
#include "demos/peers/Tradeoff.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

#include "cli/Failure.h"
#include "demos/runner/Replay.h"

namespace clod::demo
{
namespace
{
std::string label(const PeerInfo& info)
{
	return info.family + " " + info.setting;
}

std::vector<RowAccuracy> compareAll(const ExactSample& sample, const std::vector<PeerAnswer>& answers,
									const Tradeoff& tradeoff)
{
	AccuracyRules rules;
	rules.tolerance = tradeoff.tolerance;
	rules.near = kNearShare * tradeoff.radius;
	rules.place = kPlaceShare * tradeoff.radius;
	rules.rounding = tradeoff.floor;
	std::vector<RowAccuracy> rows;
	for (std::size_t i = 0; i < answers.size(); ++i) rows.push_back(compare(sample.exact[i], answers[i], rules));
	return rows;
}

std::vector<double> timesOf(const std::vector<PeerAnswer>& answers)
{
	std::vector<double> times;
	for (const PeerAnswer& answer : answers) times.push_back(answer.microseconds);
	return times;
}

double medianBytes(const std::vector<PeerAnswer>& answers)
{
	std::vector<double> bytes;
	for (const PeerAnswer& answer : answers) bytes.push_back(answer.bytes);
	return quantile(std::move(bytes), 0.5);
}

std::string optional(double value)
{
	return std::isnan(value) ? "" : number(value);
}

nlohmann::ordered_json describe(const TradeoffPoint& point)
{
	const Accuracy& a = point.accuracy;
	return {{"family", point.info.family},
			{"setting", point.info.setting},
			{"timed", name(point.info.timed)},
			{"size_a", point.info.sizeA},
			{"size_b", point.info.sizeB},
			{"us", {{"median", point.median}, {"q1", point.q1}, {"q3", point.q3}, {"p95", point.p95}}},
			{"us_pass", {point.passLow, point.passHigh}},
			{"us_at_rest", {{"median", point.restMedian}, {"p95", point.restP95}}},
			{"us_cold", {{"median", point.coldMedian}, {"p95", point.coldP95}}},
			{"pair_bytes", point.pairBytes},
			{"gap_error", {{"median", a.gapMedian}, {"p95", a.gapP95}, {"max", a.gapMax}}},
			{"normal_error_degrees", {{"median", a.normalMedian}, {"p95", a.normalP95}}},
			{"covered", {{"mean", a.coveredMean}, {"p5", a.coveredLow}}},
			{"founded", a.foundedMean},
			{"contacts", a.contactsMedian},
			{"missed_rows", a.missedShare},
			{"build_seconds", point.info.buildSeconds},
			{"bytes", point.info.bytes}};
}

// "-" where no row has the figure.
std::string figure(double value, int digits)
{
	return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, digits);
}

std::string line(const TradeoffPoint& point, double radius)
{
	const Accuracy& a = point.accuracy;
	return fmt::format("{:<16}{:<26}{:>10.1f}{:>10.1f}{:>10}{:>11.4f}{:>11.4f}{:>9}{:>9}{:>9}{:>9}{:>9.0f}{:>8.0f}\n",
					   point.info.family, point.info.setting, point.median, point.p95, figure(point.restMedian, 1),
					   100 * a.gapMedian / radius, 100 * a.gapP95 / radius, figure(a.normalMedian, 2),
					   figure(a.normalP95, 1), figure(100 * a.coveredMean, 0), figure(100 * a.foundedMean, 0),
					   a.contactsMedian, 100 * a.missedShare);
}

std::string verdict(const ParetoRow& row)
{
	if (!row.ours) return "no setting is so exact";
	return row.factor >= kWantedFactor ? "answered" : "too slow";
}
}  // namespace

void measure(Tradeoff& tradeoff, std::vector<PeerPointer>& peers, const ExactSample& sample, int passes,
			 const std::function<void(double)>& progress)
{
	tradeoff.rows = sample.exact.size();
	tradeoff.passes = passes;
	std::vector<PassTimes> times(peers.size()), atRest(peers.size()), cold(peers.size());
	std::vector<TradeoffPoint> points(peers.size());
	const PoseSample still = sample.sample.atRest(), first = sample.sample.cold();
	for (int pass = 0; pass < passes; ++pass)
		for (std::size_t i = 0; i < peers.size(); ++i)
		{
			progress((pass + double(i) / double(peers.size())) / passes);
			if (!peers[i]) continue;
			try
			{
				const std::vector<PeerAnswer> answers = peers[i]->pass(sample.sample);
				times[i].push_back(timesOf(answers));
				if (peers[i]->info().timed == Timed::dispatch)
				{
					atRest[i].push_back(timesOf(peers[i]->pass(still)));
					cold[i].push_back(timesOf(peers[i]->pass(first)));
					points[i].pairBytes = medianBytes(answers);  // the last pass's: a thread's scratch has grown before
				}
				if (pass == 0) points[i].accuracy = summarize(compareAll(sample, answers, tradeoff));
				points[i].info = peers[i]->info();
			}
			catch (const cli::Failure& failure)
			{
				tradeoff.leftOut.push_back({label(peers[i]->info()), failure.what()});
				peers[i].reset();
			}
		}
	for (std::size_t i = 0; i < peers.size(); ++i)
	{
		if (!peers[i]) continue;
		setTimes(points[i], times[i], atRest[i], cold[i]);
		tradeoff.points.push_back(points[i]);
	}
	progress(1);
}

std::string formatPoints(const Tradeoff& tradeoff)
{
	std::string text =
		"family,setting,timed,size_a,size_b,us_median,us_q1,us_q3,us_p95,us_pass_low,us_pass_high,gap_error_median,"
		"gap_error_p95,gap_error_max,normal_error_median_deg,normal_error_p95_deg,covered_mean,covered_p5,founded_mean,"
		"contacts_median,missed_rows,build_seconds,bytes,us_rest_median,us_rest_p95,us_cold_median,us_cold_p95,pair_bytes,rows\n";
	for (const TradeoffPoint& p : tradeoff.points)
	{
		const Accuracy& a = p.accuracy;
		text += fmt::format(
			"{},{},{},{},{},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n",
			p.info.family, p.info.setting, name(p.info.timed), p.info.sizeA, p.info.sizeB, p.median, p.q1, p.q3, p.p95,
			p.passLow, p.passHigh, number(a.gapMedian), number(a.gapP95), number(a.gapMax), optional(a.normalMedian),
			optional(a.normalP95), optional(a.coveredMean), optional(a.coveredLow), optional(a.foundedMean),
			number(a.contactsMedian), number(a.missedShare), optional(p.info.buildSeconds), p.info.bytes,
			optional(p.restMedian), optional(p.restP95), optional(p.coldMedian), optional(p.coldP95),
			optional(p.pairBytes), tradeoff.rows);
	}
	return text;
}

std::string formatPareto(const Tradeoff&, const std::vector<ParetoRow>& rows)
{
	std::string text =
		"family,setting,us_median,gap_error_median,gap_error_p95,covered_mean,ours,ours_setting,ours_us_median,"
		"ours_gap_error_median,ours_gap_error_p95,ours_covered_mean,factor,verdict,factor_at_rest\n";
	for (const ParetoRow& row : rows)
	{
		const TradeoffPoint& peer = row.peer;
		text += fmt::format("{},{},{:.3f},{},{},{},", peer.info.family, peer.info.setting, peer.median,
							number(peer.accuracy.gapMedian), number(peer.accuracy.gapP95),
							optional(peer.accuracy.coveredMean));
		if (row.ours)
			text +=
				fmt::format("{},{},{:.3f},{},{},{},{:.3f},", row.ours->info.family, row.ours->info.setting,
							row.ours->median, number(row.ours->accuracy.gapMedian), number(row.ours->accuracy.gapP95),
							optional(row.ours->accuracy.coveredMean), row.factor);
		else
			text += ",,,,,,,";
		text += verdict(row) + "," + optional(row.restFactor) + "\n";
	}
	return text;
}

std::string printable(const Tradeoff& tradeoff, const std::vector<ParetoRow>& rows)
{
	std::string text = fmt::format(
		"{} rows{}, {} passes; bodies move as recorded, at rest: the same dispatches without velocities; errors in % "
		"of "
		"the smaller radius ({:.4g}); normals in degrees; shares in %\n"
		"{:<16}{:<26}{:>10}{:>10}{:>10}{:>11}{:>11}{:>9}{:>9}{:>9}{:>9}{:>9}{:>8}\n",
		tradeoff.rows, tradeoff.rows < kEnoughRows ? " only" : "", tradeoff.passes, tradeoff.radius, "method",
		"setting", "median us", "p95 us", "at rest", "gap error", "p95", "normal", "p95", "covered", "founded",
		"contacts", "missed");
	for (const TradeoffPoint& point : tradeoff.points) text += line(point, tradeoff.radius);
	text += fmt::format(
		"\nfronts of the peers, and our fastest setting at no larger median and p95 error\n"
		"{:<16}{:<26}{:>10}{:>11}{:>11}  {:<18}{:>10}{:>9}{:>9}  {}\n",
		"method", "setting", "median us", "gap error", "p95", "ours", "median us", "factor", "at rest", "verdict");
	std::size_t answered = 0;
	for (const ParetoRow& row : rows)
	{
		answered += row.factor >= kWantedFactor ? 1 : 0;
		text +=
			fmt::format("{:<16}{:<26}{:>10.1f}{:>11.4f}{:>11.4f}  {:<18}{:>10}{:>9}{:>9}  {}\n", row.peer.info.family,
						row.peer.info.setting, row.peer.median, 100 * row.peer.accuracy.gapMedian / tradeoff.radius,
						100 * row.peer.accuracy.gapP95 / tradeoff.radius, row.ours ? row.ours->info.setting : "-",
						row.ours ? fmt::format("{:.1f}", row.ours->median) : "-",
						row.ours ? fmt::format("{:.2f}", row.factor) : "-", figure(row.restFactor, 2), verdict(row));
	}
	text += fmt::format("{} of {} points of the peers' fronts are answered at least {:g} times faster\n", answered,
						rows.size(), kWantedFactor);
	for (const LeftOut& what : tradeoff.leftOut) text += fmt::format("left out: {}: {}\n", what.what, what.reason);
	return text;
}

nlohmann::ordered_json toJson(const Tradeoff& tradeoff, const std::vector<ParetoRow>& rows)
{
	nlohmann::ordered_json json = {{"rows", tradeoff.rows},
								   {"passes", tradeoff.passes},
								   {"radius", tradeoff.radius},
								   {"tolerance", tradeoff.tolerance},
								   {"near", kNearShare * tradeoff.radius},
								   {"place", kPlaceShare * tradeoff.radius},
								   {"error_floor", tradeoff.floor},
								   {"wanted_factor", kWantedFactor}};
	json["points"] = nlohmann::ordered_json::array();
	json["pareto"] = nlohmann::ordered_json::array();
	json["left_out"] = nlohmann::ordered_json::array();
	for (const TradeoffPoint& point : tradeoff.points) json["points"].push_back(describe(point));
	for (const ParetoRow& row : rows)
		json["pareto"].push_back({{"peer", row.peer.info.family},
								  {"setting", row.peer.info.setting},
								  {"ours", row.ours ? row.ours->info.setting : ""},
								  {"factor", row.factor},
								  {"factor_at_rest", row.restFactor},
								  {"verdict", verdict(row)}});
	for (const LeftOut& what : tradeoff.leftOut)
		json["left_out"].push_back({{"what", what.what}, {"reason", what.reason}});
	return json;
}
}  // namespace clod::demo
