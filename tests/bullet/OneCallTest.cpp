// SPDX-License-Identifier: GPL-3.0-or-later
// A world and bodies by one call each, and what is said where something is missing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "clod/bullet/ConfigureWorld.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
struct PlainWorld
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	Context context;
	btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
};

class CountingSolver : public btSequentialImpulseConstraintSolver
{
public:
	int iterations = 0;

protected:
	btScalar solveSingleIteration(int iteration, btCollisionObject** bodies, int numBodies,
								  btPersistentManifold** manifolds, int numManifolds, btTypedConstraint** constraints,
								  int numConstraints, const btContactSolverInfo& info, btIDebugDraw* debug) override
	{
		++iterations;
		return btSequentialImpulseConstraintSolver::solveSingleIteration(
			iteration, bodies, numBodies, manifolds, numManifolds, constraints, numConstraints, info, debug);
	}
};
}  // namespace

TEST(OneCall, AFileFallsAndRests)
{
	const std::filesystem::path path = std::filesystem::temp_directory_path() / "clod-one-call.clod";
	const auto hierarchy = cube();
	const std::vector<std::byte>& bytes = hierarchy->bytes();
	std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
	PlainWorld scene;
	ASSERT_TRUE(setUpWorld(scene.world, scene.context));
	scene.world.setGravity(btVector3(0, btScalar(-9.81), 0));
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btRigidBody ground(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &plane));
	scene.world.addRigidBody(&ground);
	BodySettings settings;
	settings.mass = 2;
	settings.scale = btVector3(1, 2, 1);
	settings.worldFromMesh.setOrigin(btVector3(0, btScalar(1.1), 0));
	const auto made = ClodBody::load(path.string(), settings);
	std::filesystem::remove(path);
	ASSERT_TRUE(made) << made.error();
	ClodBody& body = *made.value();
	EXPECT_NEAR(double(body.worldFromMesh().getOrigin().y()), 1.1, 1e-5);
	EXPECT_EQ(body.shape().name(), path.string());
	scene.world.addRigidBody(&body.body());
	for (int i = 0; i < 480; ++i) scene.world.stepSimulation(btScalar(1.0 / 240), 0);
	EXPECT_NEAR(double(body.body().getWorldTransform().getOrigin().y()), 1, 2e-3);
	scene.world.removeRigidBody(&body.body());
	scene.world.removeRigidBody(&ground);
}

TEST(OneCall, TheWorldHasTheSettingsAsked)
{
	PlainWorld scene;
	WorldSettings settings;
	settings.solverIterations = 17;
	settings.erp = 0.3;
	settings.erp2 = 0.7;
	settings.splitImpulsePenetrationThreshold = -0.25;
	settings.warmstartingFactor = 0.5;
	ASSERT_TRUE(setUpWorld(scene.world, scene.context, settings));
	const btContactSolverInfo& solver = scene.world.getSolverInfo();
	EXPECT_EQ(solver.m_numIterations, 17);
	EXPECT_TRUE(solver.m_splitImpulse);
	EXPECT_NE(solver.m_solverMode & SOLVER_USE_2_FRICTION_DIRECTIONS, 0);
	EXPECT_EQ(solver.m_splitImpulsePenetrationThreshold, btScalar(-0.25));
	EXPECT_EQ(solver.m_warmstartingFactor, btScalar(0.5));
	EXPECT_EQ(solver.m_erp, btScalar(0.3));
	EXPECT_EQ(solver.m_erp2, btScalar(0.7));
	EXPECT_EQ(scene.context.closedShare, 0.5);
	// Of gravity, as it is in 1/240 s; rows' speeds are squared in Bullet.
	for (const double share : {0.0, 0.012})
	{
		settings.leastChange = share;
		scene.world.setGravity(btVector3(12, 16, 0));
		configureWorld(scene.world, settings);
		EXPECT_NEAR(double(solver.m_leastSquaresResidualThreshold), share * share / 144, 1e-12);
	}
}

// Of two cubes, one on the other: fewer passes at rest than where every change counts, and at a higher share still fewer.
TEST(OneCall, TheSolverEndsWhereNothingChanges)
{
	constexpr int kSteps = 240, kCounted = 120;
	int last = kCounted * WorldSettings().solverIterations + 1;
	for (const double share : {0.0, WorldSettings().leastChange, 10 * WorldSettings().leastChange})
	{
		PlainWorld scene;
		CountingSolver solver;
		scene.world.setConstraintSolver(&solver);
		scene.world.setGravity(btVector3(0, btScalar(-9.81), 0));
		WorldSettings world;
		world.leastChange = share;
		ASSERT_TRUE(setUpWorld(scene.world, scene.context, world));
		btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
		btRigidBody ground(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &plane));
		scene.world.addRigidBody(&ground);
		std::vector<std::unique_ptr<ClodBody>> cubes;
		for (int i = 0; i < 2; ++i)
		{
			BodySettings settings;
			settings.mass = 1;
			settings.worldFromMesh.setOrigin(btVector3(0, btScalar(0.52 + 1.02 * i), 0));
			auto made = ClodBody::make(cube(), settings);
			ASSERT_TRUE(made) << made.error();
			cubes.push_back(std::move(made.value()));
			cubes.back()->body().setActivationState(DISABLE_DEACTIVATION);
			scene.world.addRigidBody(&cubes.back()->body());
		}
		for (int i = 0; i < kSteps; ++i)
		{
			if (i == kSteps - kCounted) solver.iterations = 0;
			scene.world.stepSimulation(btScalar(1.0 / 240), 0);
		}
		EXPECT_GT(solver.iterations, 0);
		EXPECT_LT(solver.iterations, last) << share;
		last = solver.iterations;
		for (const auto& cube : cubes) scene.world.removeRigidBody(&cube->body());
		scene.world.removeRigidBody(&ground);
	}
}

