// SPDX-License-Identifier: Zlib
// What rows share: rates, names of cases, a floor.
#pragma once
#include <fmt/format.h>

#include <vector>

#include "demos/extremes/Stage.h"

namespace clod::demo
{
using Readings = std::vector<Reading>;

inline const std::vector<double> kRates = {240, 60};
inline const std::vector<double> kAnalyticRates = {240, 60, 1000};
inline const std::vector<double> kGimpactRates = {240, 60, 480};  // where a step takes milliseconds
inline constexpr double kHalfFloor = 0.5;
inline constexpr double kDegree = kPi / 180;

inline std::vector<Case> casesOf(const std::vector<double>& parameters, const char* unit)
{
	std::vector<Case> cases;
	for (const double p : parameters) cases.push_back({p, fmt::format("{:g}{}", p, unit)});
	return cases;
}
inline std::vector<Case> countsOf(const std::vector<int>& counts, const char* what)
{
	std::vector<Case> cases;
	for (const int count : counts) cases.push_back({double(count), fmt::format("{} {}", count, what)});
	return cases;
}
inline std::vector<Case> triangles(const std::vector<int>& counts)
{
	return countsOf(counts, "triangles");
}
inline std::vector<Case> sides(const std::vector<int>& counts)
{
	return countsOf(counts, "sides");
}
inline std::size_t parameterCount(const Setting& setting)
{
	return std::size_t(setting.parameter);
}

// A slab whose upper side is y = 0.
inline std::size_t addFloor(Stage& stage, double length = 60)
{
	return stage.add(boxSolid({length, 1, 10}), fixedAt({{0, -kHalfFloor, 0}}));
}
// Turned about x, so that a solid about y rolls along x.
inline Pose lyingAt(const Vec3& place)
{
	return turnedAbout({1, 0, 0}, kPi / 2, place);
}
}  // namespace clod::demo
