// SPDX-License-Identifier: Zlib
// The shortest translation that takes a body out of several planes at once.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "clod/collide/Vector.h"

namespace clod
{
// What lies at `distance` above it is on the allowed side.
struct ShiftPlane
{
	Vec3 normal;
	double distance;
	double multiplier = 0;
};

// The shortest x with normal . x + distance >= 0 for all planes (Hildreth's row action), up to `settled`. Where there is
// none, some x.
inline Vec3 leastShift(std::vector<ShiftPlane>& planes, double settled)
{
	Vec3 shift;
	for (ShiftPlane& plane : planes) plane.multiplier = 0;
	for (int round = 0; round < 50; ++round)
	{
		double change = 0;
		for (ShiftPlane& plane : planes)
		{
			const double lacking = -(dot(plane.normal, shift) + plane.distance);
			const double old = plane.multiplier;
			plane.multiplier = std::max(0.0, old + lacking);
			shift += (plane.multiplier - old) * plane.normal;
			change = std::max(change, std::abs(plane.multiplier - old));
		}
		if (change < settled) break;
	}
	return shift;
}
}  // namespace clod
