// SPDX-License-Identifier: GPL-3.0-or-later
// Sizes of the bodies with a cavity, and of what is put into them (tests/fixtures/Recipes.cpp makes both).
#pragma once

namespace clod::test
{
// A hollow sphere, and two spheres: one fits into the cavity, the other into the wall. Radii.
inline constexpr double kOuter = 0.04, kCavity = 0.024, kBall = 0.009, kGrain = 0.004;
// A hollow box, and a cube. Half their sides.
inline constexpr double kBoxHalf = 0.04, kBoxCavity = 0.02, kSmallCube = 0.004;
// A box with a bubble under each face, so far below it that the wall is as thick as the bubble; a cube. Half their sides.
inline constexpr double kBubble = 0.002, kTinyCube = 0.002;
// Two such cubes in one body, its origin in the middle between them.
inline constexpr double kCubesApart = 0.15;
}  // namespace clod::test
