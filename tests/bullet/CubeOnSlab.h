// SPDX-License-Identifier: GPL-3.0-or-later
// A world in which a cube of side 1 lies on a slab whose top is at height 0, and what holds it there.
#pragma once
#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"

namespace clod::test
{
struct CubeOnSlab : BulletWorld
{
	btClodShape& groundShape = addShape(slab());
	btClodShape& bodyShape = addShape(cube());
	btRigidBody& ground = addBody(groundShape, 0, {0, -0.5, 0});
	btRigidBody& body = addBody(bodyShape, 1, {0.013, 0.501, 0.027});
};

// Held but along x, where nothing pushes: Bullet skips contacts of bodies that cannot move at all.
inline void hold(btRigidBody& body, bool now)
{
	body.setLinearFactor(now ? btVector3(1, 0, 0) : btVector3(1, 1, 1));
	body.setAngularFactor(now ? btVector3(0, 0, 0) : btVector3(1, 1, 1));
}
}  // namespace clod::test
