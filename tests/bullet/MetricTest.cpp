// SPDX-License-Identifier: GPL-3.0-or-later
// Error metrics set per world, shape and pair, changed between steps, as the pairs of a Bullet world use them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "clod/query/StopRule.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/query/Bodies.h"
#include "tests/support/Files.h"

namespace clod::test
{
namespace
{
// A torus (radius 1) lies on another, or on a plane. Nothing moves unless told: collision detection only.
struct Touching : BulletWorld
{
	std::shared_ptr<const Hierarchy> torus;
	btClodShape& lowerShape = addUnit();
	btClodShape& upperShape = addUnit();
	btRigidBody& lower;
	btRigidBody& upper;

	explicit Touching(btCollisionShape* ground = nullptr, std::shared_ptr<const Hierarchy> of = test::body("torus", 900).hierarchy)
		: torus(std::move(of)), lower(addBody(ground ? *ground : lowerShape, 0, {})), upper(addBody(upperShape, 1, {}))
	{
		world.getDispatchInfo().m_timeStep = btScalar(timeStep);
		world.getDispatchInfo().m_stepCount = 0;
		context.worldMetric = ContactMetric::exactly();
		for (double height = 2; height > 0; height -= 0.002)
		{
			raise(height);
			if (dispatch().contacts > 0) return;
		}
	}
	btClodShape& addUnit()
	{
		btClodShape& shape = addShape(torus, 1);
		return shape;
	}
	void raise(double height)
	{
		btTransform pose = btTransform::getIdentity();
		pose.setOrigin(btVector3(0, btScalar(height), 0));
		upper.setWorldTransform(pose);
		upper.setInterpolationWorldTransform(pose);
	}

