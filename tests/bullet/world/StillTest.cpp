// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies that hardly move keep their points: as found anew they would be the same to within a tenth of the skin, and what
// moves, or stands on what was moved, is asked about at once.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>
#include <vector>

#include "clod/bullet/ConfigureWorld.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
constexpr double kSize = 0.5;  // radius of what falls

struct Heap : BulletWorld
{
	explicit Heap(bool isOnMesh = false)
	{
		configureWorld(world);
		world.getSolverInfo().m_numIterations = 100;
		if (isOnMesh)
		{
			for (const auto& t : {std::array<btVector3, 3>{at(-9, -9), at(-9, 9), at(9, -9)}, {at(9, 9), at(9, -9), at(-9, 9)}})
				triangles.addTriangle(t[0], t[1], t[2]);
			// Its box holds what stands on it, wherever the ground is moved.
			triangles.addTriangle(at(9, 9), at(9, 8), at(9, 9) + btVector3(0, 2, 0));
			ground = &add(std::make_unique<btBvhTriangleMeshShape>(&triangles, true));
			addBody(*ground, 0, {});
		}
		else
			addBody(add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0))), 0, {});
	}
	static btVector3 at(double x, double z) { return {btScalar(x), 0, btScalar(z)}; }
	btRigidBody& drop(const std::string& name, const Vec3& place)
	{
		btClodShape& shape = addShape(body(name).hierarchy, kSize);
		return addBody(shape, 1, place, btQuaternion(btVector3(1, 0, 0), btScalar(0.1)));
	}
	// Eights that lie flat, one on the other.
	void stack(int digits)
	{
		for (int i = 0; i < digits; ++i)
			drop("number8-600", {})
				.setWorldTransform(btTransform(btQuaternion(btVector3(1, 0, 0), btScalar(-1.57079632679)),
											   btVector3(0, btScalar(0.15 + 0.27 * i), 0)));
	}
	void dropAll()
	{
		for (int i = 0; i < 4; ++i)
		{
			drop("torus-900", {0.3 * i, 0.6 + 0.6 * i, 0.05 * i});
			drop("cube", {2.5, 0.6 + 0.8 * i, 0});
			drop("number8-600", {-2.5 + 0.1 * i, 0.6 + 0.7 * i, 0.1});
		}
		step(1200);
	}
	// The least distance of each pair's points, in radii of what falls.
	std::map<std::pair<int, int>, double> distances()
	{
		std::map<std::pair<int, int>, double> least;
		for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
		{
			const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
			const std::pair<int, int> pair = {manifold.getBody0()->getWorldArrayIndex(), manifold.getBody1()->getWorldArrayIndex()};
			for (int k = 0; k < manifold.getNumContacts(); ++k)
			{
				const auto known = least.emplace(pair, 1e9).first;
				known->second = std::min(known->second, double(manifold.getContactPoint(k).getDistance()) / kSize);
			}
		}
		return least;
	}
	btTriangleMesh triangles;
	btBvhTriangleMeshShape* ground = nullptr;
};
}  // namespace

class StillOnGround : public testing::TestWithParam<bool>
{
};
INSTANTIATE_TEST_SUITE_P(PlaneAndMesh, StillOnGround, testing::Bool());

TEST_P(StillOnGround, PointsKeptAreWhereTheyWouldBeFound)
{
	Heap heap(GetParam());
	heap.dropAll();
	std::uint32_t kept = 0, asked = 0;
	for (int i = 0; i < 10; ++i)
	{
		std::vector<btTransform> starts;
		for (int j = 0; j < 24; ++j)
		{
			starts.clear();
			for (const auto& each : heap.bodies) starts.push_back(each->getWorldTransform());
			heap.step();
			kept += heap.context.lastStep().keptPairs;
			asked += heap.context.lastStep().pairsInContact;
		}
		const auto followed = heap.distances();
		for (std::size_t b = 0; b < starts.size(); ++b) std::swap(starts[b], heap.bodies[b]->getWorldTransform());
		heap.context.keepPoints = false;
		heap.world.performDiscreteCollisionDetection();
		heap.context.keepPoints = true;
		for (const auto& [pair, distance] : heap.distances())
		{
			const auto known = followed.find(pair);
			ASSERT_TRUE(known != followed.end()) << i << ": " << pair.first << " and " << pair.second;
			EXPECT_NEAR(known->second, distance, 5e-5) << i << ": " << pair.first << " and " << pair.second;
		}
		for (std::size_t b = 0; b < starts.size(); ++b) std::swap(starts[b], heap.bodies[b]->getWorldTransform());
	}
	EXPECT_GT(asked, 2000u);
	EXPECT_GT(kept, asked / 2);
}

