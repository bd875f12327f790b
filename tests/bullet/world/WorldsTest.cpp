// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes after Bullet's own examples, with moving bodies of ours and Bullet's open landscapes, from seeded starts. Nothing
// explodes, sinks or leaves; what becomes of them with Bullet's own shapes is told beside.
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/Vehicle/btRaycastVehicle.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "clod/bullet/ConfigureWorld.h"
#include "tests/bullet/PatchHierarchy.h"
#include "tests/query/Bodies.h"
#include "tests/query/Questions.h"

namespace clod::test
{
namespace
{
constexpr double kFar = std::numeric_limits<double>::infinity();

btVector3 vector(double x, double y, double z)
{
	return btVector3(btScalar(x), btScalar(y), btScalar(z));
}

// A world of ours or of Bullet's shapes alone, which owns what is put into it.
struct Stage
{
	Context context;
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btMultiBodyConstraintSolver solver;
	btMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
	std::vector<std::unique_ptr<btTriangleMesh>> meshes;
	std::vector<std::unique_ptr<btCollisionShape>> shapes;
	std::vector<std::unique_ptr<btRigidBody>> bodies;
	const bool ours;
	Random random;
	double fastest = 0, lowest = kFar, farthest = 0;  // of the origins of all that moves, since the start

	Stage(bool isOurs, int seed) : ours(isOurs), random(std::uint64_t(seed) + 1)
	{
		context.warn = {};
		configureWorld(world);
		if (ours && !setUpWorld(world, context)) std::abort();
		if (!ours) btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
		world.setGravity(vector(0, -9.81, 0));
		world.getDispatchInfo().m_deterministicOverlappingPairs = true;
	}
	~Stage()
	{
		for (const auto& body : bodies) world.removeRigidBody(body.get());
	}
	template <class Shape>
	Shape& add(std::unique_ptr<Shape> shape)
	{
		Shape& added = *shape;
		shapes.push_back(std::move(shape));
		return added;
	}
	// Of radius 1, as ours or as the shape that Bullet has for moving meshes.
	btCollisionShape& detailed(const char* name)
	{
		const Body& model = body(name);
		const double scale = 1 / double(model.hierarchy->asset().radius);
		if (ours)
		{
			btClodShape& shape = add(std::make_unique<btClodShape>(model.hierarchy));
			shape.setLocalScaling(vector(scale, scale, scale));
			return shape;
		}
		meshes.push_back(std::make_unique<btTriangleMesh>());
		for (const auto& t : model.triangles)
			meshes.back()->addTriangle(scaled(t[0], scale), scaled(t[1], scale), scaled(t[2], scale));
		btGImpactMeshShape& shape = add(std::make_unique<btGImpactMeshShape>(meshes.back().get()));
		shape.updateBound();
		return shape;
	}
	// A cube of ours, or a box.
	btCollisionShape& cubeOf(double size)
	{
		if (!ours) return add(std::make_unique<btBoxShape>(vector(0.5 * size, 0.5 * size, 0.5 * size)));
		btClodShape& shape = add(std::make_unique<btClodShape>(cube()));
		shape.setLocalScaling(vector(size, size, size));
		return shape;
	}
	btRigidBody& put(btCollisionShape& shape, double mass, const btVector3& place,
					 const btQuaternion& turn = btQuaternion::getIdentity())
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape.calculateLocalInertia(btScalar(mass), inertia);
		btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, &shape, inertia);
		info.m_startWorldTransform = btTransform(turn, place);
		bodies.push_back(std::make_unique<btRigidBody>(info));
		world.addRigidBody(bodies.back().get());
		return *bodies.back();
	}
	btRigidBody& floor()
	{
		return put(add(std::make_unique<btBoxShape>(vector(20, 1, 20))), 0, vector(0, -1, 0));
	}
	// An open, waved landscape of triangles about height 0, of Bullet's.
	btRigidBody& landscape()
	{
		constexpr int kCells = 40;
		const auto place = [](int i, int j)
		{
			const double x = i - 0.5 * kCells, z = j - 0.5 * kCells;
			return vector(x, 0.3 * std::sin(0.5 * x) * std::cos(0.4 * z), z);
		};
		meshes.push_back(std::make_unique<btTriangleMesh>());
		for (int i = 0; i < kCells; ++i)
			for (int j = 0; j < kCells; ++j)
			{
				meshes.back()->addTriangle(place(i, j), place(i, j + 1), place(i + 1, j));
				meshes.back()->addTriangle(place(i + 1, j), place(i, j + 1), place(i + 1, j + 1));
			}
		return put(add(std::make_unique<btBvhTriangleMeshShape>(meshes.back().get(), true)), 0, vector(0, 0, 0));
	}
	btQuaternion anyTurn()
	{
		const Vec3 axis = randomDirection(random);
		return btQuaternion(vector(axis.x, axis.y, axis.z), btScalar(uniform(random, 0, 3)));
	}
	double jitter() { return uniform(random, -0.1, 0.1); }
	void step(int count, double timeStep = 1.0 / 120)
	{
		for (int i = 0; i < count; ++i)
		{
			world.stepSimulation(btScalar(timeStep), 0);
			for (const auto& one : bodies)
				if (!one->isStaticObject()) watch(one->getWorldTransform().getOrigin(), one->getLinearVelocity());
		}
	}
	void watch(const btVector3& place, const btVector3& velocity)
	{
		const double speed = double(velocity.length()), far = double(place.length());
		// What is not finite is farther and faster than all.
		fastest = speed <= fastest ? fastest : std::isfinite(speed) ? speed : 1e30;
		farthest = far <= farthest ? farthest : std::isfinite(far) ? far : 1e30;
		lowest = std::min(lowest, double(place.y()));
	}

private:
	static btVector3 scaled(const Vec3& v, double scale) { return vector(scale * v.x, scale * v.y, scale * v.z); }
};

