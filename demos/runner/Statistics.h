// SPDX-License-Identifier: Zlib
// Order statistics of measured values, amplitudes of a swing, and the line that says on which machine they were
// measured.
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
// Half of the ways between a swing's successive turning points, each the peak of a parabola through three values: free
// of where the middle lies, and of when it was looked. Turns back of less than `noise` of the whole range are
// trembling.
std::vector<double> swingAmplitudes(const std::vector<double>& values, double noise);
// median, quartiles, p95, min, max, mean, count.
nlohmann::ordered_json spread(const std::vector<double>& values);
// Processor, cores, clock governor, compiler, build type, Bullet's version and precision, commit.
nlohmann::ordered_json machine();
// Of the Bullet that the program is linked with.
bool hasDoublePrecision();
}  // namespace clod::demo
