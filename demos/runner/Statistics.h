// SPDX-License-Identifier: Zlib
// Order statistics of measured values, and the line that says on which machine they were measured.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace clod::demo
{
// Behind every median that is printed, where there are so many; where there are fewer, the count stands beside it.
inline constexpr std::size_t kEnoughRows = 100;
// Linear interpolation between order statistics; p in [0, 1]; NaN for no values.
double quantile(std::vector<double> values, double p);
// median, quartiles, p95, min, max, mean, count.
nlohmann::ordered_json spread(const std::vector<double>& values);
// Processor, cores, clock governor, compiler, build type, Bullet's version and precision, commit.
nlohmann::ordered_json machine();
}  // namespace clod::demo