// Turned by 30 degrees its products of inertia are not zero: the body's frame is the principal one, its mesh where it was.
TEST(OneCall, SkewBodiesAreGivenTheirPrincipalAxes)
{
	PatchedMesh mesh = boxMesh({4, 1, 2}, {1, 1, 1}, 1);
	const double c = std::cos(0.5), s = std::sin(0.5);
	for (Vec3& v : mesh.vertices) v = {c * v.x - s * v.y + 1, s * v.x + c * v.y + 2, v.z + 3};
	// patchHierarchy gives no principal axes; ask for those of the same body mirrored in nothing.
	BodySettings settings;
	settings.mass = 12;
	settings.scale = btVector3(1, 1, -1);
	settings.worldFromMesh.setOrigin(btVector3(7, 8, 9));
	const auto made = ClodBody::make(patchHierarchy(mesh), settings);
	ASSERT_TRUE(made) << made.error();
	ClodBody& body = *made.value();
	EXPECT_NE(body.body().getCollisionShape(), &body.shape());
	btVector3 moments = body.body().getInvInertiaDiagLocal();
	double sorted[3] = {1 / double(moments.x()), 1 / double(moments.y()), 1 / double(moments.z())};
	std::sort(sorted, sorted + 3);
	EXPECT_NEAR(sorted[0], 1 + 4, 1e-3);
	EXPECT_NEAR(sorted[1], 16 + 1, 1e-3);
	EXPECT_NEAR(sorted[2], 16 + 4, 1e-3);
	EXPECT_LT(double((body.worldFromMesh().getOrigin() - btVector3(7, 8, 9)).length()), 1e-4);
	// The mesh is where it was put: over the middle of the box its upper face is half its thickness higher, along the slope.
	PlainWorld scene;
	ASSERT_TRUE(setUpWorld(scene.world, scene.context));
	scene.world.addRigidBody(&body.body());
	btCollisionWorld::ClosestRayResultCallback ray(btVector3(8, 20, 6), btVector3(8, 0, 6));
	scene.world.rayTest(ray.m_rayFromWorld, ray.m_rayToWorld, ray);
	ASSERT_TRUE(ray.hasHit());
	EXPECT_NEAR(double(ray.m_hitPointWorld.y()), 10 + 0.5 / c, 1e-3);
	scene.world.removeRigidBody(&body.body());
}

TEST(OneCall, RefusesWithAReason)
{
	EXPECT_NE(ClodBody::load("nowhere.clod").error().find("nowhere.clod"), std::string::npos);
	BodySettings settings;
	settings.mass = -1;
	EXPECT_NE(ClodBody::make(cube(), settings).error().find("mass"), std::string::npos);
	settings.mass = 1;
	settings.scale = btVector3(1, 0, 1);
	EXPECT_NE(ClodBody::make(cube(), settings).error().find("scale"), std::string::npos);
	EXPECT_FALSE(ClodBody::make(nullptr));

	const auto errorOf = [](const auto& change)
	{
		BodySettings odd;
		odd.mass = 1;
		change(odd);
		const auto made = ClodBody::make(cube(), odd);
		return made ? std::string() : made.error();
	};
	EXPECT_EQ(errorOf([](BodySettings& odd) { odd.worldFromMesh.setRotation(btQuaternion(1, 2, 3)); }), "");
	for (const double number : {-1.0, std::nan(""), HUGE_VAL})
	{
		EXPECT_NE(errorOf([=](BodySettings& odd) { odd.mass = number; }).find("mass"), std::string::npos) << number;
		EXPECT_NE(errorOf([=](BodySettings& odd) { odd.friction = number; }).find("friction"), std::string::npos) << number;
		EXPECT_NE(errorOf([=](BodySettings& odd) { odd.restitution = number; }).find("restitution"), std::string::npos)
			<< number;
	}
	const auto pose = [&](const btMatrix3x3& basis, double x)
	{
		return errorOf([&](BodySettings& odd) { odd.worldFromMesh = btTransform(basis, btVector3(btScalar(x), 0, 0)); });
	};
	const btMatrix3x3 unit = btMatrix3x3::getIdentity();
	EXPECT_EQ(pose(unit, 1), "");
	for (const double x : {std::nan(""), -HUGE_VAL}) EXPECT_NE(pose(unit, x).find("worldFromMesh"), std::string::npos) << x;
	for (const btVector3& scale : {btVector3(0, 0, 0), btVector3(2, 2, 2), btVector3(1, 1, -1)})
		EXPECT_NE(pose(unit.scaled(scale), 0).find("worldFromMesh"), std::string::npos);
}