TEST(Still, WhatIsPushedMovesAsIfNothingHadBeenKept)
{
	for (const double force : {0.5, 3.0, 30.0})
	{
		double way[2];
		for (const bool keeps : {true, false})
		{
			Heap heap;
			heap.context.keepPoints = keeps;
			btRigidBody& cube = heap.drop("cube", {0, 0.6, 0});
			heap.step(600);
			const btVector3 before = cube.getWorldTransform().getOrigin();
			for (int i = 0; i < 240; ++i)
			{
				cube.applyCentralForce(btVector3(btScalar(force), 0, 0));
				heap.step();
			}
			way[keeps ? 1 : 0] = double((cube.getWorldTransform().getOrigin() - before).length());
		}
		EXPECT_NEAR(way[1], way[0], 2e-3 * kSize + 0.01 * way[0]) << force;
	}
}

// What iterations leave of a tower's slow motions dies away: with rows that close gaps at once it grows, with less of the last
// step's impulses it is kept up.
TEST(Still, ATowerStopsThoughItsSolvesDoNotEnd)
{
	for (const auto& [digits, iterations, warmstarting] :
		 {std::tuple(10, 20, 0.98), {20, WorldSettings().solverIterations, 0.98}, {10, 20, WorldSettings().warmstartingFactor}})
	{
		Heap heap;
		WorldSettings settings;
		settings.solverIterations = iterations;
		settings.warmstartingFactor = warmstarting;
		ASSERT_TRUE(setUpWorld(heap.world, heap.context, settings));
		heap.stack(digits);
		heap.step(720);
		double fastest = 0;
		for (const auto& moving : heap.bodies) fastest = std::max(fastest, double(moving->getLinearVelocity().length()));
		EXPECT_LT(fastest, 0.01) << digits;
	}
}

// In Bullet's own world, too: the first of each pair's manifolds come first, then the second of each.
TEST(Still, TheSolverMeetsATowersContactsInRounds)
{
	Heap heap;
	heap.stack(4);
	heap.step(60);
	std::map<std::pair<const btCollisionObject*, const btCollisionObject*>, int> met;
	std::vector<int> rounds;
	for (int i = 0; i < heap.dispatcher.getNumManifolds(); ++i)
	{
		const btPersistentManifold& manifold = *heap.dispatcher.getManifoldByIndexInternal(i);
		rounds.push_back(met[{manifold.getBody0(), manifold.getBody1()}]++);
	}
	EXPECT_EQ(met.size(), 4U);
	EXPECT_GT(rounds.size(), 2 * met.size());
	EXPECT_TRUE(std::is_sorted(rounds.begin(), rounds.end()));
}

// Friction holds no more than mu N, however small the steps: on slopes just beyond, in any direction.
TEST(Still, WhatIsTooSteepSlides)
{
	for (const double rate : {240.0, 1000.0, 4000.0})
		for (const double heading : {0.0, 0.8})
		{
			Heap heap;
			heap.timeStep = 1 / rate;
			btRigidBody& cube = heap.drop("cube", {0, 0.6, 0});
			cube.setFriction(1);
			heap.bodies[0]->setFriction(btScalar(0.5));
			heap.step(int(2 * rate));
			const double angle = std::atan(0.5 * 1.03), sine = 9.81 * std::sin(angle);
			heap.world.setGravity(btVector3(btScalar(sine * std::cos(heading)), btScalar(-9.81 * std::cos(angle)),
											btScalar(sine * std::sin(heading))));
			const btVector3 before = cube.getWorldTransform().getOrigin();
			heap.step(int(rate));
			// g (sin - mu cos) / 2 is 0.066.
			EXPECT_GT(double((cube.getWorldTransform().getOrigin() - before).length()), 0.02) << rate << ", " << heading;
		}
}