// What a scene comes to, ours and with Bullet's shapes.
struct Outcome
{
	double fastest = 0, lowest = kFar, farthest = 0, left = 0;  // left: the speed, or what else is told, at the end
	void add(const Stage& stage, double end)
	{
		fastest = std::max(fastest, stage.fastest);
		lowest = std::min(lowest, stage.lowest);
		farthest = std::max(farthest, stage.farthest);
		left = std::max(left, end);
	}
};
template <class Scene>
Outcome play(const char* name, const Scene& scene)
{
	Outcome outcomes[2];
	for (const bool ours : {true, false})
		for (int seed = 0; seed < setting("CLOD_STARTS", 1); ++seed)
		{
			Stage stage(ours, seed);
			const double end = scene(stage);
			outcomes[ours ? 0 : 1].add(stage, end);
		}
	for (const bool ours : {true, false})
	{
		const Outcome& o = outcomes[ours ? 0 : 1];
		std::printf("%s, %s: fastest %.2f, lowest %.3f, farthest %.2f, at the end %.4f\n", name,
					ours ? "ours" : "Bullet's", o.fastest, o.lowest, o.farthest, o.left);
	}
	return outcomes[0];
}
double fastestNow(const Stage& stage)
{
	double most = 0;
	for (const auto& body : stage.bodies) most = std::max(most, double(body->getLinearVelocity().length()));
	return most;
}
}  // namespace

// GImpact's test demo: rings and cups dropped in a heap.
TEST(Worlds, MovingMeshesInAHeap)
{
	const Outcome outcome = play("heap",
								 [](Stage& stage)
								 {
									 stage.floor();
									 btCollisionShape &ring = stage.detailed("torus-900"), &digit = stage.detailed("number8-600");
									 for (int i = 0; i < 6; ++i)
										 stage.put(i % 2 == 0 ? ring : digit, 1,
												   vector(3 * stage.jitter(), 1.2 + 1.4 * i, 3 * stage.jitter()), stage.anyTurn());
									 stage.step(600);
									 return fastestNow(stage);
								 });
	EXPECT_LT(outcome.fastest, 15);  // a fall from the top of the heap
	EXPECT_GT(outcome.lowest, 0.1);
	EXPECT_LT(outcome.farthest, 12);
	EXPECT_LT(outcome.left, 3);  // a ring may still roll
}

