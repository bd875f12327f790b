// SPDX-License-Identifier: Zlib
// Order statistics.
#include "demos/runner/Statistics.h"

#include <nlohmann/json.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace clod::demo
{
double quantile(std::vector<double> values, double p)
{
	if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
	std::sort(values.begin(), values.end());
	const double place = p * double(values.size() - 1);
	const std::size_t below = std::size_t(place), above = std::min(below + 1, values.size() - 1);
	const double share = place - double(below);
	if (share == 0 || values[below] == values[above]) return values[below];  // infinities have no differences
	return values[below] + share * (values[above] - values[below]);
}

nlohmann::ordered_json spread(const std::vector<double>& values)
{
	const double sum = std::accumulate(values.begin(), values.end(), 0.0);
	return {{"median", quantile(values, 0.5)},     {"q1", quantile(values, 0.25)}, {"q3", quantile(values, 0.75)},
			{"p95", quantile(values, 0.95)},       {"min", quantile(values, 0)},   {"max", quantile(values, 1)},
			{"mean", sum / double(values.size())}, {"count", values.size()}};
}

}  // namespace clod::demo
