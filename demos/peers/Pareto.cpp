// SPDX-License-Identifier: Zlib
// Fronts and factors.
#include "demos/peers/Pareto.h"

#include <algorithm>
#include <map>
#include <string>

#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
double floored(double error, double floor)
{
	return error <= floor ? 0 : error;
}

bool atLeastAsExact(const Accuracy& ours, const Accuracy& peer, double floor)
{
	return floored(ours.gapMedian, floor) <= floored(peer.gapMedian, floor) &&
		   floored(ours.gapP95, floor) <= floored(peer.gapP95, floor);
}

std::vector<double> leastOf(const PassTimes& passes)
{
	std::vector<double> least;
	for (const std::vector<double>& pass : passes)
	{
		if (least.empty()) least = pass;
		for (std::size_t i = 0; i < least.size(); ++i) least[i] = std::min(least[i], pass[i]);
	}
	return least;
}
}  // namespace

void setTimes(TradeoffPoint& point, const PassTimes& passes, const PassTimes& atRest, const PassTimes& cold)
{
	std::vector<double> medians;
	for (const std::vector<double>& pass : passes) medians.push_back(quantile(pass, 0.5));
	const std::vector<double> least = leastOf(passes), still = leastOf(atRest), first = leastOf(cold);
	point.coldMedian = quantile(first, 0.5);
	point.coldP95 = quantile(first, 0.95);
	point.restMedian = quantile(still, 0.5);
	point.restP95 = quantile(still, 0.95);
	point.median = quantile(least, 0.5);
	point.q1 = quantile(least, 0.25);
	point.q3 = quantile(least, 0.75);
	point.p95 = quantile(least, 0.95);
	point.passLow = quantile(medians, 0);
	point.passHigh = quantile(medians, 1);
}

std::vector<TradeoffPoint> paretoFront(const std::vector<TradeoffPoint>& family)
{
	std::vector<TradeoffPoint> sorted = family, front;
	std::stable_sort(sorted.begin(), sorted.end(),
					 [](const TradeoffPoint& l, const TradeoffPoint& r) { return l.median < r.median; });
	double best = std::numeric_limits<double>::infinity();
	for (const TradeoffPoint& point : sorted)
	{
		if (!(point.accuracy.gapP95 < best)) continue;
		best = point.accuracy.gapP95;
		front.push_back(point);
	}
	return front;
}

bool isOurs(const PeerInfo& info)
{
	return std::find(std::begin(kOurFamilies), std::end(kOurFamilies), info.family) != std::end(kOurFamilies);
}

std::vector<ParetoRow> comparePareto(const std::vector<TradeoffPoint>& points, double floor)
{
	std::map<std::string, std::vector<TradeoffPoint>> families;
	std::vector<std::string> order;
	for (const TradeoffPoint& point : points)
	{
		if (isOurs(point.info)) continue;
		if (families[point.info.family].empty()) order.push_back(point.info.family);
		families[point.info.family].push_back(point);
	}
	std::vector<ParetoRow> rows;
	for (const std::string& family : order)
		for (const TradeoffPoint& peer : paretoFront(families[family]))
		{
			ParetoRow row;
			row.peer = peer;
			for (const TradeoffPoint& ours : points)
				if (isOurs(ours.info) && ours.info.timed == peer.info.timed &&
					atLeastAsExact(ours.accuracy, peer.accuracy, floor) &&
					(!row.ours || ours.median < row.ours->median))
					row.ours = ours;
			if (row.ours)
			{
				row.factor = peer.median / row.ours->median;
				row.restFactor = peer.restMedian / row.ours->restMedian;
			}
			rows.push_back(row);
		}
	return rows;
}
}  // namespace clod::demo
