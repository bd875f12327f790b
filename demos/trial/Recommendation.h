// SPDX-License-Identifier: Zlib
// Which setting to take for two meshes: the cheapest that keeps a stated accuracy, and the most accurate within a
// stated cost. Chosen on one set of poses, checked on fresh ones. Errors are shares of the smaller radius.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "clod/hierarchy/Hierarchy.h"
#include "clod/query/ContactMetric.h"
#include "demos/peers/Peer.h"
#include "demos/scenes/Poses.h"

namespace clod::demo
{
// Poses at which two bodies touch or almost do: B tumbles over A, and now and then starts anew elsewhere, so that
// caches are used as in a simulation. Gaps are spread evenly from a fifth of the tolerance deep to the tolerance.
struct TouchingPoses
{
	std::vector<PoseRow> rows;
	std::vector<double> gaps, bounds;  // of the input surfaces, and how wrong they can be: one a row; the meshes' unit
};
TouchingPoses touchingPoses(const Hierarchy& a, const Hierarchy& b, double tolerance, std::size_t count,
							std::uint64_t seed, const std::function<void(double)>& progress);

// What one certified limit costs and keeps over a set of poses.
struct LimitRow
{
	double share = 0;                  // the limit; 0: exact
	double certified = 0;              // the largest error bound of a row; inf: a row without proof
	double error = 0;                  // the largest true error of a row's gap
	std::size_t broken = 0;            // rows whose error is larger than their own bound
	double tests = 0;                  // hulls and boxes compared, median
	double microseconds = 0, p95 = 0;  // of the pair's whole dispatch in Bullet: what a step pays for it
	double contacts = 0;               // touching pairs of patches, median
};
ContactMetric limitMetric(double share);
// All but the times.
LimitRow measureLimit(const Hierarchy& a, const Hierarchy& b, double share, double tolerance,
					  const TouchingPoses& poses);
// The times: `dispatch` is asked once at every pose, in order.
void timeLimit(LimitRow& limit, Peer& dispatch, double tolerance, const TouchingPoses& poses, const RowClock& clock);
// Those that are tried: from 10 % of the radius down to exact, and the caller's own; coarsest first.
std::vector<double> limitShares(double own);

// A limit that was chosen: what it did there, and what it does on fresh poses.
struct Recommendation
{
	bool isFound = false;
	double wanted = 0;    // a share of the smaller radius, or microseconds
	double accuracy = 1;  // the share of the smaller radius that answers have to be certified to, whatever was chosen
	LimitRow chosen, fresh;
	std::size_t rows = 0;  // fresh
	// No row errs by more than its bound, and none is certified to more than the limit. Exact contacts have no limit of
	// their own: their gap errs by rounding alone, and of deep overlaps is certified as far as the search came.
	bool keepsAccuracy() const;
	// The median row compares as many hulls and boxes as where the limit was chosen, to kCostSlack.
	bool keepsCost() const;
};
inline constexpr double kCostSlack = 0.3;

// Of the limits no larger than `share`, coarsest first, the one with the fewest tests, the finest of equals; of those
// within `microseconds` the smallest; null where there is none.
const LimitRow* cheapestWithin(const std::vector<LimitRow>& limits, double share);
const LimitRow* mostAccurateWithin(const std::vector<LimitRow>& limits, double microseconds);
}  // namespace clod::demo
