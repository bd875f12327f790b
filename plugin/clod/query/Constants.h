// SPDX-License-Identifier: Zlib
// The numbers that a query is tuned and rounded with. But for the choice of base levels none changes an
// answer: they decide what is kept, tried or left out. What the tuned ones buy is measured in docs/tried.md,
// "Constants".
#pragma once
#include <cstdint>

#include "clod/collide/Constants.h"

namespace clod
{
// Rounding. Each is at least twice what it stands for.
inline constexpr double kSumRounding = 1e-9;    // of the size: motions added up a million times
inline constexpr double kBoundRounding = 3e-7;  // of a bound: three operations in float, and its own conversion
inline constexpr double kKeptOfSign = 0.999;    // of a distance: so much motion leaves its sign
// Motions of so many sizes are not added up: what comes then would be lost below kSumRounding.
inline constexpr double kFarthestMotion = 1e5;
// Evaluations of one hull distance near a limit differ by up to twice the accuracy each way.
inline constexpr double kEvaluationRoom = 10 * kHullDistanceAccuracy;

// Choice of base levels (TraversalTables.cpp).
inline constexpr double kFewer = 0.75;  // of the boxes that meet, for more pairs of nodes

// Pieces of the body that is asked as A (Query.cpp): a box or a floor against a detailed body, not two detailed ones.
inline constexpr double kMuchLarger = 4;

// Fronts of a single piece and input surfaces are made for moves to come (ContactSearch.cpp).
inline constexpr double kMovesAhead = 4;   // so many as the last one,
inline constexpr double kMostAhead = 0.25;  // and at most so much of the smaller body and of the other's pieces;
inline constexpr double kFartherOfCore = 2;  // of points and segments, which have few pairs
// No front of base levels is kept after a query that moved by more than such a share of the tolerance, and so many
// more, unless it takes, unpacked, no more than such a share of the bytes of the two bodies.
inline constexpr double kMovingShare = 0.25;
inline constexpr std::uint32_t kCalm = 64;
inline constexpr double kFrontShare = 1.0 / 64;

// Searches for the motion that bodies apart can take (SeparationCache.cpp).
inline constexpr std::uint32_t kSearchBackOff = 63;  // queries without a search, at most
inline constexpr std::uint32_t kParted = 64;         // queries that find nothing, until no front is kept any longer
inline constexpr std::uint32_t kWorthwhile = 4;      // queries that a search should save
inline constexpr double kFarthestSearch = 64;        // moves of a query: what is farther is not looked for
inline constexpr double kThresholdSpan = 2;          // thresholds of later queries: so many times these
inline constexpr double kShareOfNearest = 0.5;       // of the motion to the nearest pair is the answer
inline constexpr std::uint32_t kTestsOfCandidate = 3;  // its box, whether its hulls are apart, how far it may move

// Metric::coarsening. Below what simplification leaves in any model: the coarsest level that keeps it is the surface
// itself.
inline constexpr double kFinestShare = 1e-4;
// No answer is coarsened beyond so much of the smaller radius: what errs by more meets far more than the surfaces do,
// and its contacts cost more than those of finer levels.
inline constexpr double kCoarsestShare = 0.5;
}  // namespace clod
