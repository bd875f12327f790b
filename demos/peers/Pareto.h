// SPDX-License-Identifier: Zlib
// Measured settings, the best of each family, and what our settings have to set against them.
#pragma once
#include <limits>
#include <optional>
#include <vector>

#include "demos/peers/Accuracy.h"
#include "demos/peers/Peer.h"

namespace clod::demo
{
// Of one pass each, row by row.
using PassTimes = std::vector<std::vector<double>>;

struct TradeoffPoint
{
	PeerInfo info;
	double median = 0, q1 = 0, q3 = 0, p95 = 0;  // microseconds over the rows, each row the least of all passes
	double passLow = 0, passHigh = 0;            // the same median, of the fastest and slowest pass
	// Of dispatches at the same poses with no body moving; NaN for queries.
	double restMedian = std::numeric_limits<double>::quiet_NaN(), restP95 = restMedian;
	// Of a new pair's first dispatch, nothing in the processor's caches; and what a pair holds. NaN for queries.
	double coldMedian = restMedian, coldP95 = restMedian, pairBytes = restMedian;
	Accuracy accuracy;
};
void setTimes(TradeoffPoint& point, const PassTimes& passes, const PassTimes& atRest, const PassTimes& cold);

// Of the points of one family those that no other beats in median time and p95 error of the gap at once; by time.
std::vector<TradeoffPoint> paretoFront(const std::vector<TradeoffPoint>& family);

struct ParetoRow
{
	TradeoffPoint peer;
	std::optional<TradeoffPoint> ours;  // the fastest at no larger median and p95 error; none: no setting is so exact
	double factor = 0;                  // the peer's median time over ours; 0: none
	// The same two dispatches, no body moving; NaN for queries.
	double restFactor = std::numeric_limits<double>::quiet_NaN();
};
// For every point on the front of every family but ours: our answer of the same kind of time. Errors below `floor`
// are rounding and count as equal.
std::vector<ParetoRow> comparePareto(const std::vector<TradeoffPoint>& points, double floor);

inline constexpr const char* kOurFamilies[] = {"clod", "clod-gap", "clod-dispatch"};
bool isOurs(const PeerInfo& info);
}  // namespace clod::demo
