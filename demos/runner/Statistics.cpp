// SPDX-License-Identifier: Zlib
// Order statistics and swings.
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

std::vector<double> swingAmplitudes(const std::vector<double>& values, double noise)
{
	if (values.empty()) return {};
	const auto [least, largest] = std::minmax_element(values.begin(), values.end());
	const double tremble = noise * (*largest - *least);
	const auto peakAt = [&](std::size_t i)
	{
		if (i == 0 || i + 1 == values.size()) return values[i];
		const double before = values[i - 1] - values[i], after = values[i + 1] - values[i], bend = before + after;
		return bend == 0 ? values[i] : values[i] - (after - before) * (after - before) / (8 * bend);
	};
	std::vector<double> amplitudes;
	double last = values[0];
	std::size_t extreme = 0;
	int sense = 0;  // of the way to the extreme; none yet
	for (std::size_t i = 1; i < values.size(); ++i)
	{
		const double way = values[i] - values[extreme];
		if (sense * way > 0)
			extreme = i;
		else if (std::fabs(way) > tremble)
		{
			const double peak = peakAt(extreme);
			if (sense != 0) amplitudes.push_back(0.5 * std::fabs(peak - last));
			last = peak;
			sense = way > 0 ? 1 : -1;
			extreme = i;
		}
	}
	return amplitudes;
}

nlohmann::ordered_json spread(const std::vector<double>& values)
{
	const double sum = std::accumulate(values.begin(), values.end(), 0.0);
	return {{"median", quantile(values, 0.5)},     {"q1", quantile(values, 0.25)}, {"q3", quantile(values, 0.75)},
			{"p95", quantile(values, 0.95)},       {"min", quantile(values, 0)},   {"max", quantile(values, 1)},
			{"mean", sum / double(values.size())}, {"count", values.size()}};
}

}  // namespace clod::demo
