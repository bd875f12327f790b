// SPDX-License-Identifier: GPL-3.0-or-later
// The point nearest to a given one inside an intersection of half-spaces: the small quadratic programme that keeps the
// edges round a moved vertex convex.
// Source: Seidel's recursion for problems of combinatorial dimension 3, on the squared distance instead of a linear
// goal.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "builder/patches/Orientation.h"

namespace clod::builder
{
// Empty where no point lies at height >= 0 of every plane within tolerance. The rows are visited in an order drawn from
// seed only.
std::optional<Vec3> nearestInside(const Vec3& target, std::vector<Plane> rows, double tolerance, std::uint64_t seed);
}  // namespace clod::builder
