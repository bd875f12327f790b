// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies that hardly move keep their points: as found anew they would be the same to within a tenth of the skin, and what
// moves, or stands on what was moved, is asked about at once.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

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
		btClodShape& shape = addShape(body(name).hierarchy);
		const btScalar scale = btScalar(kSize / double(shape.hierarchy().asset().radius));
		shape.setLocalScaling({scale, scale, scale});
		return addBody(shape, 1, place, btQuaternion(btVector3(1, 0, 0), btScalar(0.1)));
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
		for (int i = 0; i < digits; ++i)
		{
			btRigidBody& digit = heap.drop("number8-600", {});
			digit.setWorldTransform(btTransform(btQuaternion(btVector3(1, 0, 0), btScalar(-1.57079632679)),
												btVector3(0, btScalar(0.15 + 0.27 * i), 0)));
		}
		heap.step(720);
		double fastest = 0;
		for (const auto& moving : heap.bodies) fastest = std::max(fastest, double(moving->getLinearVelocity().length()));
		EXPECT_LT(fastest, 0.01) << digits;
	}
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
				btClodShape& ours = world.addShape(body("number8-600").hierarchy);
				const btScalar scale = btScalar(kSize / double(ours.hierarchy().asset().radius));
				ours.setLocalScaling({scale, scale, scale});
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
// Tells how much of it was asked for last.
struct AskedMesh : btBvhTriangleMeshShape
{
	using btBvhTriangleMeshShape::btBvhTriangleMeshShape;
	mutable btVector3 low, high;
	void processAllTriangles(btTriangleCallback* callback, const btVector3& from, const btVector3& to) const override
	{
		low = from;
		high = to;
		btBvhTriangleMeshShape::processAllTriangles(callback, from, to);
	}
};

