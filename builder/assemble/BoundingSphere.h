// SPDX-License-Identifier: GPL-3.0-or-later
// The smallest sphere round a set of points: its radius is "the radius" of every percentage.
#pragma once
#include <vector>

#include "clod/collide/Vector.h"

namespace clod::builder
{
struct Sphere
{
	Vec3 center;
	double radius = 0;
};

// Contains every point; at most 1e-9 larger than the smallest such sphere.
Sphere boundingSphere(const std::vector<Vec3>& points);
}  // namespace clod::builder
