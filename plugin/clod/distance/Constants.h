// SPDX-License-Identifier: Zlib
// The numbers that gaps and depths are searched and proved with. What the tuned ones buy: docs/tried.md, "Constants".
#pragma once
#include <cstddef>
#include <cstdint>

namespace clod
{
// Rounds a sum of a few terms up: 10^4 roundings.
inline constexpr double kSumUp = 1 + 1e-12;

// A gap is no worse known than to this share of the largest s0, contacts being near: at the paper's 3.5 % to 3 % of the
// radius (docs/tried.md, "How tight the bound is", has what 0.5 and 1 cost and give).
inline constexpr double kSharpness = 0.85;

// How exactly a depth is searched: of the smaller radius at least, of the depth, and in how many cells at most.
inline constexpr double kDepthAccuracy = 1e-6;
inline constexpr double kDepthShare = 0.01;  // 0.05 takes 6 % less
inline constexpr std::size_t kDepthCells = 4000;
inline constexpr std::size_t kMoreCells = 10;  // times, where the depth itself was asked for
// Of the tolerance: most depths are less, and few leaves are within it.
inline constexpr double kShallow = 0.2;
// Nodes that overlap hide a depth up to so many times their deviations.
inline constexpr double kHiddenDepth = 2.5;
// A cut that leaves less of a cell on one side only scratches it: it is halved instead.
inline constexpr double kScratch = 1e-3;
// The area of a face, of its longest edge's square, below which its normal tells nothing: corners are floats.
inline constexpr double kSliver = 1e-5;
// Of the length of a unit normal, so that nothing looks farther along it than it is.
inline constexpr double kBelowUnit = 1 - 1e-9;
// Faces of a leaf are scanned one by one up to so many.
inline constexpr std::uint32_t kFacesInBall = 12;
// Hull distances are followed so far beyond the best, that the axis still tells at the next pose.
inline constexpr double kBeyondBest = 1.1;
}  // namespace clod