// The ray test demo: rays down on bodies that lie on a landscape.
TEST(Worlds, RaysDownOnBodies)
{
	const Outcome outcome = play("rays",
								 [](Stage& stage)
								 {
									 stage.landscape();
									 for (int i = 0; i < 4; ++i)
										 stage.put(stage.detailed(i % 2 == 0 ? "torus-900" : "number8-600"), 1,
												   vector(3 * i - 4 + stage.jitter(), 1.6, stage.jitter()), stage.anyTurn());
									 stage.step(360);
									 int missed = 0;
									 for (int i = 0; i < 400; ++i)
									 {
										 const double x = uniform(stage.random, -6, 6), z = uniform(stage.random, -3, 3);
										 btCollisionWorld::ClosestRayResultCallback ray(vector(x, 10, z), vector(x, -10, z));
										 stage.world.rayTest(ray.m_rayFromWorld, ray.m_rayToWorld, ray);
										 missed += ray.hasHit() ? 0 : 1;
									 }
									 return double(missed);
								 });
	EXPECT_LT(outcome.fastest, 8);
	EXPECT_LT(outcome.farthest, 15);
	EXPECT_EQ(outcome.left, 0);
}

// The concave demo: bodies roll over an open landscape.
TEST(Worlds, ALandscapeOfBulletsCarriesThem)
{
	const Outcome outcome = play("landscape",
								 [](Stage& stage)
								 {
									 stage.landscape();
									 for (int i = 0; i < 5; ++i)
										 stage.put(stage.detailed(i % 2 == 0 ? "sphere-300" : "cup-3000"), 1,
												   vector(2.5 * i - 5 + stage.jitter(), 1.8, stage.jitter()), stage.anyTurn());
									 stage.step(480);
									 return fastestNow(stage);
								 });
	EXPECT_LT(outcome.fastest, 8);
	EXPECT_GT(outcome.lowest, -0.5);
	EXPECT_LT(outcome.farthest, 20);
}

// The vehicle demo: four wheels on a landscape, between bodies that it may hit.
TEST(Worlds, AVehicleDrivesOverALandscape)
{
	const Outcome outcome =
		play("vehicle",
			 [](Stage& stage)
			 {
				 stage.landscape();
				 auto& compound = stage.add(std::make_unique<btCompoundShape>());
				 btTransform raised;
				 raised.setIdentity();
				 raised.setOrigin(vector(0, 0.9, 0));
				 compound.addChildShape(raised, &stage.cubeOf(1.2));
				 btRigidBody& chassis = stage.put(compound, 800, vector(stage.jitter(), 1.5, -8 + stage.jitter()));
				 chassis.setActivationState(DISABLE_DEACTIVATION);
				 for (int i = 0; i < 3; ++i)
					 stage.put(stage.detailed("torus-900"), 20, vector(3 * i - 3, 1.8, 2 + stage.jitter()), stage.anyTurn());
				 btDefaultVehicleRaycaster caster(&stage.world);
				 btRaycastVehicle::btVehicleTuning tuning;
				 btRaycastVehicle vehicle(tuning, &chassis, &caster);
				 vehicle.setCoordinateSystem(0, 1, 2);
				 for (int i = 0; i < 4; ++i)
					 vehicle.addWheel(vector((i & 1) != 0 ? 1 : -1, 0.4, (i & 2) != 0 ? 1.5 : -1.5), vector(0, -1, 0),
									  vector(-1, 0, 0), btScalar(0.6), btScalar(0.5), tuning, (i & 2) != 0);
				 stage.world.addAction(&vehicle);
				 for (int i = 2; i < 4; ++i) vehicle.applyEngineForce(1500, i);
				 stage.step(480);
				 stage.world.removeAction(&vehicle);
				 return fastestNow(stage);
			 });
	EXPECT_LT(outcome.fastest, 20);
	EXPECT_GT(outcome.lowest, -1);
	EXPECT_LT(outcome.farthest, 40);
}

