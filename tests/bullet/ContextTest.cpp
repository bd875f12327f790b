// SPDX-License-Identifier: GPL-3.0-or-later
// The context's view of a world: what it tells of pairs and steps, and whom it calls.
#include <gtest/gtest.h>

#include "tests/bullet/CubeOnSlab.h"

namespace clod::test
{
TEST(Context, PairCallbackThenShapesThenWorld)
{
	CubeOnSlab scene;
	Metric used;
	const auto look = [&]
	{
		scene.step();
		scene.context.forEachPair([&](const PairReport& pair) { used = pair.metric; });
		return used;
	};
	const double radius = double(scene.bodyShape.hierarchy().asset().radius);
	EXPECT_NEAR(look().maxError, 0.005 * radius, 1e-12);  // the default, of the smaller radius
	scene.context.worldMetric = ContactMetric::deviationShare(0.035);
	EXPECT_NEAR(look().weightedDeviation, 0.035 * radius, 1e-12);
	scene.groundShape.setMetric(ContactMetric::errorShare(0.02));
	EXPECT_NEAR(look().maxError, 0.02 * radius, 1e-12);
	scene.bodyShape.setMetric(ContactMetric::errorShare(0.01));
	EXPECT_NEAR(look().maxError, 0.01 * radius, 1e-12);  // the stricter of the two
	scene.context.pairMetric = [](const btCollisionObject&, const btCollisionObject&, ContactMetric& metric)
	{
		metric = ContactMetric::exactly();
		return true;
	};
	EXPECT_TRUE(look().exact);
	scene.context.pairMetric = [](const btCollisionObject&, const btCollisionObject&, ContactMetric&) { return false; };
	EXPECT_FALSE(look().exact);
}

TEST(Context, HandlersAndVisitorsMayCallItAgain)
{
	CubeOnSlab scene;
	scene.step(10);
	StepReport seen;
	std::size_t messages = 0;
	scene.context.warn = [&](const std::string&)
	{
		++messages;
		seen = scene.context.lastStep();
		scene.context.forEachPair([&](const PairReport& pair) { EXPECT_FALSE(pair.metricError.empty()); });
		scene.context.warn = {};
	};
	scene.context.worldMetric.maxError = -1;
	scene.step();
	EXPECT_EQ(messages, 1u);
	EXPECT_EQ(seen.pairs, 1u);

	struct Count : btCollisionWorld::ContactResultCallback
	{
		int points = 0;
		btScalar addSingleResult(btManifoldPoint&, const btCollisionObjectWrapper*, int, int,
								 const btCollisionObjectWrapper*, int, int) override
		{
			return btScalar(++points);
		}
	} count;
	int visits = 0;
	scene.context.forEachPair(
		[&](const PairReport& pair)
		{
			++visits;
			EXPECT_EQ(scene.context.lastStep().points, pair.points);
			scene.world.contactPairTest(&scene.ground, &scene.body, count);  // a pair that comes and goes
			EXPECT_EQ(scene.context.lastStep().pairs, 1u);
		});
	EXPECT_EQ(visits, 1);
	EXPECT_GT(count.points, 0);
	// One that goes for good.
	scene.addBody(scene.bodyShape, 1, {2, 0.4995, 0});
	scene.step();
	visits = 0;
	scene.context.forEachPair(
		[&](const PairReport&)
		{
			if (visits++ == 0) scene.world.removeRigidBody(&scene.body);
		});
	EXPECT_EQ(scene.context.lastStep().pairs, 1u);
	EXPECT_LE(visits, 2);
}

TEST(Context, AStepFasterThanTheWallIsSaidOnce)
{
	BulletWorld scene;
	scene.addBody(scene.addShape(patchHierarchy(boxMesh({10, 0.05, 10}, {20, 1, 20}, 2))), 0, {});
	btRigidBody& body = scene.addBody(scene.addShape(cube()), 1, {0, 0.6, 0});
	body.setLinearVelocity(btVector3(0, -20, 0));
	scene.step(1);
	EXPECT_EQ(scene.context.lastStep().fastPairs, 1u);
	EXPECT_EQ(scene.warnings.size(), 1u);
	EXPECT_FALSE(scene.context.lastStep().warnings().empty());
	scene.step(1);
	EXPECT_EQ(scene.warnings.size(), 1u);
}

// As a scanned mesh may have: the report goes by it, messages by what the walls are usually.
TEST(Context, ASlitIsReportedWithoutAWord)
{
	BulletWorld scene;
	PatchedMesh mesh = boxMesh({10, 1, 10}, {20, 1, 20}, 2);
	mesh.thinnest = 1e-4;
	scene.addBody(scene.addShape(patchHierarchy(mesh)), 0, {});
	btRigidBody& body = scene.addBody(scene.addShape(cube()), 1, {0, 1.01, 0});
	body.setLinearVelocity(btVector3(0, -5, 0));
	scene.step(1);
	EXPECT_EQ(scene.context.lastStep().fastPairs, 1u);
	EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
}
}  // namespace clod::test
