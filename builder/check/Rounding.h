// SPDX-License-Identifier: GPL-3.0-or-later
// Stored floats against numbers computed again in double: equal but for where the last bits of the double decide.
#pragma once
#include <cmath>
#include <limits>

#include <clod/collide/Vector.h>

namespace clod::check
{
constexpr double kStored = 2.5e-4;  // bounds are stored to 13 bits

// Whether `stored` is the float next to some number within `noise` of `value`.
inline bool isNearestOf(float stored, double value, double noise)
{
	return stored >= roundToFloat(value - noise) && stored <= roundToFloat(value + noise);
}
// Whether `stored` is the smallest float not below some number within `noise` of `value`.
inline bool isNextAbove(float stored, double value, double noise)
{
	constexpr float kEndless = std::numeric_limits<float>::infinity();
	return double(stored) >= value - noise && double(std::nextafter(stored, -kEndless)) < value + noise;
}
inline bool isNextBelow(float stored, double value, double noise)
{
	return isNextAbove(-stored, -value, noise);
}
// Whether `stored`, of 13 significant bits, is the largest such number not above some number within `noise` of `value`,
// or so many such roundings less.
inline bool isGridBelow(float stored, double value, double noise, int roundings = 1)
{
	if (stored == 0) return value - noise < 1e-30;
	const double step = std::ldexp(1.0, std::ilogb(stored) - 12);
	return double(stored) <= value + noise && double(stored) + roundings * step > value - noise;
}
}  // namespace clod::check