// The multibody demo: a chain falls on a box.
TEST(Worlds, AMultibodyChainFallsOnABox)
{
	const Outcome outcome =
		play("chain",
			 [](Stage& stage)
			 {
				 stage.floor();
				 btCollisionShape& shape = stage.cubeOf(0.4);
				 constexpr int kLinks = 6;
				 btVector3 inertia;
				 shape.calculateLocalInertia(1, inertia);
				 btMultiBody chain(kLinks, 1, inertia, false, false);
				 for (int i = 0; i < kLinks; ++i)
					 chain.setupSpherical(i, 1, inertia, i - 1, btQuaternion::getIdentity(), vector(0.3, 0, 0), vector(0.3, 0, 0),
										  true);
				 chain.finalizeMultiDof();
				 chain.setBasePos(vector(0, 4.5 + stage.jitter(), 0));
				 chain.setWorldToBaseRot(stage.anyTurn());
				 std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
				 for (int i = -1; i < kLinks; ++i)
				 {
					 colliders.push_back(std::make_unique<btMultiBodyLinkCollider>(&chain, i));
					 colliders.back()->setCollisionShape(&shape);
					 stage.world.addCollisionObject(colliders.back().get(), btBroadphaseProxy::DefaultFilter,
													btBroadphaseProxy::StaticFilter | btBroadphaseProxy::DefaultFilter);
					 if (i < 0)
						 chain.setBaseCollider(colliders.back().get());
					 else
						 chain.getLink(i).m_collider = colliders.back().get();
				 }
				 stage.world.addMultiBody(&chain);
				 btAlignedObjectArray<btQuaternion> rotations;
				 btAlignedObjectArray<btVector3> origins;
				 chain.forwardKinematics(rotations, origins);
				 chain.updateCollisionObjectWorldTransforms(rotations, origins);
				 for (int i = 0; i < 600; ++i)
				 {
					 stage.step(1);
					 for (const auto& collider : colliders) stage.watch(collider->getWorldTransform().getOrigin(), chain.getBaseVel());
				 }
				 const double end = double(chain.getBaseVel().length());
				 stage.world.removeMultiBody(&chain);
				 for (const auto& collider : colliders) stage.world.removeCollisionObject(collider.get());
				 return end;
			 });
	EXPECT_LT(outcome.fastest, 12);
	EXPECT_GT(outcome.lowest, 0.18);  // of 0.2; 0.16 with boxes of Bullet's
	EXPECT_LT(outcome.farthest, 12);
	EXPECT_LT(outcome.left, 0.5);
}

// The basic demo: 125 boxes.
TEST(Worlds, FiveByFiveByFiveBoxes)
{
	const Outcome outcome = play("boxes",
								 [](Stage& stage)
								 {
									 stage.floor();
									 btCollisionShape& box = stage.cubeOf(0.2);
									 for (int i = 0; i < 125; ++i)
										 stage.put(box, 1,
												   vector(0.2 * (i % 5) + 0.02 * stage.jitter(), 2 + 0.2 * (i / 25),
														  0.2 * (i / 5 % 5) + 0.02 * stage.jitter()));
									 stage.step(360);
									 return fastestNow(stage);
								 });
	EXPECT_LT(outcome.fastest, 12);
	EXPECT_GT(outcome.lowest, 0.085);  // of 0.1; 0.06 with boxes of Bullet's
	EXPECT_LT(outcome.farthest, 8);
	EXPECT_LT(outcome.left, 0.5);
}
}  // namespace clod::test
