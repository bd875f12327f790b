// SPDX-License-Identifier: Zlib
// When is a pair of bodies moving, when at rest? One definition for scenes, replays and figures; and velocities from
// successive poses.
#pragma once
#include "clod/collide/Vector.h"
#include "demos/scenes/Poses.h"

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

// Axis times angle (at most half a turn) of a rotation.
inline Vec3 rotationVector(const Mat3& turn)
{
	// sin(angle) * axis is its antisymmetric part.
	const Vec3 sine =
		0.5 * Vec3{turn.row[2].y - turn.row[1].z, turn.row[0].z - turn.row[2].x, turn.row[1].x - turn.row[0].y};
	const double size = length(sine), cosine = (turn.row[0].x + turn.row[1].y + turn.row[2].z - 1) / 2;
	return size > 0 ? (std::atan2(size, cosine) / size) * sine : Vec3{};
}

// In the world; linear is that of a body's origin.
struct BodyVelocity
{
	Vec3 linear, angular;
};
// What carries a body from one pose of its mesh to another.
inline BodyVelocity velocityBetween(const Pose& from, const Pose& to, const Vec3& meshFromBody, double seconds)
{
	const Transform before = worldFromBody(from, meshFromBody), after = worldFromBody(to, meshFromBody);
	return {(1 / seconds) * (after.translation - before.translation),
			(1 / seconds) * rotationVector(after.rotation * transposed(before.rotation))};
}
}  // namespace clod::demo
