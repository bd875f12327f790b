// SPDX-License-Identifier: GPL-3.0-or-later
// Both entry points under one name, so that a test asks either at random: contacts alone, or the gap besides.
#pragma once
#include "clod/distance/SignedGap.h"

namespace clod::test
{
struct Settings : GapSettings
{
	Settings() = default;
	Settings(const GapSettings& settings) : GapSettings(settings) {}
	bool contactsOnly = false;
};

inline void query(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const Settings& settings,
				  GapCache& cache, GapResult& result)
{
	if (!settings.contactsOnly)
	{
		signedGap(a, b, aFromB, settings, cache, result);
		return;
	}
	contacts(a, b, aFromB, settings, cache.pair, result);
	result.minDistance = result.errorBound = std::numeric_limits<double>::infinity();
}
}  // namespace clod::test