	struct Answer
	{
		Metric metric;
		std::size_t contacts = 0;
		std::uint32_t finest = 0, coarsest = 0, points = 0;
		std::string error;
		double bound = 0;
	};
	Answer dispatch()
	{
		world.performDiscreteCollisionDetection();
		Answer answer;
		context.forEachPair(
			[&](const PairReport& pair)
			{
				answer = {pair.metric,      pair.result->pairs.size(),
						  pair.finestLevel, pair.coarsestLevel,
						  pair.points,      pair.metricError,
						  pair.contactError};
				if (!pair.hierarchyB) answer.contacts = pair.points;
			});
		return answer;
	}
	Answer with(const ContactMetric& metric)
	{
		context.worldMetric = metric;
		return dispatch();
	}
	ViewCamera cameraAt(double distance) const
	{
		ViewCamera camera;
		camera.eye = {0, distance, 0};
		camera.fieldOfView = 0.8;
		camera.imageHeight = 720;
		camera.nearDistance = 0.01;
		return camera;
	}
};
}  // namespace

// Of levels that were not loaded: contacts are of what there is, and the pair says so.
TEST(BulletMetric, CoarseLevelsAloneAreTold)
{
	const TemporaryFolder folder;
	const std::string file = folder.fileOf("torus.clod", test::body("torus", 900).hierarchy->bytes());
	Touching coarse(nullptr, Hierarchy::load(file, 1).value()), whole;
	const double radius = double(coarse.torus->asset().radius);
	for (const ContactMetric& metric : {ContactMetric::exactly(), ContactMetric::errorShare(1e-4)})
	{
		EXPECT_NE(coarse.with(metric).error.find("levels from 1 on were loaded"), std::string::npos);
		EXPECT_GT(coarse.with(metric).contacts, 0u);
		EXPECT_EQ(whole.with(metric).error, "");
	}
	EXPECT_NE(coarse.with(ContactMetric::deviationShare(1e-6)).error.find("finer levels were not loaded"), std::string::npos);
	const std::size_t said = coarse.warnings.size();
	EXPECT_EQ(said, 1u);
	EXPECT_EQ(coarse.with(ContactMetric::deviationShare(10)).error, "");
	EXPECT_EQ(coarse.with(ContactMetric::errorShare(1)).error, "");
	EXPECT_GT(coarse.with(ContactMetric::deviationShare(10)).contacts, 0u);
	EXPECT_LT(coarse.with(ContactMetric::deviationShare(10)).bound, radius);
}

TEST(BulletMetric, SizeVelocityViewAndOwnReachThePair)
{
	Touching scene;
	const double radius = double(scene.torus->asset().radius);
	EXPECT_DOUBLE_EQ(scene.with(ContactMetric::deviationShare(0.035)).metric.weightedDeviation, 0.035 * radius);
	const Touching::Answer moving = scene.with(ContactMetric::velocityFactor(0.3));
	EXPECT_DOUBLE_EQ(moving.metric.velocity.time, 0.3 * double(btScalar(1.0 / 240)));
	EXPECT_EQ(moving.metric.velocity.linear, Vec3{});  // at rest: what gravity adds in a step does not count
	scene.context.camera = scene.cameraAt(5);
	const Touching::Answer seen = scene.with(ContactMetric::viewError(2));
	EXPECT_EQ(seen.metric.view.pixels, 2);
	EXPECT_NEAR(seen.metric.view.eye.y * scene.upperShape.scale(), 5, 1e-3);
	int calls = 0;
	const Touching::Answer own = scene.with(ContactMetric::ownThreshold(
		[&calls](const ContactPlace& place)
		{
			++calls;
			EXPECT_LT(length(place.center), 3);  // the world's unit
			return 0.01;
		}));
	EXPECT_GT(calls, 10);
	EXPECT_TRUE(own.metric.own != nullptr);
	// The same threshold as a constant answers alike.
	const Touching::Answer constant = scene.with(ContactMetric::deviationShare(0.01));
	EXPECT_EQ(own.contacts, constant.contacts);
	EXPECT_EQ(own.coarsest, constant.coarsest);
	EXPECT_TRUE(scene.warnings.empty());
}

// A small error of the contacts' nodes is no bound of how deep bodies overlap: the result has that, or says that it has
// none.
TEST(BulletMetric, TheErrorOfContactsIsOfTheirNodesAndOfNoDepth)
{
	Touching scene;
	scene.raise(double(scene.upper.getWorldTransform().getOrigin().y()) - 0.05);
	for (const ContactMetric& metric : {ContactMetric::exactly(), ContactMetric::deviationShare(1)})
		for (const bool searches : {false, true})
		{
			scene.context.worldMetric = metric;
			scene.context.searchGap = searches;
			scene.dispatch();
			int overlapping = 0;
			scene.context.forEachPair(
				[&](const PairReport& pair)
				{
					double largest = 0;
					for (const Contact& contact : resultOf(pair).contacts)
					{
						largest = std::max(largest, certifiedErrorApart(pair.hierarchyA->node(contact.nodeA),
																		pair.hierarchyB->node(contact.nodeB)));
						overlapping += contact.upper <= 0;
					}
					EXPECT_EQ(pair.contactError, largest);
					// Deep: at least so deep.
					EXPECT_EQ(std::isfinite(pair.result->errorBound), searches && !pair.result->deep);
					if (!metric.exact) return;
					const double radius = double(pair.hierarchyA->asset().radius);
					EXPECT_LT(pair.contactError, 1e-4 * radius);
					EXPECT_EQ(pair.result->minDistance < -0.01 * radius, searches);
				});
			EXPECT_GT(overlapping, 0);
		}
}

TEST(BulletMetric, ChangesBetweenStepsTakeEffectAtOnceAndComeBack)
{
	Touching scene;
	const Touching::Answer exact = scene.with(ContactMetric::exactly());
	EXPECT_EQ(exact.coarsest, 0u);
	const Touching::Answer coarse = scene.with(ContactMetric::deviationShare(10));
	EXPECT_GT(coarse.finest, 0u);
	EXPECT_LT(coarse.contacts, exact.contacts);
	scene.upperShape.setMetric(ContactMetric::exactly());
	EXPECT_EQ(scene.dispatch().coarsest, 0u);
	scene.upperShape.clearMetric();
	EXPECT_EQ(scene.dispatch().contacts, coarse.contacts);
	scene.context.pairMetric = [](const btCollisionObject&, const btCollisionObject&, ContactMetric& metric)
	{
		metric = ContactMetric::exactly();
		return true;
	};
	EXPECT_EQ(scene.dispatch().contacts, exact.contacts);
}

TEST(BulletMetric, WhatMovesIsCoarserAndRestCostsTheFloor)
{
	Touching scene;
	ContactMetric metric = ContactMetric::velocityFactor(0.3);
	metric.velocityFloorShare = 0.003;
	const Touching::Answer floor = scene.with(ContactMetric::deviationShare(0.003));
	const Touching::Answer rest = scene.with(metric);
	EXPECT_GT(floor.coarsest, 0u);
	EXPECT_EQ(rest.contacts, floor.contacts);
	EXPECT_EQ(rest.coarsest, floor.coarsest);
	scene.upper.setLinearVelocity(btVector3(30, 0, 0));
	const Touching::Answer fast = scene.dispatch();
	EXPECT_GT(fast.coarsest, rest.coarsest);
	scene.upper.setLinearVelocity(btVector3(0, 0, 0));
	EXPECT_EQ(scene.dispatch().contacts, floor.contacts);
}

TEST(BulletMetric, AMovingCameraRefinesWhatItApproaches)
{
	Touching scene;
	double bound = std::numeric_limits<double>::infinity();
	std::uint32_t far = 0;
	for (const double distance : {1000.0, 30.0, 3.0, 1.2})
	{
		scene.context.camera = scene.cameraAt(distance);
		const Touching::Answer answer = scene.with(ContactMetric::viewError(2));
		EXPECT_LE(answer.bound, bound);
		bound = answer.bound;
		if (distance == 1000) far = answer.coarsest;
	}
	EXPECT_GT(far, 0u);
	// In the middle of the contacts, at its height, and looking from below: all defined.
	for (const double distance : {0.2, 0.0, -1000.0})
	{
		scene.context.camera = scene.cameraAt(distance);
		EXPECT_GT(scene.dispatch().contacts, 0u);
	}
	EXPECT_EQ(scene.dispatch().coarsest, far);  // as far below as above
	EXPECT_EQ(scene.dispatch().error, "");
}

TEST(BulletMetric, PlanesAnswerByTheSameMetrics)
{
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	Touching scene(&plane);
	EXPECT_EQ(scene.with(ContactMetric::exactly()).coarsest, 0u);
	const std::uint32_t coarse = scene.with(ContactMetric::deviationShare(10)).coarsest;
	EXPECT_GT(coarse, 0u);
	scene.context.camera = scene.cameraAt(1000);
	EXPECT_EQ(scene.with(ContactMetric::viewError(1000)).coarsest, coarse);
	scene.context.camera = scene.cameraAt(1.2);
	EXPECT_LT(scene.with(ContactMetric::viewError(0.001)).coarsest, coarse);
	scene.upper.setLinearVelocity(btVector3(1000, 0, 0));
	EXPECT_EQ(scene.with(ContactMetric::velocityFactor(10)).coarsest, coarse);
	EXPECT_EQ(scene.with(ContactMetric::ownThreshold([](const ContactPlace&) { return 10.0; })).coarsest, coarse);
	EXPECT_EQ(scene.with(ContactMetric::ownThreshold([](const ContactPlace&) { return -1.0; })).coarsest, 0u);
}

TEST(BulletMetric, AnUnusableMetricIsExactAndSaidOnce)
{
	Touching scene;
	const Touching::Answer exact = scene.with(ContactMetric::exactly());
	for (int i = 0; i < 3; ++i)
	{
		const Touching::Answer blind = scene.with(ContactMetric::viewError(1));
		EXPECT_TRUE(blind.metric.exact);
		EXPECT_EQ(blind.contacts, exact.contacts);
		EXPECT_NE(blind.error.find("camera"), std::string::npos) << blind.error;
	}
	ASSERT_EQ(scene.warnings.size(), 1u);
	EXPECT_NE(scene.warnings[0].find("camera"), std::string::npos) << scene.warnings[0];
	EXPECT_EQ(scene.context.lastStep().warnings().size(), 1u);
	scene.context.camera = scene.cameraAt(100);
	EXPECT_FALSE(scene.dispatch().metric.exact);
	EXPECT_TRUE(scene.context.lastStep().warnings().empty());
	const double nan = std::numeric_limits<double>::quiet_NaN();
	EXPECT_NE(scene.with(ContactMetric::deviationShare(nan)).error.find("weightedDeviationShare"), std::string::npos);
	EXPECT_NE(scene.with(ContactMetric::errorShare(-1)).error.find("maxErrorShare"), std::string::npos);
	scene.context.worldMetric = ContactMetric::errorShare(0.01);
	scene.lowerShape.setMetric(ContactMetric::velocityFactor(0.1));
	scene.upperShape.setMetric(ContactMetric::velocityFactor(nan));  // the stricter of two must not lose it
	EXPECT_TRUE(scene.dispatch().metric.exact);
}
}  // namespace clod::test