// Bullet leaves the friction of points whose load goes within a solve as it is, so many hold more than mu N. On a slope,
// too, what lies alone has few.
TEST(Still, WhatHasManyCornersSlidesAsSoon)
{
	for (const double rate : {60.0, 240.0})
		for (const double mu : {0.35, 0.5, 0.7})
		{
			Heap heap;
			configureWorld(heap.world);
			heap.timeStep = 1 / rate;
			btRigidBody& digit = heap.drop("number8-600", {0, 0.2, 0});
			digit.getWorldTransform().setRotation(btQuaternion(btVector3(1, 0, 0), btScalar(-1.57079632679)));
			digit.setFriction(1);
			heap.bodies[0]->setFriction(btScalar(mu));
			const double angle = std::atan(mu * 1.02);
			heap.world.setGravity(btVector3(btScalar(9.81 * std::sin(angle)), btScalar(-9.81 * std::cos(angle)), 0));
			heap.step(int(rate));
			const double before = double(digit.getLinearVelocity().x());
			heap.step(int(2 * rate));
			const double ideal = 2 * 9.81 * (std::sin(angle) - mu * std::cos(angle));
			EXPECT_GT(double(digit.getLinearVelocity().x()) - before, 0.6 * ideal) << rate << " " << mu;
			EXPECT_LE(heap.contacts(), 12) << rate << " " << mu;
		}
}

// With a friction of 2 the load wanders to the lower edge within a solve. What is held beyond mu N, by Bullet's own shapes as
// by ours, is what Bullet leaves on points whose load has gone.
TEST(Still, FrictionBeyondMuNIsOnPointsWithoutLoad)
{
	constexpr double kMu = 2, kSlope = 2.2, kHalf = 0.15;
	for (const bool isOurs : {false, true})
	{
		double most = 0;
		for (const double rate : {60.0, 240.0})
		{
			BulletWorld world;
			world.timeStep = 1 / rate;
			const double angle = std::atan(kSlope);
			world.world.setGravity(btVector3(btScalar(9.81 * std::sin(angle)), btScalar(-9.81 * std::cos(angle)), 0));
			world.addBody(world.add(std::make_unique<btBoxShape>(btVector3(300, 1, 30))), 0, {0, -1, 0}).setFriction(btScalar(kMu));
			auto& cylinder = world.add(std::make_unique<btCylinderShape>(btVector3(btScalar(0.5), btScalar(kHalf), btScalar(0.5))));
			btCollisionShape* shape = &cylinder;
			if (isOurs)
			{
				btClodShape& ours = world.addShape(body("number8-600").hierarchy, kSize);
				shape = &ours;
			}
			const btQuaternion flat(btVector3(1, 0, 0), btScalar(isOurs ? -1.57079632679 : 0));
			world.addBody(*shape, 1, {0, isOurs ? 0.2 : kHalf + 0.001, 0}, flat).setFriction(1);
			for (int step = 0; step < int(1.5 * rate); ++step)
			{
				world.step();
				double load = 0, held = 0;
				for (int i = 0; i < world.dispatcher.getNumManifolds(); ++i)
				{
					const btPersistentManifold& manifold = *world.dispatcher.getManifoldByIndexInternal(i);
					for (int k = 0; k < manifold.getNumContacts(); ++k)
					{
						const btManifoldPoint& point = manifold.getContactPoint(k);
						const double friction =
							std::hypot(double(point.m_appliedImpulseLateral1), double(point.m_appliedImpulseLateral2));
						load += double(point.m_appliedImpulse);
						held += friction;
						if (point.m_appliedImpulse > 0)
						{
							EXPECT_LE(friction, 1.0001 * kMu * double(point.m_appliedImpulse)) << isOurs << " " << step;
						}
					}
				}
				if (load > 0) most = std::max(most, held / (kMu * load));
			}
		}
		EXPECT_GT(most, 1.05) << isOurs;
		EXPECT_LT(most, 2) << isOurs;
	}
}

