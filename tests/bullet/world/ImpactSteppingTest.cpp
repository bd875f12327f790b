// SPDX-License-Identifier: GPL-3.0-or-later
// Steps that are divided, at impacts (the paper's section 5.3) or where contacts surprise: time never stands still, and joints and
// kinematic bodies go as in whole ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clod/bullet/BodyState.h"
#include "tests/bullet/world/ImpactWorld.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
// A motion that a step was divided for goes on: the next step is not tried whole, only to be done again.
TEST(ImpactStepping, AfterADividedStepTheNextStartsDivided)
{
	int divided = 0;
	for (int start = 0; start < 5; ++start)
	{
		ImpactWorld world(true, 60, 9.81);
		double longest = 0;  // time that contacts were asked for in a step
		world.context.pairMetric = [&](const btCollisionObject&, const btCollisionObject&, ContactMetric&)
		{
			longest = std::max(longest, double(world.world.getDispatchInfo().m_timeStep));
			return false;
		};
		world.put(patchHierarchy(boxMesh({20, 1, 20}, {2, 1, 2}, 1)), 0, {0, -0.5, 0});
		for (int i = 0; i < 4; ++i)
		{
			btRigidBody& body = world.put(unitCube(), 1, {1.8 * i, 1 + 0.1 * start, 0});
			body.setAngularVelocity(btVector3(20, btScalar(15 - 10 * i), 30));
			body.setLinearVelocity(btVector3(btScalar(20 - 10 * i), -5, 0));
			body.setDamping(btScalar(0.5), btScalar(0.9));
			body.setFriction(1);
		}
		for (int step = 0, before = 1; step < 240; ++step)
		{
			longest = 0;
			world.step();
			if (before >= 4)
			{
				++divided;
				EXPECT_LE(longest, 1.001 * world.timeStep / 2) << start << ", step " << step;
				EXPECT_GE(world.ours().parts(), before / 2) << start << ", step " << step;
			}
			before = world.ours().parts();
		}
		EXPECT_EQ(world.ours().parts(), 1) << "nor is it for ever, start " << start;
	}
	EXPECT_GT(divided, 0) << "no step was divided: the test shows nothing";
}

// Impacts at 1/60 s that fixed steps meet ahead of time are met at theirs: the ball turns round at the floor.
TEST(ImpactStepping, StepsToImpacts)
{
	for (const bool atImpacts : {false, true})
	{
		for (int i = 0; i < 8; ++i)
		{
			ImpactWorld world(true, 60, 0);
			if (atImpacts) world.ours().setStepping(btClodDynamicsWorld::Stepping::kImpacts);
			world.put(patchHierarchy(boxMesh({20, 1, 20}, {2, 1, 2}, 1)), 0, {0, -0.5, 0}).setRestitution(1);
			btRigidBody& ball = world.put(patchHierarchy(ballMesh(0.5, 2)), 1, {0, 2 + 0.013 * i, 0});
			ball.setRestitution(1);
			ball.setLinearVelocity(btVector3(0, -6, 0));
			const double start = heightOf(ball);
			int steps = 0, parts = 1;
			for (; steps < 60 && !(ball.getLinearVelocity().y() > 0); ++steps)
			{
				world.step();
				parts = std::max(parts, world.ours().parts());
			}
			EXPECT_EQ(parts > 1, atImpacts) << i;
			// It has gone down and up again at 6 m/s: how low was the turn?
			const double way = 6 * steps / 60.0, turn = 0.5 * (start + heightOf(ball) - way);
			EXPECT_NEAR(double(ball.getLinearVelocity().y()), 6, 0.01) << i;
			if (atImpacts)
			{
				EXPECT_NEAR(turn, 0.5, 0.01) << i;
			}
		}
	}
}

