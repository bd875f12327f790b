// SPDX-License-Identifier: Zlib
// How one body moves relative to another in a step.
#pragma once
#include "clod/collide/Vector.h"

namespace clod
{
// Velocity field of A's material relative to B's, in some frame: velocity(p) = linear + angular x p.
struct RelativeMotion
{
	Vec3 linear, angular;
	double timeStep = 0;  // seconds; 0 = no prediction
	Vec3 velocity(const Vec3& point) const { return linear + cross(angular, point); }
	// The most of any point within a sphere.
	double speedWithin(const Vec3& center, double radius) const
	{
		return length(velocity(center)) + length(angular) * radius;
	}
};
// The same field in another frame; hereFromThere maps that frame into the field's.
inline RelativeMotion inFrame(const RelativeMotion& motion, const Transform& hereFromThere)
{
	const Mat3 thereFromHere = transposed(hereFromThere.rotation);
	return {thereFromHere * motion.velocity(hereFromThere.translation), thereFromHere * motion.angular,
			motion.timeStep};
}
}  // namespace clod
