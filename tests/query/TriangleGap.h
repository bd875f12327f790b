// SPDX-License-Identifier: GPL-3.0-or-later
// The signed gap of two triangle meshes by slow, independent means: every triangle against every other, winding
// numbers, and branch and bound with nothing but the Lipschitz property. Shares no code with the query.
#pragma once
#include <array>
#include <vector>

#include "clod/collide/Vector.h"

namespace clod::test
{
using TriangleSoup = std::vector<std::array<Vec3, 3>>;

struct GapInterval
{
	double low, high;
};

double triangleDistance(const std::array<Vec3, 3>& s, const std::array<Vec3, 3>& t);  // 0 when they cross
double pointTriangleDistance(const Vec3& p, const std::array<Vec3, 3>& t);
double windingNumber(const TriangleSoup& mesh, const Vec3& p);

// accuracy: largest width of the interval of an overlap.
GapInterval triangleGap(const TriangleSoup& a, const TriangleSoup& b, const Transform& aFromB, double accuracy);
}  // namespace clod::test
