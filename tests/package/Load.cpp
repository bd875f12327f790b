// SPDX-License-Identifier: Zlib
// A consumer without an engine: the signed gap of a model and a turned copy, to the last bit.
#include <clod/distance/SignedGap.h>

#include <cstdio>

int main(int, char** arguments)
{
	const auto model = clod::Hierarchy::load(arguments[1]);
	if (!model) return std::puts(model.error().c_str()), 1;
	const clod::Hierarchy& hierarchy = *model.value();
	clod::GapCache cache;
	clod::GapResult result;
	clod::GapSettings settings;
	settings.tolerance = hierarchy.asset().radius;
	for (int step = 0; step < 8; ++step)
	{
		const clod::Transform pose{{{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}},
								   {0.1 * step * hierarchy.asset().radius, 0.3, 1.5 * hierarchy.asset().radius}};
		clod::signedGap(hierarchy, hierarchy, pose, settings, cache, result);
		std::printf("%a %a %zu\n", result.minDistance, result.errorBound, result.contacts.size());
	}
	return 0;
}
