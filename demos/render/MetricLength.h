// SPDX-License-Identifier: Zlib
// Lengths in pictures: in millimetres, centimetres or metres, as their size suggests.
#pragma once
#include <cmath>
#include <cstdio>
#include <string>

namespace clod::demo
{
inline std::string metricLength(double metres, int digits = 4)
{
	const double size = std::fabs(metres);
	const bool isMetres = size >= 1, isCentimetres = size >= 0.01;
	char text[32];
	std::snprintf(text, sizeof text, "%.*g %s", digits, metres * (isMetres ? 1 : isCentimetres ? 100 : 1000),
				  isMetres ? "m" : isCentimetres ? "cm" : "mm");
	return text;
}
}  // namespace clod::demo
