// SPDX-License-Identifier: Zlib
// The numbers that geometry is computed to. None has a unit: each is a share of a length, an area or a volume at hand.
#pragma once
#include <limits>

namespace clod
{
// Half a unit in the last place of a float; a whole one of a double.
inline constexpr double kFloatUnit = 0x1p-24;
inline constexpr double kDoubleUnit = std::numeric_limits<double>::epsilon();
inline constexpr float kFloatStep = 1.2e-7F;  // two of the former, rounded up: from a float to beyond the next
inline constexpr double kRootOf3 = 1.7321;  // rounded up: a vector's length by its largest component

// A bracket of a hull distance is no wider, of the size of the pair. Ten thousand times what GJK converges to (below);
// 60 times the widest of 150,000 pairs (README.md).
inline constexpr double kHullDistanceAccuracy = 1e-7;
// GJK stops at a bracket this narrow, of the length of the support points: 10^5 roundings. 1e-6 takes 0.2 of 8
// iterations fewer (docs/tried.md).
inline constexpr double kConverged = 1e-11;
// 150,000 pairs take 16 at most. Whatever is reached is a true bracket.
inline constexpr int kMaxIterations = 128;
// Below this share of the product of its sides an area or volume is the rounding of the corners: some 500 units.
inline constexpr double kDegenerate = 1e-13;
// A tetrahedron encloses the origin where what is left is some 50 units of its farthest corner.
inline constexpr double kResidual = 1e-14;
// The square of twice a triangle's area, against those of two edges: of a sliver of an angle below 1e-6 it is mere
// rounding of its corners, which are floats.
inline constexpr double kNoArea = 1e-12;

// Of the motion between two poses: three times what the axes of two boxes can be off, four times kAxisTolerance
// each (BoxSeparation.cpp). Of a millimetre 4 nanometres.
inline constexpr double kMotionRounding = 4e-6;
// Of a motion along an axis that is kept in steps of 2.44e-4 (SeparatingAxis.h).
inline constexpr double kKeptAxisRounding = 2.5e-4;
// Lengths whose squares, and products of which, a float can hold: its largest number has 3.4e38.
inline constexpr double kLargestInFloat = 1e15;
// What spheres' distances lose where floats cannot hold squares: positions and radii rounded to float, some 16 times.
inline constexpr double kSphereRounding = 1e-6;
}  // namespace clod
