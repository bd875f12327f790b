// SPDX-License-Identifier: GPL-3.0-or-later
// Parents and children between two neighbouring levels, from the pieces of surface they share.
#pragma once
#include <functional>

#include "builder/assemble/Assignment.h"

namespace clod::builder
{
struct LevelLinks
{
	std::vector<std::vector<std::uint32_t>> children;  // per coarse patch, sorted; all patches it shares surface with
	std::vector<std::uint32_t> primaryParent;          // per fine patch: one of the coarse patches that list it
};

// Every coarse patch gets at least one primary child. A fine patch's primary parent is the one it shares most surface
// with, except where a coarse patch would be left without: then an alternating path of second choices is taken, and as
// the last resort the nearest fine patch that can be spared (by `distance`) becomes a child as well.
LevelLinks linkLevels(const std::vector<Overlap>& overlaps, std::uint32_t fineCount, std::uint32_t coarseCount,
					  const std::function<double(std::uint32_t coarse, std::uint32_t fine)>& distance);
}  // namespace clod::builder
