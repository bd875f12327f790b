// SPDX-License-Identifier: GPL-3.0-or-later
// Impacts within a step are passed on in further passes, and nothing else is asked again. Each beside Bullet's own world,
// where the fault that the test looks for is to be seen.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clod/bullet/BodyState.h"
#include "tests/bullet/world/ImpactWorld.h"

namespace clod::test
{
namespace
{
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
constexpr double kThin = 0.12;

// The height of a box's lowest corner.
double lowestOf(const btRigidBody& box, const Vec3& size = {1, 1, 1})
{
	double lowest = 1;
	for (int i = 0; i < 8; ++i)
	{
		const Vec3 corner{(i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2) - 0.5};
		const btVector3 place = box.getWorldTransform() * (toBullet(corner) * toBullet(size));
		lowest = std::min(lowest, double(place.y()));
	}
	return lowest;
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

// 100 times as heavy: 40 iterations do not stop it.
TEST(DynamicsWorld, SolvesOnWhereALightBodyIsCaughtUnderAHeavyOne)
{
	const auto deepest = [](bool ours)
	{
		ImpactWorld world(ours, 60, 9.81);
		world.put(patchHierarchy(boxMesh({20, 1, 20}, {2, 1, 2}, 1)), 0, {0, -0.5, 0});
		btRigidBody &light = world.put(unitCube(), 1, {0, 0.501, 0}), &heavy = world.put(unitCube(), 100, {0, 2, 0});
		double most = 0;
		for (int step = 0; step < 60; ++step)
		{
			world.step();
			const double below = double(light.getWorldTransform().getOrigin().y());
			const double above = double(heavy.getWorldTransform().getOrigin().y());
			most = std::max({most, 0.5 - below, 1 - (above - below)});
		}
		return most;
	};
	EXPECT_GT(deepest(false), 0.05) << "nothing to be seen in Bullet's own world";
	EXPECT_LT(deepest(true), 2e-3);
}

// By its contacts with the wall alone it would fall.
// A corner that turns down onto the ground in the step, steeper at first than on the whole, in both worlds.
TEST(DynamicsWorld, ACornerThatTurnsFarInAStepIsMet)
{
	for (const bool meetsImpacts : {false, true})
	{
		ImpactWorld world(meetsImpacts, 60, 0);
		world.put(slab(), 0, {0, -0.5, 0});
		btRigidBody& cube = world.put(unitCube(), 1, {0, 0.637, 0}, btQuaternion(btVector3(0, 0, 1), btScalar(0.21)));
		cube.setLinearVelocity(btVector3(15, btScalar(-6.42), 0));
		cube.setAngularVelocity(btVector3(0, 0, btScalar(34.5)));
		world.step();
		EXPECT_GT(lowestOf(cube), -0.002) << meetsImpacts;
	}
}

// Gravity takes small bodies far in a step, which Bullet's boxes do not know of.
TEST(DynamicsWorld, WhatForcesTakeToTheGroundIsMet)
{
	for (int i = 0; i < 20; ++i)
	{
		ImpactWorld world(true, 60, 490);
		world.put(slab(), 0, {0, -0.5, 0});
		btRigidBody& cube = world.put(unitCube(), 1, {0, 1.5 + 0.05 * i, 0});
		for (int step = 0; step < 8; ++step)
		{
			world.step();
			EXPECT_GT(lowestOf(cube), -0.001) << i;
		}
	}
}

// A plate that turns by a radian and a half in the step, or in half of it: no rows tell where it ends. So the step is divided,
// and, where it began divided, divided again.
TEST(DynamicsWorld, AStepIsDividedForWhatTurnsFar)
{
	for (const int expected : {1, 2})
	{
		double lowest = 1;
		int parts = 0;
		for (int i = 0; i < 30; ++i)
		{
			ImpactWorld world(true, 60, 0);
			world.put(patchHierarchy(boxMesh({10, 1, 10}, {1, 1, 1}, 1)), 0, {0, -0.5, 0});
			btRigidBody& plate = world.put(patchHierarchy(boxMesh({1, kThin, 1}, {1, 1, 1}, 1)), 0.22, {0, 0.75, 0},
										   btQuaternion(btVector3(btScalar(0.2), 0, 1).normalized(), btScalar(0.1 * i)));
			plate.setLinearVelocity(btVector3(20, -30, 0));
			plate.setAngularVelocity(btVector3(10, 5, btScalar(75 * expected)));
			world.ours().expectParts(expected);
			world.step();
			lowest = std::min(lowest, lowestOf(plate, {1, kThin, 1}));
			parts = std::max(parts, world.ours().parts());
		}
		EXPECT_GT(lowest, -0.003) << expected;
		EXPECT_GT(parts, 4) << expected;
	}
}

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
}  // namespace clod::test
