// SPDX-License-Identifier: Zlib
// A collision object's pose and velocity as the query takes them: in double.
#pragma once
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>

#include "clod/manifold/ContactPoints.h"

class btRigidBody;

namespace clod
{
Vec3 toVec3(const btVector3& v);
btVector3 toBullet(const Vec3& v);
// Bullet's rotation, orthonormal again to double rounding.
Transform toTransform(const btTransform& t);
// All of it: toTransform makes a column of NaN a column of zeros.
bool isFinite(const btTransform& t);
bool isFinite(const Transform& t);
bool isFinite(const RelativeMotion& motion);

// Never moves. Kinematic bodies made as Bullet's manual has it, of mass 0, have the flag of static ones, too.
bool isFixed(const btCollisionObject& object);
// Is it awake, and do impulses move it?
bool isMoving(const btCollisionObject& object);

// Are they one object, or two that nothing moves but the program, and that moves both alike?
bool moveAsOne(const btCollisionObject& a, const btCollisionObject& b);

// World velocity field of a collision object, v(p) = linear + angular x p, as the solver will start from: forces and
// gravity of the coming step included. With timeStep 0: as it moves now.
RelativeMotion worldMotion(const btCollisionObject& object, double timeStep);
// As the step's solver left it, which btClodDynamicsWorld keeps in the interpolation velocities.
RelativeMotion solvedMotion(const btCollisionObject& object);
// Of A's material relative to B's, both moving in the world as given; in frame A, whose unit is `scale` world lengths.
RelativeMotion relativeMotion(const RelativeMotion& a, const RelativeMotion& b, const Transform& worldFromA, double scale,
							  double timeStep);
// Of a body that moves freely, as worldMotion has it.
double kineticEnergy(const btRigidBody& body, double timeStep);
// Mass of an object, and its motion as given, with and without forces, in a frame of the world whose unit is `scale`
// world lengths.
PairBody pairBody(const btCollisionObject& object, const Transform& worldFromFrame, double scale,
				  const RelativeMotion& motion, const RelativeMotion& withoutForces);
}  // namespace clod
