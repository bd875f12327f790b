// SPDX-License-Identifier: Zlib
// How far culling boxes are apart at least, now and while one body moves through the coming step: separating axes over
// the six face normals, and the two spheres. One box against up to eight of the other body at once, a box a lane, in
// float, rounded down.
//
// The nine edge-edge axes are left out. Each of the seven numbers changes by no more than the points of one body move
// relative to the other, so their maximum does too: that is what lets a result be carried over to a later pose
// (MotionBound.h). A cross product of two axes turns with both bodies and has no such bound.
//
// Based on: Gottschalk, Lin & Manocha, "OBBTree", 1996, sec. 5.
#pragma once
#include <cstdint>
#include <limits>

#include "clod/collide/HullDistance.h"
#include "clod/collide/OrientedBox.h"
#include "clod/collide/Sweep.h"

namespace clod
{
inline constexpr std::uint32_t kBoxLanes = 8;

// Where B's boxes are in frame A, and how they move; prepared once a query.
struct BoxFrame
{
	BoxFrame() = default;
	// size: radii of both bodies about their origins, their distance and the longest way in the step.
	BoxFrame(const RelativePose& pose, const Sweep& sweep, double size);
	// A bound of what rounding takes off two separations.
	double roundingOfTwo() const;

	float rotation[3][3], translation[3];
	float linear[3], angular[3], turn = 0;  // of the sweep; turn: length of angular
	float rounding = 0;  // of places and ways: what float takes off a separation, apart from its sums
	double size = 0;
	bool moves = false;
	bool isHuge = false;  // floats could not be squared: the spheres decide
};

// separations[i]: lower bound of the distance of everything in `one` from everything in others[i], at any time of the
// step, rounded down; negative where none of the axes separates them. 1 <= count <= kBoxLanes; room for kBoxLanes. What
// a pair of boxes gets depends on the two and the frame only. Returns the set of i, as bits, whose separation is at
// most `limit`.
std::uint32_t boxSeparations(const BoxFrame& frame, const OrientedBox& one, bool oneIsOfA,
							 const OrientedBox* const* others, std::uint32_t count, float* separations,
							 float limit = std::numeric_limits<float>::infinity());
// The same from the code for any machine.
std::uint32_t boxSeparationsPlain(const BoxFrame& frame, const OrientedBox& one, bool oneIsOfA,
								  const OrientedBox* const* others, std::uint32_t count, float* separations,
								  float limit = std::numeric_limits<float>::infinity());
inline double boxSeparation(const BoxFrame& frame, const OrientedBox& ofA, const OrientedBox& ofB)
{
	const OrientedBox* const others[] = {&ofB};
	float separations[kBoxLanes];
	boxSeparations(frame, ofA, true, others, 1, separations);
	return double(separations[0]);
}

// Lower bound of the distance from a point to everything the box encloses, rounded down; 0 inside. Of the box at rest.
double boxDistance(const OrientedBox& box, const Vec3& point);
}  // namespace clod
