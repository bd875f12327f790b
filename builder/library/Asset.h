// SPDX-License-Identifier: GPL-3.0-or-later
// From a mesh as read to the whole asset: what clod-build and the library (clod/builder/Builder.h) share.
#pragma once
#include <optional>

#include "builder/repair/Repair.h"

namespace clod::builder
{
// What may be done to a mesh that is not sound. Lengths in the mesh's unit.
struct Mending
{
	bool repair = false;
	std::optional<double> maxMove;  // none: kMaxMove of the radius
	std::optional<double> wrap;     // instead of repair
	std::size_t mostTriangles = 0;  // of a wrap; 0: any number
};
inline constexpr double kMaxMove = 0.25;  // of the radius: more is another shape, which must be asked for

// Of the bounding sphere of what faces use, coordinates that are no numbers left out.
double radiusOf(const Soup& soup);

// The solid to build. Throws Refused, Cancelled.
Repaired solidOf(const Soup& soup, const Mending& mending, const Progress& progress);

// The hierarchy with mass properties, the body's place in the file's frame, and the number of components. Throws
// Cancelled.
HierarchyContent buildAsset(const Intake& solid, const BuildConfig& config, const Progress& progress);
}  // namespace clod::builder