// A box under a name: other importers keep the body, those that know the name load the file.
TEST(Serialized, AsABoxWhoseNameLeadsBack)
{
	BulletWorld scene;
	btClodShape& shape = scene.addShape(cube());
	shape.setName("dir/a cube: of mine.clod");
	shape.setLocalScaling(btVector3(btScalar(-1.5), 2, 3));
	scene.addBody(shape, 1, {});
	btDefaultSerializer serializer;
	scene.world.serialize(&serializer);
	const std::string bytes(reinterpret_cast<const char*>(serializer.getBufferPointer()),
							std::size_t(serializer.getCurrentBufferSize()));
	const std::size_t at = bytes.find("clod:");
	ASSERT_NE(at, std::string::npos);
	const auto read = btClodShape::readSerializedName(bytes.c_str() + at);
	ASSERT_TRUE(read);
	EXPECT_EQ(read->contentHash, cube()->contentHash());
	EXPECT_EQ(read->name, shape.name());
	EXPECT_LT(double((read->scaling - shape.getLocalScaling()).length()), 1e-6);
	btConvexInternalShapeData data;
	btDefaultSerializer alone;
	alone.startSerialization();
	EXPECT_STREQ(shape.serialize(&data, &alone), "btConvexInternalShapeData");
	alone.finishSerialization();
	EXPECT_EQ(int(sizeof data), shape.calculateSerializeBufferSize());
	EXPECT_EQ(data.m_collisionShapeData.m_shapeType, int(BOX_SHAPE_PROXYTYPE));
	EXPECT_NEAR(double(data.m_implicitShapeDimensions.m_floats[1]), 1, 1e-3);
	for (const char* other : {"", "box", "clod:", "clod:12:1:2:x", "clod:zz:1:2:3:x"})
		EXPECT_FALSE(btClodShape::readSerializedName(other)) << other;
	EXPECT_FALSE(btClodShape::readSerializedName(nullptr));
}

TEST(Messages, NameBodiesAndFilesAndEnd)
{
	BulletWorld scene;
	btClodShape& ground = scene.addShape(slab());
	ground.setName("slab.clod");
	scene.addBody(ground, 0, {0, -0.5, 0});
	btClodShape& shape = scene.addShape(cube());
	shape.setLocalScaling(btVector3(0, 1, 1));
	for (int i = 0; i < 15; ++i)
	{
		btRigidBody& body = scene.addBody(shape, 1, {0, 0.5 + 3 * i, 0});
		body.setUserIndex(100 + i);
		body.getWorldTransform().setOrigin(btVector3(btScalar(i % 4 * 1.5 - 2), btScalar(0.5), btScalar(i / 4 * 1.5 - 2)));
	}
	scene.step(2);
	ASSERT_EQ(int(scene.warnings.size()), Context::kMostMessages);
	EXPECT_NE(scene.warnings[0].find("slab.clod"), std::string::npos) << scene.warnings[0];
	EXPECT_NE(scene.warnings[0].find("user index 1"), std::string::npos) << scene.warnings[0];
	EXPECT_NE(scene.warnings.back().find("further"), std::string::npos) << scene.warnings.back();
}

// In a process of its own: registration is process-wide.
TEST(Messages, AForgottenRegistrationIsToldOf)
{
	const auto forget = []
	{
		PlainWorld scene;
		btClodShape shape(cube());
		btRigidBody a(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &shape));
		scene.world.addRigidBody(&a);
		for (int i = 0; i < 2000; ++i) scene.world.updateAabbs();
		scene.world.removeRigidBody(&a);
		std::exit(0);
	};
	GTEST_FLAG_SET(death_test_style, "threadsafe");
	EXPECT_EXIT(forget(), testing::ExitedWithCode(0), "no dispatcher was registered");
}

// And what is left of its pairs may go after it.
TEST(Context, SaysWhenItsWorldOutlivesIt)
{
	const auto forget = [](bool isFirst)
	{
		auto context = std::make_unique<Context>();
		PlainWorld scene;
		(void)btClodCollisionAlgorithm::registerAlgorithm(&scene.dispatcher, context.get());
		btClodShape shape(cube());
		btRigidBody a(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &shape)),
			b(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape));
		for (btRigidBody* body : {&a, &b}) scene.world.addRigidBody(body);
		scene.world.stepSimulation(btScalar(0.01), 0);
		const auto removeAll = [&]
		{
			for (btRigidBody* body : {&a, &b}) scene.world.removeRigidBody(body);
		};
		if (!isFirst) removeAll();
		context.reset();
		if (isFirst) removeAll();
		std::exit(0);
	};
	GTEST_FLAG_SET(death_test_style, "threadsafe");
	EXPECT_EXIT(forget(true), testing::ExitedWithCode(0), "has to outlive the world");
	EXPECT_EXIT(forget(false), testing::ExitedWithCode(0), "^$");
}
}  // namespace clod::test
