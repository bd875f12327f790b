// SPDX-License-Identifier: GPL-3.0-or-later
// A world of pairs of toruses with several levels, with btClodDispatcher or Bullet's own.
#pragma once
#include <algorithm>
#include <memory>

#include "clod/bullet/btClodCollisionAlgorithm.h"
#include "clod/bullet/btClodDispatcher.h"
#include "tests/bullet/NumberHash.h"
#include "tests/query/Bodies.h"

#include <btBulletDynamicsCommon.h>

namespace clod::test
{
// Four toruses, each fallen or falling on a fixed one: four pairs of which some touch more than others.
class Toruses
{
public:
	// inCompounds: of the upper bodies, so many are children of compounds; isNested: and these of others.
	explicit Toruses(bool ours, int pairs = 4, int inCompounds = 0, Context* shared = nullptr, bool isNested = false)
		: context(shared ? *shared : m_context)
	{
		if (ours)
			m_dispatcher = std::make_unique<btClodDispatcher>(&m_configuration, &context);
		else
			m_dispatcher = std::make_unique<btCollisionDispatcher>(&m_configuration);
		m_world =
			std::make_unique<btDiscreteDynamicsWorld>(m_dispatcher.get(), &m_broadphase, &m_solver, &m_configuration);
		if (!btClodCollisionAlgorithm::registerAlgorithm(m_dispatcher.get(), &context)) std::abort();
		context.warn = {};
		context.keepPoints = false;  // every step asks
		context.worldMetric = ContactMetric::deviationShare(0.001);
		m_world->setGravity(btVector3(0, btScalar(-9.81), 0));
		m_world->getDispatchInfo().m_deterministicOverlappingPairs = true;
		const btScalar scale = btScalar(1 / double(m_shape.hierarchy().asset().radius));
		m_shape.setLocalScaling({scale, scale, scale});
		m_child.addChildShape(btTransform::getIdentity(), &m_shape);
		m_compound.addChildShape(btTransform::getIdentity(), isNested ? static_cast<btCollisionShape*>(&m_child) : &m_shape);
		for (int i = 0; i < pairs; ++i)
		{
			addBody(0, btVector3(btScalar(4 * i), 0, 0), 0);
			addBody(1, btVector3(btScalar(4 * i), btScalar(0.75 + 0.05 * i), btScalar(0.3 * i)), btScalar(0.4 * i),
					i < inCompounds);
		}
	}
	~Toruses()
	{
		for (std::size_t i = 0; i < m_bodies.size(); ++i) setPresent(i, false);
	}

	struct Step
	{
		std::uint64_t tests = 0, coarsestTests = 0, contacts = 0;
		std::uint32_t pending = 0, coarsest = 0, cutShort = 0;
		double excess = 0, least = kOff;  // least: of the pairs that were cut short
		int cut = 0;
	};
	// Collision detection at the poses as they are.
	Step detect(double tests)
	{
		context.budget.tests = tests;
		m_world->performDiscreteCollisionDetection();
		return look();
	}
	std::uint64_t run(int steps, double tests, double microseconds = kOff)
	{
		context.budget = {tests, microseconds};
		return hashOfWay(*m_world, m_bodies, btScalar(1.0 / 240), steps);
	}
	Step look() const
	{
		Step step;
		context.forEachPair(
			[&step](const PairReport& pair)
			{
				step.tests += pair.vainTests;
				if (!pair.kept)
				{
					step.tests += std::uint64_t(pair.result->stats.boxTests) + pair.result->stats.hullTests;
					step.coarsestTests += pair.coarsestTests;
				}
				step.cutShort += pair.result->stats.cutShort;
				step.contacts += pair.result->pairs.size();
				step.coarsest = std::max(step.coarsest, pair.coarsestLevel);
				if (pair.result->excess > 0) step.least = std::min(step.least, pair.result->excess), ++step.cut;
			});
		const StepReport sums = context.lastStep();
		step.pending = sums.pending;
		step.excess = sums.excess;
		return step;
	}
	void setThreads(unsigned count) { dynamic_cast<btClodDispatcher&>(*m_dispatcher).setThreads(count); }
	// The bodies above the fixed ones, at this height and a little more from one to the next; upright and turned.
	void place(double height, double turn)
	{
		for (std::size_t i = 0; 2 * i < m_bodies.size(); ++i)
		{
			btTransform& pose = m_bodies[2 * i + 1]->getWorldTransform();
			pose.setOrigin(btVector3(btScalar(4 * double(i)), btScalar(height + 0.03 * double(i)), 0));
			pose.setRotation(btQuaternion(btVector3(1, 0, 0), btScalar(turn + double(i))));
			m_bodies[2 * i + 1]->setLinearVelocity(btVector3(0, 0, 0));
			m_bodies[2 * i + 1]->setAngularVelocity(btVector3(0, 0, 0));
		}
	}
	// Of the body that lies in the middle of another.
	double height() const { return double(m_bodies[1]->getWorldTransform().getOrigin().y()); }

	// A body that comes and goes while its world lives.
	void setPresent(std::size_t body, bool now)
	{
		btRigidBody* which = m_bodies[body].get();
		if (which->isInWorld() == now) return;
		if (now)
			m_world->addRigidBody(which);
		else
			m_world->removeRigidBody(which);
	}
	void setNearCallback(btNearCallback callback) { m_dispatcher->setNearCallback(callback); }
	btClodShape& shape() { return m_shape; }
	btDiscreteDynamicsWorld& world() { return *m_world; }
	const btRigidBody& body(std::size_t which) const { return *m_bodies[which]; }
	btRigidBody& body(std::size_t which) { return *m_bodies[which]; }

private:
	Context m_context;  // unless it is shared

public:
	Context& context;

private:
	void addBody(btScalar mass, const btVector3& at, btScalar turn, bool inCompound = false)
	{
		btCollisionShape& shape = inCompound ? static_cast<btCollisionShape&>(m_compound) : m_shape;
		btVector3 inertia(0, 0, 0);
		if (mass > 0) m_shape.calculateLocalInertia(mass, inertia);
		btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &shape, inertia);
		info.m_startWorldTransform.setOrigin(at);
		info.m_startWorldTransform.setRotation(btQuaternion(btVector3(0, 1, 0), turn));
		m_bodies.push_back(std::make_unique<btRigidBody>(info));
		m_bodies.back()->setActivationState(DISABLE_DEACTIVATION);
		m_world->addRigidBody(m_bodies.back().get());
	}

	btClodShape m_shape{test::body("torus", 900).hierarchy};
	btCompoundShape m_child, m_compound;
	btDefaultCollisionConfiguration m_configuration;
	std::unique_ptr<btCollisionDispatcher> m_dispatcher;
	btDbvtBroadphase m_broadphase;
	btSequentialImpulseConstraintSolver m_solver;
	std::unique_ptr<btDiscreteDynamicsWorld> m_world;
	std::vector<std::unique_ptr<btRigidBody>> m_bodies;
};
}  // namespace clod::test
