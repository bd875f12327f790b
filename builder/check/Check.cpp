// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/check/Check.h"

#include <algorithm>

#include "builder/check/Subject.h"

namespace clod::check
{
std::vector<Invariant> checkHierarchy(const Hierarchy& hierarchy, const Options& options)
{
	const Subject subject(hierarchy, options);
	std::vector<Invariant> all;
	for (const auto group : {checkGraph, checkSurfaces, checkAsset, checkGiven, checkLocalNumbers, checkWalls,
							 checkConvexity, checkCulling, checkDeviation, checkCoverage})
	{
		const std::vector<Invariant> found = group(subject);
		all.insert(all.end(), found.begin(), found.end());
		// What follows takes a closed surface and a tree for granted.
		if (std::any_of(all.begin(), all.end(), [](const Invariant& i) { return i.violations > 0; })) break;
	}
	return all;
}
}  // namespace clod::check
