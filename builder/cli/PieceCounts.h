// SPDX-License-Identifier: GPL-3.0-or-later
// How few convex pieces a hierarchy needs for a certified error: the measure of how coarse a build is.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include <clod/hierarchy/Hierarchy.h>

namespace clod::builder
{
// Shares of the radius that `info` counts pieces at.
inline constexpr std::array<double, 5> kErrorShares = {0.001, 0.003, 0.01, 0.03, 0.1};

struct PieceCount
{
	double error = 0;          // share of the radius that no piece's certified s exceeds
	std::uint32_t level = 0;   // the coarsest contact level all of whose patches are within it...
	std::uint32_t pieces = 0;  // ...and their number
	// Patches of mixed levels: the coarsest within it for each part of the surface, as a query with this
	// threshold selects them against a point (a patch counts where one of its parents is not within it).
	std::uint32_t mixed = 0;
};

std::vector<PieceCount> pieceCounts(const Hierarchy& hierarchy);
}  // namespace clod::builder
