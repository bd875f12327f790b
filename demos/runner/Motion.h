// SPDX-License-Identifier: Zlib
// When is a pair of bodies moving, when at rest? One definition for scenes, replays and figures.
#pragma once
#include "clod/collide/Vector.h"

namespace clod::demo
{
// Speeds are of the fastest point of one body seen from the other, in bounding radii (the smaller) per second.
inline constexpr double kMovingSpeed = 0.10;  // at least: moving
inline constexpr double kRestSpeed = 0.02;    // at most: at rest; between the two: neither

enum class Motion
{
	moving,
	between,
	rest
};
inline Motion classify(double speedInRadii)
{
	return speedInRadii >= kMovingSpeed ? Motion::moving : speedInRadii <= kRestSpeed ? Motion::rest : Motion::between;
}
inline const char* name(Motion motion)
{
	return motion == Motion::moving ? "moving" : motion == Motion::rest ? "rest" : "between";
}

// Upper bound of the displacement of body B's points, which lie within `radius` of `center` (frame B), between two
// poses.
inline double displacement(const Transform& from, const Transform& to, const Vec3& center, double radius)
{
	double turned = 0;
	for (int i = 0; i < 3; ++i) turned += lengthSquared(to.rotation.row[i] - from.rotation.row[i]);
	// |R - S|_F = 2 sqrt(2) sin(angle / 2); the farthest arm moves by 2 sin(angle / 2).
	return length(to * center - from * center) + std::sqrt(turned / 2) * radius;
}
}  // namespace clod::demo
