// SPDX-License-Identifier: GPL-3.0-or-later
// Impacts within a step: passed on, divided at, never a reason for time to stand still. Each beside Bullet's own world,
// where the fault that the test looks for is to be seen.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clod/bullet/BodyState.h"
#include "clod/bullet/ConfigureWorld.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
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
	btRigidBody& put(const std::shared_ptr<const Hierarchy>& hierarchy, double mass, const Vec3& place)
	{
		btRigidBody& body = addBody(addShape(hierarchy), mass, place);
		body.setDamping(0, 0);
		body.setFriction(0);
		return body;
	}
};

const std::shared_ptr<const Hierarchy>& unitCube()
{
	static const std::shared_ptr<const Hierarchy> hierarchy = patchHierarchy(boxMesh({1, 1, 1}, {2, 2, 2}, 1));
	return hierarchy;
}

// Six cubes in a row, 5 mm apart, hit by a seventh: how deep do neighbours get, and how often was a step solved at most?
struct Row
{
	double deepest = 0;
	int passes = 0;
};
Row hitRow(bool meetsImpacts, double speed)
{
	ImpactWorld world(meetsImpacts, 60, 0);
	std::vector<btRigidBody*> row;
	for (int i = 0; i < 7; ++i) row.push_back(&world.put(unitCube(), 1, {i == 0 ? -2.5 : 1.005 * i, 0, 0}));
	row[0]->setLinearVelocity(btVector3(btScalar(speed), 0, 0));
	Row seen;
	for (int step = 0; step < 60; ++step)
	{
		world.step();
		for (std::size_t i = 0; i + 1 < row.size(); ++i)
		{
			const btVector3 between = row[i + 1]->getWorldTransform().getOrigin() - row[i]->getWorldTransform().getOrigin();
			seen.deepest = std::max(seen.deepest, 1 - double(between.x()));
		}
		if (meetsImpacts) seen.passes = std::max(seen.passes, world.ours().passes());
	}
	return seen;
}

// A ball that rattles between two plates.
btRigidBody& rattle(ImpactWorld& world, double x = 0)
{
	for (const double y : {-0.5, 1.53})
		world.put(patchHierarchy(boxMesh({4, 1, 4}, {2, 1, 2}, 1)), 0, {x, y, 0}).setRestitution(1);
	btRigidBody& ball = world.put(patchHierarchy(ballMesh(0.5, 2)), 1, {x, 0.515, 0});
	ball.setRestitution(1);
	ball.setLinearVelocity(btVector3(0, 50, 0));
	return ball;
}
}  // namespace

TEST(DynamicsWorld, WithOnePassAndOnePartIsBulletsOwn)
{
	const auto run = [](bool ours)
	{
		ImpactWorld world(ours, 60, 9.81);
		if (ours)
		{
			world.ours().setMostPasses(1);
			world.ours().setMostParts(1);
		}
		world.put(patchHierarchy(boxMesh({20, 1, 20}, {2, 1, 2}, 1)), 0, {0, -0.5, 0});
		std::vector<btRigidBody*> bodies;
		for (int i = 0; i < 5; ++i) bodies.push_back(&world.put(unitCube(), 1, {0.3 * i, 0.6 + 1.2 * i, 0.1 * i}));
		world.step(90);
		std::vector<btScalar> numbers;
		for (const btRigidBody* body : bodies)
			for (int k = 0; k < 3; ++k)
			{
				numbers.push_back(body->getWorldTransform().getOrigin()[k]);
				numbers.push_back(body->getAngularVelocity()[k]);
			}
		return numbers;
	};
	EXPECT_EQ(run(true), run(false));
}

TEST(DynamicsWorld, PassesAnImpactOnWithinTheStep)
{
	for (const double speed : {5.0, 10.0})
	{
		const Row plain = hitRow(false, speed), ours = hitRow(true, speed);
		EXPECT_GT(plain.deepest, 0.005) << speed << " m/s: nothing to be seen in Bullet's own world";
		EXPECT_LT(ours.deepest, 5e-4) << speed;
		EXPECT_GT(ours.passes, 1) << speed;
	}
}

