// SPDX-License-Identifier: Zlib
// Certified distance of two convex hulls, each a set of float vertices swept along a segment (its thickness).
//
// GJK in double. The answer depends on the two hulls, the pose and the start direction only, and carries its proof:
// upper is the distance of two points inside the hulls, lower that of two parallel support planes less their rounding.
// No constant has a unit: scaling both hulls and the translation by a power of two scales every result exactly.
//
// Frames: hull a and every result in frame A, hull b in frame B; normals point from B to A.
// Guarantee: lower <= distance <= upper (to `rounding` of RelativePose). upper - lower <= kHullDistanceAccuracy times
// the size of the pair (extents and distance), unless stopped early. Measured by tests/collide/HullDistanceTest.cpp.
//
// Based on: Gilbert, Johnson & Keerthi 1988; van den Bergen 2003 sec. 4.3 (lower bound, termination).
#pragma once
#include <cstdint>
#include <limits>

#include "clod/collide/Constants.h"
#include "clod/collide/ConvexHull.h"

namespace clod
{
// Maps frame B into frame A, prepared once a query.
struct RelativePose
{
	RelativePose() = default;
	// radius: bound of |vertex| in both frames.
	RelativePose(const Transform& aFromB, double radius);
	Vec3 apply(const Vec3& inB) const { return rotation * inB + translation; }
	Vec3 directionToB(const Vec3& inA) const { return inverseRotation * inA; }

	Mat3 rotation, inverseRotation;
	Vec3 translation;
	double rounding = 0;  // bound of the rounding of one support value, a length
};

struct HullDistance
{
	double lower = 0, upper = 0;  // both 0 when the hulls overlap
	Vec3 pointOnA, pointOnB;      // witness points, unless stopped above
	Vec3 normal;                  // unit, from B to A: the direction that lower was measured along; zero on overlap
	double moved = 0;             // pointOnB is a point of b at rest moved by this share of moveB
	bool overlap = false;
	bool stoppedAbove = false;  // lower > stopAbove: the witness points are meaningless
	int iterations = 0;
};

// start: any vector from B towards A (frame A), e.g. the difference of two centres. Stops as soon as lower > stopAbove.
// moveB: hull b is swept along the segment [0, moveB] as well (frame A); pointOnB is then a point of the swept hull.
// Stops as well as soon as upper <= stopBelow: lower and normal are then those reached.
// Whether lower > 0 does not depend on stopAbove >= 0, only how far above: bounds once found are never given up.
HullDistance hullDistance(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& start,
						  double stopAbove, const Vec3& moveB = {},
						  double stopBelow = -std::numeric_limits<double>::infinity());
// The same bits from the code for any machine.
HullDistance hullDistancePlain(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& start,
							   double stopAbove, const Vec3& moveB = {},
							   double stopBelow = -std::numeric_limits<double>::infinity());

// Certified lower bound of the distance from the support planes across one direction (frame A, from B to A); may be
// negative. O(vertices).
double separationAlong(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& direction,
					   const Vec3& moveB = {});
}  // namespace clod