// A level that changes at every question, so that what was just met is no longer there, or is overlapping already: time
// goes on, and the bodies stay apart but for what the levels may be off.
TEST(ImpactStepping, ALevelThatChangesAtTheImpactHoldsNothingUp)
{
	constexpr double kError = 0.05;  // of the radius of 1
	ImpactWorld world(true, 60, 9.81);
	world.ours().setStepping(btClodDynamicsWorld::Stepping::kImpacts);
	int asked = 0;
	world.context.pairMetric = [&](const btCollisionObject&, const btCollisionObject&, ContactMetric& metric)
	{
		metric = ++asked % 3 == 0 ? ContactMetric::exactly() : ContactMetric::errorShare(kError);
		return true;
	};
	world.put(patchHierarchy(boxMesh({20, 1, 20}, {2, 1, 2}, 1)), 0, {0, -0.5, 0});
	btClodShape& shape = world.addShape(body("sphere-300").hierarchy);
	const double scale = 1 / double(shape.hierarchy().asset().radius);
	shape.setLocalScaling(btScalar(scale) * btVector3(1, 1, 1));
	btRigidBody& ball = world.addBody(shape, 1, {0, 1.5, 0}, btQuaternion(btVector3(1, 0, 0), btScalar(0.5)));
	ball.setLinearVelocity(btVector3(0, -10, 0));
	int fine = 0, coarse = 0;
	const auto lowest = [&]
	{
		double least = HUGE_VAL;
		for (const auto& triangle : body("sphere-300").triangles)
			for (const Vec3& corner : triangle)
				least = std::min(least, double((ball.getWorldTransform() * toBullet(scale * corner)).y()));
		return least;
	};
	for (int i = 0; i < 240; ++i)
	{
		world.step();
		ASSERT_LE(world.ours().parts(), 8);
		ASSERT_GT(lowest(), -kError) << i;
		world.context.forEachPair([&](const PairReport& pair)
								  { ++(pair.result->stats.coarsestLevel > 0 ? coarse : fine); });
	}
	EXPECT_GT(std::min(fine, coarse), 20) << "no level changed: the test shows nothing";
	EXPECT_LT(std::abs(lowest()), kError);
	EXPECT_LT(double(ball.getLinearVelocity().length()), 1e-3);
}

// More impacts in a step than parts: a ball that bounces between two plates stays there, with no more speed than it had.
TEST(ImpactStepping, CountlessImpactsEndTheStep)
{
	using Stepping = btClodDynamicsWorld::Stepping;
	for (const Stepping stepping : {Stepping::kImpacts, Stepping::kFixed})
		for (int speed = 44; speed < 56; ++speed)
		{
			ImpactWorld world(true, 60, 0);
			world.ours().setStepping(stepping);
			btRigidBody& ball = rattle(world);
			ball.setLinearVelocity(btVector3(0, btScalar(speed), 0));
			const double energy = kineticEnergy(ball, 0);
			for (int i = 0; i < 60; ++i)
			{
				world.step();
				ASSERT_LE(world.ours().parts(), 8);
				ASSERT_NEAR(heightOf(ball), 0.515, 0.03) << speed;
				ASSERT_LE(kineticEnergy(ball, 0), 1.02 * energy) << speed;
			}
		}
}

// A joint whose ends are apart closes as fast as in Bullet's world, however short the parts of a step.
TEST(ImpactStepping, JointsCloseNoFasterInShortParts)
{
	double left[2] = {};  // after a step
	for (const bool atImpacts : {false, true})
	{
		ImpactWorld world(atImpacts, 60, 0);
		if (atImpacts) world.ours().setStepping(btClodDynamicsWorld::Stepping::kImpacts);
		rattle(world);
		btRigidBody& first = world.put(unitCube(), 1, {10, 0, 0});
		btRigidBody& second = world.put(unitCube(), 1, {15, 0, 0});
		btPoint2PointConstraint joint(first, second, btVector3(1, 0, 0), btVector3(-1, 0, 0));
		world.world.addConstraint(&joint, true);
		const auto apart = [&]
		{ return double(second.getWorldTransform().getOrigin().x() - first.getWorldTransform().getOrigin().x()) - 2; };
		world.step();
		if (atImpacts)
		{
			EXPECT_EQ(world.ours().parts(), 8);
		}
		left[atImpacts] = apart();
		world.step(20);
		EXPECT_LT(apart(), 0.1);
		world.world.removeConstraint(&joint);
	}
	EXPECT_GE(left[1], left[0]);
	EXPECT_LT(left[1], 1.05 * left[0]);
}

