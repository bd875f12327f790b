// SPDX-License-Identifier: GPL-3.0-or-later
// A world of ours in which everything meets everything.
#pragma once
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "clod/bullet/btClodCollisionAlgorithm.h"
#include "clod/bullet/btClodDispatcher.h"
#include "clod/bullet/btClodDynamicsWorld.h"
#include "tests/bullet/NumberHash.h"
#include "tests/bullet/PatchHierarchy.h"

namespace clod::test
{
// Bodies of all kinds of partners: ours, a plane, an engine's mesh, one whose triangles only one thread may read, a
// compound's child, and one of another scale.
class MixedWorld
{
public:
	// passes, parts: of a step at most. Of boxes, or of another body, at a radius of 1 then.
	explicit MixedWorld(unsigned threads, int passes = 1, int parts = 1, const std::shared_ptr<const Hierarchy>& body = nullptr,
				   Context* shared = nullptr)
		: context(shared ? *shared : m_own),
		  m_hierarchy(body ? body : patchHierarchy(boxMesh({1, 0.5, 0.7}, {4, 2, 3}, 2)))
	{
		const btScalar scale = body ? btScalar(1 / double(body->asset().radius)) : 1;
		m_box.setLocalScaling(btVector3(scale, scale, scale));
		m_dispatcher.setThreads(threads);
		m_world.setMostPasses(passes);
		m_world.setMostParts(parts);
		EXPECT_TRUE(btClodCollisionAlgorithm::registerAlgorithm(&m_dispatcher, &context));
		if (!shared) context.warn = [this](const std::string& message) { said.push_back(message); };
		m_world.setGravity(btVector3(0, btScalar(-9.81), 0));
		m_larger.setLocalScaling(btScalar(1.3) * m_box.getLocalScaling());
		m_compound.addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(0.1), 0)), &m_box);
		m_mesh.addTriangle(btVector3(-9, 0, -9), btVector3(9, 0, -9), btVector3(0, 0, 9));
		m_bvh = std::make_unique<btBvhTriangleMeshShape>(&m_mesh, true);
		add(m_plane, 0, btVector3(0, -2, 0));
		add(*m_bvh, 0, btVector3(btScalar(0.5), 0, 0));
		btCollisionShape* const shapes[] = {&m_box, &m_box, &m_larger, &m_compound};
		for (int i = 0; i < 24; ++i)
			add(*shapes[i % 4], 1,
				btScalar(body ? 2.5 : 1) *
					btVector3(btScalar(i % 3) - 1, btScalar(0.8 + 0.7 * (i / 3)), btScalar(0.2 * (i % 5))));
	}
	~MixedWorld()
	{
		for (const auto& body : m_bodies) m_world.removeRigidBody(body.get());
	}
	std::uint64_t run(int steps) { return hashOfWay(m_world, m_bodies, btScalar(1.0 / 120), steps); }
	btClodDynamicsWorld& world() { return m_world; }
	btClodDispatcher& dispatcher() { return m_dispatcher; }
	const btRigidBody& last() const { return *m_bodies.back(); }
	btRigidBody& first() { return *m_bodies[2]; }
	// What a program saves besides contacts.
	struct Place
	{
		btTransform pose, interpolation;
		btVector3 linear, angular;
	};
	std::vector<Place> places() const
	{
		std::vector<Place> all;
		for (const auto& body : m_bodies)
			all.push_back({body->getWorldTransform(), body->getInterpolationWorldTransform(), body->getLinearVelocity(),
						   body->getAngularVelocity()});
		return all;
	}
	void putBack(const std::vector<Place>& places)
	{
		for (std::size_t i = 0; i < places.size(); ++i)
		{
			btRigidBody& body = *m_bodies[i];
			body.setWorldTransform(places[i].pose);
			body.setInterpolationWorldTransform(places[i].interpolation);
			body.setLinearVelocity(places[i].linear);
			body.setAngularVelocity(places[i].angular);
			body.updateInertiaTensor();
		}
	}

	Context& context;
	std::vector<std::string> said;

private:
	void add(btCollisionShape& shape, btScalar mass, const btVector3& at)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) m_box.calculateLocalInertia(mass, inertia);
		btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &shape, inertia);
		info.m_startWorldTransform.setOrigin(at);
		m_bodies.push_back(std::make_unique<btRigidBody>(info));
		m_bodies.back()->setActivationState(DISABLE_DEACTIVATION);
		m_world.addRigidBody(m_bodies.back().get());
	}

	Context m_own;
	std::shared_ptr<const Hierarchy> m_hierarchy;
	btClodShape m_box{m_hierarchy}, m_larger{m_hierarchy};
	btCompoundShape m_compound;
	btTriangleMesh m_mesh;
	std::unique_ptr<btBvhTriangleMeshShape> m_bvh;
	btStaticPlaneShape m_plane{btVector3(0, 1, 0), 0};
	btDefaultCollisionConfiguration m_configuration;
	btClodDispatcher m_dispatcher{&m_configuration, &context};
	btDbvtBroadphase m_broadphase;
	btSequentialImpulseConstraintSolver m_solver;
	btClodDynamicsWorld m_world{&m_dispatcher, &m_broadphase, &m_solver, &m_configuration, &context};
	std::vector<std::unique_ptr<btRigidBody>> m_bodies;
};
}  // namespace clod::test