// Fails in Bullet's own world, too, where bodies are looked for along the motion between them alone: they have none.
TEST(DynamicsWorld, AStackThatFallsAsOneStopsAsOne)
{
	for (const bool ours : {false, true})
	{
		ImpactWorld world(ours, 60, 9.81);
		world.world.getSolverInfo().m_numIterations = 100;
		world.put(patchHierarchy(boxMesh({20, 1, 20}, {2, 1, 2}, 1)), 0, {0, -0.5, 0});
		std::vector<btRigidBody*> stack;
		for (int i = 0; i < 5; ++i) stack.push_back(&world.put(unitCube(), 1, {0, 0.52 + 1.005 * i, 0}));
		for (btRigidBody* body : stack) body->setLinearVelocity(btVector3(0, -1, 0));
		double deepest = 0;
		for (int step = 0; step < 60; ++step)
		{
			world.step();
			for (std::size_t i = 0; i < stack.size(); ++i)
			{
				const double below = i == 0 ? -0.5 : double(stack[i - 1]->getWorldTransform().getOrigin().y());
				deepest = std::max(deepest, 1 - (double(stack[i]->getWorldTransform().getOrigin().y()) - below));
			}
		}
		EXPECT_LT(deepest, 5e-4) << (ours ? "ours" : "Bullet's own");
	}
}

// By its contacts with the wall alone it would fall.
TEST(DynamicsWorld, WhatRestsIsNotAskedAgain)
{
	ImpactWorld world(true, 60, 9.81);
	world.put(patchHierarchy(boxMesh({20, 1, 20}, {2, 1, 2}, 1)), 0, {0, -0.5, 0});
	world.put(patchHierarchy(boxMesh({1, 4, 4}, {1, 2, 2}, 1)), 0, {-1.0008, 2.5, 0});
	for (int i = 0; i < 3; ++i) world.put(unitCube(), 1, {0, 0.501 + 1.0005 * i, 0});
	world.step(60);
	for (int step = 0; step < 30; ++step)
	{
		world.step();
		ASSERT_EQ(world.ours().passes(), 1) << step;
		ASSERT_GE(world.contacts(), 3 * 4 + 4) << "the wall is not touched";
	}
}