// A chain that swings on a kinematic ring, which in a step of several parts goes on from part to part, and is there for
// all passes of a part.
TEST(ImpactStepping, AChainStaysOnItsHoistInDividedSteps)
{
	for (int start = 0; start < 3; ++start)
	{
		ImpactWorld world(true, 60, 600);
		world.ours().setStepping(btClodDynamicsWorld::Stepping::kImpacts);
		const auto& ring = body("ring").hierarchy;
		btRigidBody& hoist = world.put(ring, 0, {0, 0, 0});
		const btScalar way = btScalar(13 / 60.0);
		hoist.setCenterOfMassTransform(btTransform(btQuaternion(btVector3(1, 0, 0), SIMD_HALF_PI), btVector3(0, -way, 0)));
		hoist.setCollisionFlags(hoist.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
		for (int i = 1; i < 4; ++i)
		{
			btRigidBody& link = world.put(ring, 1, {0, -1.39 * i, 0});
			const btVector3 axis(i % 2 == 0 ? 1 : 0, 0, i % 2 == 0 ? 0 : 1);
			link.getWorldTransform().setRotation(btQuaternion(axis, SIMD_HALF_PI));
			link.setLinearVelocity(btVector3(0, 13, 0));
			link.setAngularVelocity(btVector3(btScalar(6 + start), 1, 4));
		}
		btRigidBody& ball = rattle(world, 9);  // divides the steps
		int divided = 0;
		double deepest = 0;
		for (int i = 0; i < 90; ++i)
		{
			hoist.getWorldTransform().getOrigin().setY(btScalar(i) * way);
			ball.setLinearVelocity(btVector3(0, 50, 0));
			world.step();
			EXPECT_EQ(hoist.getWorldTransform().getOrigin().y(), btScalar(i) * way) << "it is its owner's to move";
			divided += world.ours().parts() > 1;
			if (i > 4) deepest = std::max(deepest, world.depthAt(hoist));
		}
		EXPECT_GT(divided, 30) << "steps: the test shows nothing";
		EXPECT_LT(deepest, 0.005) << start;
	}
}

// What follows a kinematic lift as fast as that moves is not hit, in any part of the step; what it moves into is.
TEST(ImpactStepping, ImpactsAreWithKinematicBodiesAsTheyMove)
{
	int parts[3];
	for (const int which : {0, 1, 2})
	{
		ImpactWorld world(true, 60, 0);
		world.ours().setStepping(btClodDynamicsWorld::Stepping::kImpacts);
		const btScalar speed = 10, way = speed / 60;
		btRigidBody& lift = world.put(unitCube(), 0, {0, 0, 0});
		lift.setCollisionFlags(lift.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
		btRigidBody* other = which > 0 ? &world.put(unitCube(), 1, {0, which == 1 ? -1.02 : 1.3, 0}) : nullptr;
		world.put(unitCube(), 0, {9, 0, 0}).setRestitution(1);
		btRigidBody& ball = world.put(unitCube(), 1, {9, 2, 0});
		ball.setRestitution(1);
		for (int i = 0; i < 2; ++i)
		{
			ball.getWorldTransform().setOrigin(btVector3(9, 2, 0));
			ball.setLinearVelocity(btVector3(0, -150, 0));  // hits after two fifths of the step
			lift.getWorldTransform().getOrigin().setY(btScalar(i) * way);
			if (which == 1) other->setLinearVelocity(btVector3(0, speed, 0));
			world.step();
			parts[which] = world.ours().parts();
		}
	}
	EXPECT_GT(parts[0], 1);
	EXPECT_EQ(parts[1], parts[0]);
	EXPECT_GT(parts[2], parts[0]);
}

// What drives a body gives it energy, by contacts with ours, too: no step is divided for that. The other body is as fast
// as it is driven in the end.
TEST(ImpactStepping, StepsAreNotDividedForEnergyThatIsMeant)
{
	const auto mostSpeed = [](ImpactWorld& world, const btRigidBody& driven, int steps, const auto& drive)
	{
		double speed = 0;
		for (int step = 0; step < steps; ++step)
		{
			drive(step);
			world.step();
			EXPECT_EQ(world.ours().parts(), 1) << step;
			speed = std::max(speed, double(driven.getLinearVelocity().length()));
		}
		return speed;
	};
	const auto nothing = [](int) {};
	{
		SCOPED_TRACE("a motor");
		ImpactWorld world(true, 60, 0);
		btRigidBody &pusher = world.put(unitCube(), 1, {0, 0, 0}), &pushed = world.put(unitCube(), 1, {1.0005, 0, 0});
		btSliderConstraint slider(pusher, btTransform::getIdentity(), true);
		slider.setLowerLinLimit(-99);
		slider.setUpperLinLimit(99);
		slider.setPoweredLinMotor(true);
		slider.setTargetLinMotorVelocity(5);
		slider.setMaxLinMotorForce(10);
		world.world.addConstraint(&slider);
		EXPECT_GT(mostSpeed(world, pushed, 30, nothing), 1);
		world.world.removeConstraint(&slider);
	}
	{
		SCOPED_TRACE("a kinematic body");
		ImpactWorld world(true, 60, 0);
		btRigidBody &pusher = world.put(unitCube(), 0, {0, 0, 0}), &pushed = world.put(unitCube(), 1, {1.0005, 0, 0});
		pusher.setCollisionFlags(pusher.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
		const auto faster = [&](int step)
		{ pusher.getWorldTransform().getOrigin() += btVector3(btScalar(0.1 * step / 60), 0, 0); };
		EXPECT_GT(mostSpeed(world, pushed, 30, faster), 1);
	}
	{
		SCOPED_TRACE("a belt");
		ImpactWorld world(true, 60, 9.81);
		world.world.getSolverInfo().m_solverMode |= SOLVER_ENABLE_FRICTION_DIRECTION_CACHING;
		btRigidBody &belt = world.put(slab(), 0, {0, -0.5, 0}), &box = world.put(unitCube(), 1, {0, 0.5002, 0});
		belt.setCollisionFlags(belt.getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
		for (btRigidBody* body : {&belt, &box}) body->setFriction(1);
		const ContactAddedCallback before = gContactAddedCallback;
		gContactAddedCallback = [](btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
								   const btCollisionObjectWrapper*, int, int)
		{
			point.m_lateralFrictionDir1 = btVector3(1, 0, 0);
			point.m_lateralFrictionDir2 = btVector3(0, 0, 1);
			point.m_contactPointFlags |= BT_CONTACT_FLAG_LATERAL_FRICTION_INITIALIZED;
			point.m_contactMotion1 = 2;
			return true;
		};
		EXPECT_GT(mostSpeed(world, box, 30, nothing), 1);
		gContactAddedCallback = before;
	}
	{
		SCOPED_TRACE("a spring");
		ImpactWorld world(true, 60, 9.81);
		world.put(slab(), 0, {0, -0.5, 0}).setContactStiffnessAndDamping(2000, 0);
		btRigidBody& box = world.put(unitCube(), 1, {0, 0.45, 0});
		EXPECT_GT(mostSpeed(world, box, 10, nothing), 1);
	}
	{
		SCOPED_TRACE("a bumper");
		ImpactWorld world(true, 60, 0);
		world.put(slab(), 0, {0, -0.5, 0}).setRestitution(2);
		btRigidBody& box = world.put(unitCube(), 1, {0, 0.52, 0});
		box.setRestitution(1);
		box.setLinearVelocity(btVector3(0, -1, 0));
		EXPECT_GT(mostSpeed(world, box, 10, nothing), 1.5);
	}
	{
		SCOPED_TRACE("gravity, after a rebound from a ceiling");
		ImpactWorld world(true, 60, 9.81);
		world.put(slab(), 0, {0, 1.5, 0}).setRestitution(1);
		btRigidBody& box = world.put(unitCube(), 1, {0, 0.496, 0});
		box.setRestitution(1);
		box.setLinearVelocity(btVector3(0, btScalar(0.5), 0));
		EXPECT_GT(mostSpeed(world, box, 5, nothing), 0.4);
	}
	{
		SCOPED_TRACE("an overlap, less than a skin in a step");
		ImpactWorld world(true, 60, 0);
		world.world.getSolverInfo().m_splitImpulsePenetrationThreshold = -1;
		world.put(slab(), 0, {0, -0.5, 0});
		EXPECT_GT(mostSpeed(world, world.put(unitCube(), 1, {0, 0.4999, 0}), 5, nothing), 1e-4);
	}
}
}  // namespace clod::test
