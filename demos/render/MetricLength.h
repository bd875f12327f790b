// SPDX-License-Identifier: Zlib
// Lengths in pictures: in micrometres to metres, as their size suggests.
#pragma once
#include <cmath>
#include <cstdio>
#include <string>

namespace clod::demo
{
inline std::string metricLength(double metres, int digits = 4)
{
	struct Unit
	{
		double least, perMetre;
		const char* name;
	};
	constexpr Unit kUnits[] = {{1, 1, "m"}, {0.01, 1e2, "cm"}, {1e-5, 1e3, "mm"}, {0, 1e6, "µm"}};
	const Unit* unit = kUnits;
	while (std::fabs(metres) < unit->least) ++unit;
	char text[32];
	std::snprintf(text, sizeof text, "%.*g %s", digits, metres * unit->perMetre, unit->name);
	return text;
}
}  // namespace clod::demo