// A digit lies flat on the ground by few points, and under another by many.
TEST(Still, WhatLiesAloneHasFewPoints)
{
	Heap heap;
	const auto lay = [&](double height) -> btRigidBody&
	{
		btRigidBody& digit = heap.drop("number8-600", {0, height, 0});
		digit.getWorldTransform().setRotation(btQuaternion(btVector3(1, 0, 0), btScalar(-1.57079632679)));
		heap.step(480);
		return digit;
	};
	const btRigidBody& lower = lay(0.2);
	const int alone = heap.contacts();
	const double height = heightOf(lower);
	EXPECT_GE(alone, 4);
	EXPECT_LE(alone, 10);
	btRigidBody& upper = lay(3 * height);
	int loaded = 0;
	for (int i = 0; i < heap.dispatcher.getNumManifolds(); ++i)
	{
		const btPersistentManifold& manifold = *heap.dispatcher.getManifoldByIndexInternal(i);
		if (manifold.getBody0() != &upper && manifold.getBody1() != &upper) loaded += manifold.getNumContacts();
	}
	EXPECT_GT(loaded, 2 * alone);
	EXPECT_NEAR(heightOf(lower), height, 2e-4 * kSize);
	heap.world.removeRigidBody(&upper);
	heap.step(240);
	EXPECT_LE(heap.contacts(), 10);
	EXPECT_NEAR(heightOf(lower), height, 2e-4 * kSize);
}

TEST_P(StillOnGround, WhatRestsIsNotAskedAnew)
{
	Heap heap(GetParam());
	heap.drop("cup-3000", {0, 0.6, 0});
	heap.step(960);
	std::uint32_t kept = 0;
	for (int i = 0; i < 100; ++i)
	{
		heap.step();
		kept += heap.context.lastStep().keptPairs;
	}
	EXPECT_GT(kept, 95u);
}

TEST(Still, GroundThatIsMovedAwayHoldsNothing)
{
	Heap heap(true);
	btRigidBody& cube = heap.drop("cube", {0, 0.6, 0});
	heap.step(600);
	const double before = heightOf(cube);
	unsigned char* vertices;
	int count, stride, faceStride, faces;
	PHY_ScalarType type, indexType;
	unsigned char* indices;
	heap.triangles.getLockedVertexIndexBase(&vertices, count, type, stride, &indices, faceStride, faces, indexType);
	for (int i = 0; i < count; ++i)
	{
		auto* vertex = reinterpret_cast<btScalar*>(vertices + i * stride);
		vertex[1] -= btScalar(0.2);
	}
	heap.triangles.unLockVertexBase(0);
	heap.ground->refitTree(btVector3(-10, -1, -10), btVector3(10, 2, 10));
	heap.step(240);
	EXPECT_NEAR(heightOf(cube), before - 0.2, 1e-3);
}

// Last step's impulses are of the weight that the body had then: started from, they would throw it.
TEST(Still, WhatBecomesLighterStaysWhereItLies)
{
	for (const double lighter : {1e-1, 1e-3, 1e-6})
	{
		BulletWorld place;
		place.timeStep = 1.0 / 60;
		ASSERT_TRUE(setUpWorld(place.world, place.context));
		btRigidBody& floor = place.addBody(place.add(std::make_unique<btBoxShape>(btVector3(5, btScalar(0.5), 5))), 0, {0, -0.5, 0});
		btClodShape& shape = place.addShape(body("cube").hierarchy);
		const double half = 0.3, scale = half * std::sqrt(3.0) / double(shape.hierarchy().asset().radius);
		shape.setLocalScaling(btVector3(1, 1, 1) * btScalar(scale));
		btRigidBody& cube = place.addBody(shape, 1, {0, half + 0.005, 0});
		for (btRigidBody* each : {&floor, &cube}) each->setFriction(btScalar(0.5));
		place.step(100);
		btVector3 inertia;
		shape.calculateLocalInertia(btScalar(lighter), inertia);
		cube.setMassProps(btScalar(lighter), inertia);
		cube.updateInertiaTensor();
		double fastest = 0;
		for (int i = 0; i < 30; ++i)
		{
			place.step();
			fastest = std::max(fastest, double(cube.getLinearVelocity().length() + cube.getAngularVelocity().length()));
		}
		EXPECT_LT(fastest, 0.01) << lighter;
	}
}
}  // namespace clod::test
