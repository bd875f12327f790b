// SPDX-License-Identifier: Zlib
// How far two culling boxes are apart at least, now and while one moves through the coming step: separating axes over
// the six face normals, and the two spheres. In float, four lanes wide, rounded down.
//
// The nine edge-edge axes are left out. Each of the seven numbers changes by no more than the points of one body move
// relative to the other, so their maximum does too: that is what lets a result be carried over to a later pose
// (MotionBound.h). A cross product of two axes turns with both bodies and has no such bound.
//
// Based on: Gottschalk, Lin & Manocha, "OBBTree", 1996, sec. 5.
#pragma once
#include "clod/query/HullDistance.h"
#include "clod/query/Sweep.h"

namespace clod
{
// Four floats; + - * and comparisons go lane by lane.
using Lanes = float __attribute__((vector_size(16)));

// A culling box in frame A.
struct PlacedBox
{
	// Lane 3 means nothing.
	Lanes axis[3];  // [c][i]: component c of axis i
	Lanes half;
	Vec3 center;
	double radius;  // of the sphere round center
	Vec3 move;      // displacement of the centre in the step
	double spread;  // no point's displacement differs from it by more
};

PlacedBox placeInA(const CullBox& boxOfA);
PlacedBox placeInA(const CullBox& boxOfB, const RelativePose& pose, const Sweep& sweep = {});

// Lower bound of the distance of everything the two boxes enclose, at any time of the step, rounded down; negative
// where none of the axes separates them.
double boxSeparation(const PlacedBox& a, const PlacedBox& b);
// A bound of what rounding takes off a separation, for pairs of boxes no larger and no farther apart than `size`.
double boxRounding(double size);

// Lower bound of the distance from a point to everything the box encloses, rounded down; 0 inside. Of the box at rest.
double boxDistance(const CullBox& box, const Vec3& point);
}  // namespace clod