// A cube on its edge that goes without gravity over waves, or along a rail towards a wall: its box has triangles in it that it
// does not meet.
struct OverMesh : BulletWorld
{
	explicit OverMesh(bool hasWaves)
	{
		world.setGravity(btVector3(0, 0, 0));
		const auto at = [](int i, int j)
		{ return btVector3(btScalar(0.1 * i), btScalar(0.05 * std::sin(0.9 * i) * std::cos(0.7 * j)), btScalar(0.1 * j)); };
		for (int i = -9; i < 12 && hasWaves; ++i)
			for (int j = -9; j < 9; ++j)
			{
				triangles.addTriangle(at(i, j), at(i, j + 1), at(i + 1, j));
				triangles.addTriangle(at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
			}
		if (!hasWaves) triangles.addTriangle({-2, btScalar(0.23), btScalar(-0.2)}, {2, btScalar(0.23), btScalar(-0.2)}, {2, btScalar(0.2), btScalar(-0.2)});
		const btScalar wall = btScalar(1.01);
		triangles.addTriangle({wall, btScalar(0.2), -1}, {wall, btScalar(0.2), 1}, {wall, 2, 0});
		mesh = &add(std::make_unique<AskedMesh>(&triangles, true));
		addBody(*mesh, 0, {});
		btClodShape& shape = addShape(body("cube").hierarchy);
		const btScalar scale = btScalar(kSize / double(shape.hierarchy().asset().radius));
		shape.setLocalScaling({scale, scale, scale});
		cube = &addBody(shape, 1, {}, btQuaternion(btVector3(1, 0, 0), btScalar(0.785)));
	}
	btTriangleMesh triangles;
	AskedMesh* mesh;
	btRigidBody* cube;
};

TEST(Still, NoMoreOfAMeshIsGatheredThanABodyApartMayMeet)
{
	OverMesh scene(true);
	const double reach = kSize / std::sqrt(3.0);  // along the edge it stands on
	for (int i = 0; i < 50; ++i)
	{
		const btScalar x = btScalar(0.007 * i);
		scene.cube->getWorldTransform().setOrigin(btVector3(x, btScalar(0.6), 0));
		scene.world.performDiscreteCollisionDetection();
		ASSERT_EQ(scene.context.lastStep().nodePairs, 0u);
		EXPECT_LT(double(scene.mesh->high.x() - x), 1.1 * reach) << i;
		EXPECT_GT(double(scene.mesh->low.x() - x), -1.1 * reach) << i;
		EXPECT_GT(double(scene.mesh->high.x() - x), reach) << i;
	}
}

// However often it was asked before, a pair meets what one meets that never was: on the way down, turning, over waves,
// and to the wall.
TEST(Still, WhatIsApartFromAMeshIsMetAsByANewPair)
{
	int apart = 0, near = 0;
	for (int approach = 0; approach < 12; ++approach)
	{
		const bool comesDown = approach < 2;
		OverMesh asked(comesDown);
		Vec3 place{0.35 + 0.013 * approach, comesDown ? 0.6 : 0.53, 0.1};
		Vec3 move = comesDown ? Vec3{0.0005, -0.0015, 0} : Vec3{0.006, 0, 0};
		int met = 0;
		for (int step = 0; step < 250 && met < (comesDown ? 60 : 5); ++step)
		{
			place += move;
			btTransform& pose = asked.cube->getWorldTransform();
			pose.setOrigin(toBullet(place));
			if (comesDown) pose.setRotation(btQuaternion(btVector3(0, 1, 0), btScalar(0.001)) * pose.getRotation());
			OverMesh unasked(comesDown);
			unasked.cube->setWorldTransform(pose);
			asked.world.performDiscreteCollisionDetection();
			unasked.world.performDiscreteCollisionDetection();
			const StepReport now = asked.context.lastStep(), fresh = unasked.context.lastStep();
			ASSERT_EQ(now.nodePairs, fresh.nodePairs) << approach << " at " << step;
			ASSERT_EQ(asked.contacts() > 0, unasked.contacts() > 0) << approach << " at " << step;
			met += now.nodePairs > 0;
			if (asked.contacts() > 0 && comesDown) move = {0.006, 0, 0};
			apart += now.boxTests == 0;
		}
		near += met;
		EXPECT_GT(met, 0) << approach;
	}
	std::printf("left alone %d times, near %d times\n", apart, near);
	EXPECT_GT(apart, 100);
	EXPECT_GT(near, 10);
}

TEST(Still, AMeshEditedIntoABodyApartIsMetAtOnce)
{
	OverMesh scene(true);
	scene.cube->getWorldTransform().setOrigin(btVector3(0, btScalar(0.45), btScalar(0.224)));  // crests beside its edge
	scene.step(5);
	ASSERT_EQ(scene.context.lastStep().nodePairs, 0u);
	ASSERT_EQ(scene.context.lastStep().boxTests, 0u);  // left alone
	unsigned char *vertices, *indices;
	int count, stride, faceStride, faces;
	PHY_ScalarType type, indexType;
	scene.triangles.getLockedVertexIndexBase(&vertices, count, type, stride, &indices, faceStride, faces, indexType);
	for (int i = 0; i < count; ++i)
	{
		auto* vertex = reinterpret_cast<btScalar*>(vertices + i * stride);
		if (std::hypot(double(vertex[0]), double(vertex[2])) < 0.5) vertex[1] += btScalar(0.3);
	}
	scene.triangles.unLockVertexBase(0);
	scene.mesh->refitTree(btVector3(-3, -1, -3), btVector3(3, 2, 3));
	scene.step();
	EXPECT_GT(scene.context.lastStep().nodePairs, 0u);
	EXPECT_GT(scene.contacts(), 0);
}

// Tells by how much of the load contacts are given something else than what they start from.
struct WatchingSolver : btSequentialImpulseConstraintSolver
{
	double changed = 0, load = 0;
	btScalar solveGroup(btCollisionObject** bodies, int bodyCount, btPersistentManifold** manifolds, int manifoldCount,
						btTypedConstraint** constraints, int constraintCount, const btContactSolverInfo& info,
						btIDebugDraw* drawer, btDispatcher* dispatcher) override
	{
		const auto impulses = [&](double share)
		{
			std::vector<double> list;
			for (int i = 0; i < manifoldCount; ++i)
				for (int k = 0; k < manifolds[i]->getNumContacts(); ++k)
					list.push_back(share * double(manifolds[i]->getContactPoint(k).m_appliedImpulse));
			return list;
		};
		const std::vector<double> before = impulses(double(info.m_warmstartingFactor));
		const btScalar residual = btSequentialImpulseConstraintSolver::solveGroup(
			bodies, bodyCount, manifolds, manifoldCount, constraints, constraintCount, info, drawer, dispatcher);
		const std::vector<double> after = impulses(1);
		for (std::size_t i = 0; i < after.size(); ++i)
		{
			changed += std::abs(after[i] - before[i]);
			load += after[i];
		}
		return residual;
	}
};

namespace
{
// A ring of ours that swings on a rod, without friction.
struct SwingingRing
{
	BulletWorld scene;
	WatchingSolver solver;
	btRigidBody& ring;
	SwingingRing() : ring(hang()) {}

private:
	btRigidBody& hang()
	{
		constexpr double kHole = 0.2209, kRod = 0.1, kAngle = 0.3;  // radii
		scene.world.setConstraintSolver(&solver);
		configureWorld(scene.world);
		scene.timeStep = 1.0 / 60;
		btClodShape& shape = scene.addShape(body("torus-900").hierarchy);
		const btScalar scale = btScalar(kSize / double(shape.hierarchy().asset().radius));
		shape.setLocalScaling({scale, scale, scale});
		scene.addBody(scene.add(std::make_unique<btCapsuleShapeZ>(btScalar(kRod), btScalar(2))), 0, {});
		const double reach = kHole - kRod;
		btRigidBody& hung = scene.addBody(shape, 1, {reach * std::sin(kAngle), -reach * std::cos(kAngle), 0},
										  btQuaternion(btVector3(1, 0, 0), SIMD_HALF_PI));
		hung.setFriction(0);
		return hung;
	}
};
}  // namespace

// A ring that swings on a rod has contacts close together, between which a solver's iterations shift the load slowly.
// So they start from what they would end at, and have nothing left to do. Without friction, from none of which they
// start in any case.
TEST(Rocking, StartsFromWhatIterationsEndAt)
{
	SwingingRing swing;
	swing.scene.world.getSolverInfo().m_numIterations = 2000;
	swing.scene.world.getSolverInfo().m_leastSquaresResidualThreshold = 0;
	swing.scene.step(20);
	swing.solver.changed = swing.solver.load = 0;
	swing.scene.step(100);
	EXPECT_GT(double(swing.ring.getLinearVelocity().length()), 0.001);
	EXPECT_LT(swing.solver.changed, 1e-3 * swing.solver.load);
}

// On springs from what they pushed with: what would stop rigid bodies is far more.
TEST(Rocking, OnSpringsStartsFromTheLastImpulses)
{
	SwingingRing swing;
	swing.ring.setContactStiffnessAndDamping(2000, 5);
	swing.scene.step(20);
	swing.solver.changed = swing.solver.load = 0;
	swing.scene.step(100);
	EXPECT_GT(swing.solver.load, 0);
	EXPECT_LT(swing.solver.changed, 0.5 * swing.solver.load);
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
