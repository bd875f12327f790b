// SPDX-License-Identifier: GPL-3.0-or-later
// A world to abuse, what a program puts at its points, and what it asks them.
#pragma once
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <set>

#include "clod/bullet/ConfigureWorld.h"
#include "clod/bullet/btClodDispatcher.h"
#include "clod/bullet/btClodDynamicsWorld.h"
#include "tests/random/RandomShapes.h"

namespace clod::test
{
// Of points, by a program's callbacks.
struct PointData
{
	std::set<void*> live;
	long made = 0, unknown = 0;
};
inline PointData g_points;
inline bool pointAdded(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int, const btCollisionObjectWrapper*,
					   int, int)
{
	if (point.m_userPersistentData) return true;
	point.m_userPersistentData = new char;
	g_points.live.insert(point.m_userPersistentData);
	++g_points.made;
	return true;
}
inline bool pointDestroyed(void* data)
{
	if (g_points.live.erase(data) == 0)
		++g_points.unknown;
	else
		delete static_cast<char*>(data);
	return true;
}

struct NoDrawing : btIDebugDraw
{
	void drawLine(const btVector3&, const btVector3&, const btVector3&) override {}
	void drawContactPoint(const btVector3&, const btVector3&, btScalar, int, const btVector3&) override {}
	void reportErrorWarning(const char*) override {}
	void draw3dText(const btVector3&, const char*) override {}
	void setDebugMode(int) override {}
	int getDebugMode() const override { return DBG_DrawWireframe | DBG_DrawContactPoints; }
};

struct Distances : btCollisionWorld::ContactResultCallback
{
	bool finite = true;
	btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
							 const btCollisionObjectWrapper*, int, int) override
	{
		finite = finite && std::isfinite(double(point.getDistance()));
		return 0;
	}
};

// Of any of our kinds, drawn.
struct AbusedWorld
{
	Context own;
	Context& context;
	btDefaultCollisionConfiguration configuration;
	std::unique_ptr<btCollisionDispatcher> dispatcher;
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	std::unique_ptr<btDiscreteDynamicsWorld> world;

	AbusedWorld(RandomShapes& draw, Context* shared) : context(shared ? *shared : own)
	{
		context.warn = {};
		if (draw.pick(2))
			dispatcher = std::make_unique<btClodDispatcher>(&configuration, &context);
		else
			dispatcher = std::make_unique<btCollisionDispatcher>(&configuration);
		const std::size_t kind = draw.pick(3);
		if (kind == 0)
			world = std::make_unique<btDiscreteDynamicsWorld>(dispatcher.get(), &broadphase, &solver, &configuration);
		else
		{
			auto ours = std::make_unique<btClodDynamicsWorld>(dispatcher.get(), &broadphase, &solver, &configuration, &context);
			if (kind == 1) ours->setStepping(btClodDynamicsWorld::Stepping::kImpacts);
			world = std::move(ours);
		}
		EXPECT_TRUE(setUpWorld(*world, context));
		world->setGravity(btVector3(0, btScalar(-9.81), 0));
		world->getDispatchInfo().m_deterministicOverlappingPairs = true;
	}
};
}  // namespace clod::test
