// SPDX-License-Identifier: Zlib
// A collision object's pose and velocity as the query takes them: in double.
#pragma once
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>

#include "clod/manifold/ContactPoints.h"

namespace clod
{
Vec3 toVec3(const btVector3& v);
// Bullet's rotation, orthonormal again to double rounding.
Transform toTransform(const btTransform& t);
// All of it: toTransform makes a column of NaN a column of zeros.
bool isFinite(const btTransform& t);
bool isFinite(const Transform& t);
bool isFinite(const RelativeMotion& motion);

// World velocity field of a collision object, v(p) = linear + angular x p, as the solver will start from: forces and
// gravity of the coming step included. With timeStep 0: as it moves now.
RelativeMotion worldMotion(const btCollisionObject& object, double timeStep);
// Mass and motion of an object in a frame of the world whose unit is `scale` world lengths.
PairBody pairBody(const btCollisionObject& object, const Transform& worldFromFrame, double scale, double timeStep);
}  // namespace clod
