// SPDX-License-Identifier: GPL-3.0-or-later
// Hierarchies that one test has built and others need, too, each in a process of its own: in a folder of the build, by mesh
// and builder. ctest empties it first.
#pragma once
#include "demos/runner/HierarchyCache.h"

namespace clod::test
{
inline constexpr const char* kKeptHierarchies = CLOD_KEPT_HIERARCHIES;

inline demo::HierarchyCache& keptHierarchies()
{
	static demo::HierarchyCache cache({kKeptHierarchies, true}, true);
	return cache;
}
}  // namespace clod::test
