// SPDX-License-Identifier: Zlib
// Lengths in pictures: all in millimetres, so that those of one picture, or of two, compare at a glance.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace clod::demo
{
inline std::string metricLength(double metres, int digits = 4)
{
	constexpr double kLeast = 1e-7;  // mm, an atom's size: less is none
	const double millimetres = 1e3 * metres, size = std::fabs(millimetres);
	if (size < kLeast) return "0 mm";
	const double unit = std::pow(10.0, std::floor(std::log10(size)) + 1 - digits);  // of the last digit
	const double rounded = std::round(millimetres / unit) * unit;
	char text[64];
	std::snprintf(text, sizeof text, "%.*f", int(std::clamp(-std::log10(unit) + 0.5, 0.0, 20.0)), rounded);
	std::string words = text;
	if (words.find('.') != std::string::npos) words.erase(words.find_last_not_of('0') + 1);
	if (words.back() == '.') words.pop_back();
	return words + " mm";
}
}  // namespace clod::demo