// A trigger tells what is in it, and never moves it: contacts that nothing obeys are no surprise, however fast it is.
TEST(DynamicsWorld, WhatHasNoResponseIsNotAskedAgain)
{
	ImpactWorld with(true, 60, 9.81), without(true, 60, 9.81);
	btRigidBody& trigger = with.put(patchHierarchy(boxMesh({3, 1, 3}, {2, 2, 2}, 1)), 0, {0.4, 0, 0});
	trigger.setCollisionFlags(trigger.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
	int told = 0;
	std::vector<btRigidBody*> bodies;
	for (ImpactWorld* world : {&with, &without}) bodies.push_back(&world->put(unitCube(), 1, {0, 2, 0}));
	for (int step = 0; step < 60; ++step)
	{
		with.step();
		without.step();
		told += with.contacts();
		ASSERT_EQ(with.ours().passes(), 1) << step;
		ASSERT_TRUE(bodies[0]->getWorldTransform() == bodies[1]->getWorldTransform()) << step;
	}
	EXPECT_GT(told, 20);
}

// Rows that ask for the arc of a turning must not drive each other: a heap of digits exploded.
TEST(DynamicsWorld, BodiesThatTurnFastGainNoEnergyFromEachOther)
{
	for (const auto& [ours, turning] :
		 {std::pair{false, 30.0}, {true, 30.0}, {false, 60.0}, {true, 60.0}, {false, 120.0}, {true, 120.0}})
	{
		ImpactWorld world(ours, 60, 0);
		std::vector<btRigidBody*> bodies;
		for (int i = 0; i < 27; ++i)
		{
			bodies.push_back(&world.put(unitCube(), 1, {1.5 * (i % 3 - 1), 1.5 * (i / 3 % 3 - 1), 1.5 * (i / 9 - 1)}));
			bodies.back()->setLinearVelocity(btScalar(-8) * bodies.back()->getWorldTransform().getOrigin());
			bodies.back()->setAngularVelocity(
				btVector3(btScalar(turning * std::sin(i)), btScalar(turning * std::cos(2 * i)), btScalar(turning * std::sin(3 * i))));
		}
		const auto energy = [&]
		{
			double sum = 0;
			for (const btRigidBody* body : bodies)
				sum += kineticEnergy(*body, 0);
			return sum;
		};
		const double start = energy();
		for (int step = 0; step < 120; ++step)
		{
			world.step();
			ASSERT_LT(energy(), 1.05 * start) << (ours ? "ours, step " : "Bullet's own, step ") << step;
		}
		EXPECT_LT(energy(), 0.9 * start) << "nothing met";
	}
}

TEST(DynamicsWorld, AsksNothingAgainWhereNothingIsHit)
{
	ImpactWorld world(true, 240, 9.81);
	world.put(patchHierarchy(boxMesh({20, 1, 20}, {2, 1, 2}, 1)), 0, {0, -0.5, 0});
	for (int i = 0; i < 3; ++i) world.put(unitCube(), 1, {0, 0.5002 + 1.0002 * i, 0});
	world.step(240);
	int again = 0;
	for (int i = 0; i < 60; ++i)
	{
		world.step();
		again += world.ours().pairsAskedAgain();
	}
	EXPECT_EQ(again, 0);
	EXPECT_EQ(world.ours().parts(), 1);
}

// What takes no part in the impacts falls as ever, in however many parts the step is taken.
TEST(DynamicsWorld, ForcesActOnceAStep)
{
	ImpactWorld world(true, 60, 9.81);
	btRigidBody& alone = world.put(unitCube(), 1, {0, 0, 50});
	alone.setDamping(btScalar(0.1), 0);
	std::vector<btRigidBody*> row;
	for (int i = 0; i < 7; ++i) row.push_back(&world.put(unitCube(), 1, {i == 0 ? -1.5 : 1.001 * i, 0, 0}));
	row[0]->setLinearVelocity(btVector3(60, 0, 0));
	row[0]->setAngularVelocity(btVector3(20, 20, 30));
	ImpactWorld quiet(true, 60, 9.81);
	btRigidBody& same = quiet.put(unitCube(), 1, {0, 0, 50});
	same.setDamping(btScalar(0.1), 0);
	int most = 1;
	for (int i = 0; i < 30; ++i)
	{
		world.step();
		quiet.step();
		most = std::max(most, world.ours().parts());
	}
	EXPECT_GT(most, 1) << "no step was divided: the test shows nothing";
	EXPECT_NEAR(double(alone.getLinearVelocity().y()), double(same.getLinearVelocity().y()), 1e-4);
}

// A motion that a step was divided for goes on: the next step is not tried whole, only to be done again.
TEST(DynamicsWorld, AfterADividedStepTheNextStartsDivided)
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
TEST(DynamicsWorld, StepsToImpacts)
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
TEST(DynamicsWorld, ALevelThatChangesAtTheImpactHoldsNothingUp)
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

// More impacts in a step than parts.
TEST(DynamicsWorld, CountlessImpactsEndTheStep)
{
	ImpactWorld world(true, 60, 0);
	world.ours().setStepping(btClodDynamicsWorld::Stepping::kImpacts);
	const btRigidBody& ball = rattle(world);
	for (int i = 0; i < 60; ++i)
	{
		world.step();
		ASSERT_LE(world.ours().parts(), 8);
		ASSERT_NEAR(heightOf(ball), 0.515, 0.03);
	}
}

// A joint whose ends are apart closes as fast as in Bullet's world, however short the parts of a step.
TEST(DynamicsWorld, JointsCloseNoFasterInShortParts)
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

// Each asks its own pairs again.
TEST(DynamicsWorld, WorldsMayShareAContext)
{
	struct Pile
	{
		btDefaultCollisionConfiguration configuration;
		btCollisionDispatcher dispatcher{&configuration};
		btDbvtBroadphase broadphase;
		btSequentialImpulseConstraintSolver solver;
		btClodDynamicsWorld world;
		btClodShape shape{unitCube()};
		btStaticPlaneShape plane{btVector3(0, 1, 0), 0};
		std::vector<std::unique_ptr<btRigidBody>> bodies;
		explicit Pile(Context& context) : world(&dispatcher, &broadphase, &solver, &configuration, &context)
		{
			EXPECT_TRUE(setUpWorld(world, context));
			for (int i = 0; i < 6; ++i)
			{
				btCollisionShape* const either[] = {&plane, &shape};
				bodies.push_back(std::make_unique<btRigidBody>(btScalar(i > 0), nullptr, either[i > 0],
															   btVector3(1, 1, 1) / btScalar(6)));
				bodies.back()->getWorldTransform().setOrigin(btVector3(btScalar(0.1 * i), btScalar(i > 0 ? 1.2 * i : 0), 0));
				world.addRigidBody(bodies.back().get());
			}
		}
		~Pile()
		{
			for (const auto& body : bodies) world.removeRigidBody(body.get());
		}
		int step()
		{
			world.stepSimulation(btScalar(1.0 / 60), 0);
			return world.pairsAskedAgain();
		}
	};
	Context own, shared;
	Pile alone(own), first(shared), second(shared);
	int askedAgain = 0;
	for (int i = 0; i < 120; ++i)
	{
		const int expected = alone.step();
		askedAgain += expected;
		ASSERT_EQ(first.step(), expected) << i;
		ASSERT_EQ(second.step(), expected) << i;
		ASSERT_EQ(heightOf(*second.bodies.back()), heightOf(*alone.bodies.back())) << i;
	}
	EXPECT_GT(askedAgain, 10);
}

// Kinematic bodies as Bullet's manual makes them, of mass 0 and so with the flag of static ones besides. One that goes
// many times the others' size a step pushes them all the same; what is lifted stays on the lift.
TEST(DynamicsWorld, KinematicBodiesPushWhatTheyMeetOnTheirWay)
{
	const auto move = [](ImpactWorld& world, btRigidBody& mover, const btVector3& speed, int steps)
	{
		mover.setCollisionFlags(mover.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
		double deepest = 0;
		for (int i = 0; i < steps; ++i)
		{
			mover.getWorldTransform().getOrigin() += speed * btScalar(world.timeStep);
			world.step();
			if (i > 4) deepest = std::max(deepest, world.depthAt(mover));
		}
		return deepest;
	};
	for (int i = 0; i < 4; ++i)
	{
		ImpactWorld sweep(true, 60, 0);
		btRigidBody& plate = sweep.put(patchHierarchy(boxMesh({0.1, 2, 2}, {1, 2, 2}, 1)), 0, {-8.6 + 0.25 * i, 0, 0});
		btRigidBody& ball = sweep.put(patchHierarchy(ballMesh(0.2, 2)), 1, {0, 0.01, 0.02});
		move(sweep, plate, btVector3(60, 0, 0), 12);
		EXPECT_GT(double(ball.getWorldTransform().getOrigin().x()), double(plate.getWorldTransform().getOrigin().x())) << i;
		EXPECT_LT(double(ball.getLinearVelocity().length()), 61) << i;
	}
	for (const bool meetsImpacts : {false, true})
	{
		ImpactWorld lift(meetsImpacts, 60, 9.81);
		btRigidBody& floor = lift.put(slab(), 0, {0, -0.5, 0});
		lift.put(unitCube(), 1, {0, 0.501, 0});
		EXPECT_LT(move(lift, floor, btVector3(0, 3, 0), 60), 0.01) << meetsImpacts;
	}
}

// A chain that swings on a kinematic ring, which in a step of several parts goes on from part to part, and is there for
// all passes of a part.
TEST(DynamicsWorld, AChainStaysOnItsHoistInDividedSteps)
{
	int divided = 0;
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
		EXPECT_LT(deepest, 0.005) << start;
	}
	EXPECT_GT(divided, 90) << "steps of 270: the test shows nothing";
}

// What follows a kinematic lift as fast as that moves is not hit, in any part of the step; what it moves into is.
TEST(DynamicsWorld, ImpactsAreWithKinematicBodiesAsTheyMove)
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
TEST(DynamicsWorld, StepsAreNotDividedForEnergyThatIsMeant)
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
