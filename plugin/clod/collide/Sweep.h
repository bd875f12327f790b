// SPDX-License-Identifier: Zlib
// The coming step's motion of body B as seen from body A: what a query looks ahead along.
#pragma once
#include <algorithm>

#include "clod/collide/Vector.h"

namespace clod
{
// A point p of B (frame A) moves along the segment from p to p + linear + angular x p. Zero: the bodies as they are.
struct Sweep
{
	Vec3 linear;   // a length
	Vec3 angular;  // radians
	Vec3 of(const Vec3& point) const { return linear + cross(angular, point); }
	bool isZero() const { return linear == Vec3{} && angular == Vec3{}; }
};
// Of the origin from the segment between p and p + move.
inline double distanceToSegment(const Vec3& p, const Vec3& move)
{
	const double squared = lengthSquared(move);
	const double share = squared > 0 ? std::max(0.0, std::min(1.0, -dot(p, move) / squared)) : 0;
	return length(p + share * move);
}
inline bool operator==(const Sweep& l, const Sweep& r)
{
	const auto& [linear, angular] = l;  // every field: one more does not compile before it is named here
	return linear == r.linear && angular == r.angular;
}
}  // namespace clod
