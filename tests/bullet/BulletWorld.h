// SPDX-License-Identifier: GPL-3.0-or-later
// A Bullet world with the plugin registered, and what tests look at. Units: the bodies' (about one).
#pragma once
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "clod/bullet/BodyState.h"
#include "clod/bullet/btClodCollisionAlgorithm.h"
#include "clod/bullet/btClodDynamicsWorld.h"
#include "clod/distance/SignedGap.h"
#include "clod/manifold/ContactPoints.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
struct BulletWorld
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	Context context;
	std::vector<std::string> warnings;
	const std::unique_ptr<btDiscreteDynamicsWorld> ownWorld;
	btDiscreteDynamicsWorld& world;
	std::vector<std::unique_ptr<btCollisionShape>> shapes;
	std::vector<std::unique_ptr<btRigidBody>> bodies;
	double timeStep = 1.0 / 240;

	// Bullet's own world, or the one that meets impacts within a step.
	explicit BulletWorld(bool meetsImpacts = false)
		: ownWorld(meetsImpacts ? std::make_unique<btClodDynamicsWorld>(&dispatcher, &broadphase, &solver, &configuration,
																		&context)
								: std::make_unique<btDiscreteDynamicsWorld>(&dispatcher, &broadphase, &solver, &configuration)),
		  world(*ownWorld)
	{
		context.warn = [this](const std::string& message) { warnings.push_back(message); };
		if (!btClodCollisionAlgorithm::registerAlgorithm(&dispatcher, &context)) std::abort();
		world.setGravity(btVector3(0, btScalar(-9.81), 0));
		world.getSolverInfo().m_numIterations = 30;
		world.getDispatchInfo().m_deterministicOverlappingPairs = true;
	}
	~BulletWorld()
	{
		for (const auto& body : bodies)
			if (body->isInWorld()) world.removeRigidBody(body.get());
	}

	template <class Shape>
	Shape& add(std::unique_ptr<Shape> shape)
	{
		Shape& added = *shape;
		shapes.push_back(std::move(shape));
		return added;
	}
	btClodShape& addShape(const std::shared_ptr<const Hierarchy>& hierarchy)
	{
		return add(std::make_unique<btClodShape>(hierarchy));
	}
	btClodShape& addShape(const std::shared_ptr<const Hierarchy>& hierarchy, double radius)
	{
		btClodShape& shape = addShape(hierarchy);
		const btScalar scale = btScalar(radius / double(shape.hierarchy().asset().radius));
		shape.setLocalScaling({scale, scale, scale});
		return shape;
	}
	// Mass 0 is static. Friction 0.6, no restitution, never sleeps.
	btRigidBody& addBody(btCollisionShape& shape, double mass, const Vec3& position,
						 const btQuaternion& rotation = btQuaternion::getIdentity())
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape.calculateLocalInertia(btScalar(mass), inertia);
		btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, &shape, inertia);
		info.m_startWorldTransform.setOrigin(
			btVector3(btScalar(position.x), btScalar(position.y), btScalar(position.z)));
		info.m_startWorldTransform.setRotation(rotation);
		info.m_friction = btScalar(0.6);
		bodies.push_back(std::make_unique<btRigidBody>(info));
		bodies.back()->setActivationState(DISABLE_DEACTIVATION);
		world.addRigidBody(bodies.back().get());
		return *bodies.back();
	}
	// Of the deepest contact of a body.
	double depthAt(const btRigidBody& body)
	{
		double deepest = 0;
		for (int k = 0; k < dispatcher.getNumManifolds(); ++k)
		{
			const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(k);
			const bool isOfBody = manifold.getBody0() == &body || manifold.getBody1() == &body;
			for (int p = 0; isOfBody && p < manifold.getNumContacts(); ++p)
				deepest = std::max(deepest, -double(manifold.getContactPoint(p).getDistance()));
		}
		return deepest;
	}
	void step(int count = 1)
	{
		for (int i = 0; i < count; ++i) world.stepSimulation(btScalar(timeStep), 0);
	}
	int contacts() const
	{
		int count = 0;
		for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
			count += const_cast<btCollisionDispatcher&>(dispatcher).getManifoldByIndexInternal(i)->getNumContacts();
		return count;
	}
};
// The least distance of what contactPairTest says, by points no farther apart than the threshold.
struct Closest : btCollisionWorld::ContactResultCallback
{
	double least = std::numeric_limits<double>::infinity();
	explicit Closest(double threshold) { m_closestDistanceThreshold = btScalar(threshold); }
	btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
							 const btCollisionObjectWrapper*, int, int) override
	{
		least = std::min(least, double(point.getDistance()));
		return 0;
	}
};
// A hierarchy's surface as Bullet's own mesh.
struct Bvh
{
	btTriangleMesh mesh;
	std::unique_ptr<btBvhTriangleMeshShape> shape;
	explicit Bvh(const Hierarchy& hierarchy)
	{
		for (const std::array<Vec3, 3>& t : inputTriangles(hierarchy))
			mesh.addTriangle(toBullet(t[0]), toBullet(t[1]), toBullet(t[2]));
		shape = std::make_unique<btBvhTriangleMeshShape>(&mesh, true);
	}
};
// Level ground of squares of 1, two triangles each, for so far each way.
inline void addGround(btTriangleMesh& mesh, int reach)
{
	for (int i = -reach; i < reach; ++i)
		for (int j = -reach; j < reach; ++j)
		{
			const auto corner = [&](int x, int z) { return btVector3(btScalar(i + x), 0, btScalar(j + z)); };
			mesh.addTriangle(corner(0, 0), corner(0, 1), corner(1, 0));
			mesh.addTriangle(corner(1, 1), corner(1, 0), corner(0, 1));
		}
}
inline double heightOf(const btRigidBody& body)
{
	return double(body.getWorldTransform().getOrigin().y());
}
}  // namespace clod::test
