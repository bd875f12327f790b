// SPDX-License-Identifier: GPL-3.0-or-later
// A world without friction in which things hit each other, ours or Bullet's own.
#pragma once
#include "clod/bullet/ConfigureWorld.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"

namespace clod::test
{
struct ImpactWorld : BulletWorld
{
	ImpactWorld(bool meetsImpacts, double rate, double gravity) : BulletWorld(meetsImpacts)
	{
		timeStep = 1 / rate;
		configureWorld(world);
		world.setGravity(btVector3(0, btScalar(-gravity), 0));
		context.worldMetric = ContactMetric::exactly();
	}
	btClodDynamicsWorld& ours() { return dynamic_cast<btClodDynamicsWorld&>(world); }
	btRigidBody& put(const std::shared_ptr<const Hierarchy>& hierarchy, double mass, const Vec3& place,
					 const btQuaternion& turn = btQuaternion::getIdentity())
	{
		btRigidBody& body = addBody(addShape(hierarchy), mass, place, turn);
		body.setDamping(0, 0);
		body.setFriction(0);
		return body;
	}
};

inline const std::shared_ptr<const Hierarchy>& unitCube()
{
	static const std::shared_ptr<const Hierarchy> hierarchy = patchHierarchy(boxMesh({1, 1, 1}, {2, 2, 2}, 1));
	return hierarchy;
}

// A ball that rattles between two plates.
inline btRigidBody& rattle(ImpactWorld& world, double x = 0)
{
	for (const double y : {-0.5, 1.53})
		world.put(patchHierarchy(boxMesh({4, 1, 4}, {2, 1, 2}, 1)), 0, {x, y, 0}).setRestitution(1);
	btRigidBody& ball = world.put(patchHierarchy(ballMesh(0.5, 2)), 1, {x, 0.515, 0});
	ball.setRestitution(1);
	ball.setLinearVelocity(btVector3(0, 50, 0));
	return ball;
}
}  // namespace clod::test
