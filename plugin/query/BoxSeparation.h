// SPDX-License-Identifier: Zlib
// How far two culling boxes are apart at least: separating axes over the six face normals, and the two spheres.
//
// The nine edge-edge axes are left out. Each of the seven numbers changes by no more than the points of one body move
// relative to the other, so their maximum does too: that is what lets a result be carried over to a later pose
// (MotionBound.h). A cross product of two axes turns with both bodies and has no such bound.
//
// Based on: Gottschalk, Lin & Manocha, "OBBTree", 1996, sec. 5.
#pragma once
#include "clod/query/HullDistance.h"

namespace clod
{
// A culling box in frame A, in double.
struct PlacedBox
{
	Vec3 center, axis[3];
	double half[3];
	double radius;  // of the sphere round center
};

PlacedBox placeInA(const CullBox& boxOfA);
PlacedBox placeInA(const CullBox& boxOfB, const RelativePose& pose);

// Lower bound of the distance of everything the two boxes enclose, rounded down; negative where none of the axes
// separates them.
double boxSeparation(const PlacedBox& a, const PlacedBox& b);

// Lower bound of the distance from a point to everything the box encloses, rounded down; 0 inside.
double boxDistance(const PlacedBox& box, const Vec3& point);
}  // namespace clod
