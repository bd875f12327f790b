// SPDX-License-Identifier: GPL-3.0-or-later
// Who answers for which pair of types, in both of Bullet's tables and both orders; what is not asked.
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <gtest/gtest.h>

#include <vector>

#include "clod/bullet/btClodCompoundAlgorithm.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"

namespace clod::test
{
namespace
{
// A shape that is nothing but its type.
struct TypeOnly : btEmptyShape
{
	explicit TypeOnly(int type) { m_shapeType = type; }
};

// Does the dispatcher create our algorithm for this pair of shapes?
bool isOurs(btCollisionDispatcher& dispatcher, const btCollisionShape& first, const btCollisionShape& second,
			ebtDispatcherQueryType table)
{
	btCollisionObject object0, object1;
	object0.setCollisionShape(const_cast<btCollisionShape*>(&first));
	object1.setCollisionShape(const_cast<btCollisionShape*>(&second));
	const btCollisionObjectWrapper wrapper0(nullptr, &first, &object0, object0.getWorldTransform(), -1, -1);
	const btCollisionObjectWrapper wrapper1(nullptr, &second, &object1, object1.getWorldTransform(), -1, -1);
	btCollisionAlgorithm* algorithm = dispatcher.findAlgorithm(&wrapper0, &wrapper1, nullptr, table);
	const bool ours = dynamic_cast<btClodCollisionAlgorithm*>(algorithm) != nullptr;
	algorithm->~btCollisionAlgorithm();
	dispatcher.freeCollisionAlgorithm(algorithm);
	return ours;
}

constexpr int kPartnerTypes[] = {
	BOX_SHAPE_PROXYTYPE,           TRIANGLE_SHAPE_PROXYTYPE,              CONVEX_HULL_SHAPE_PROXYTYPE,
	CUSTOM_POLYHEDRAL_SHAPE_TYPE,  SPHERE_SHAPE_PROXYTYPE,                MULTI_SPHERE_SHAPE_PROXYTYPE,
	CAPSULE_SHAPE_PROXYTYPE,       CONE_SHAPE_PROXYTYPE,                  CYLINDER_SHAPE_PROXYTYPE,
	UNIFORM_SCALING_SHAPE_PROXYTYPE, CUSTOM_CONVEX_SHAPE_TYPE,
	TRIANGLE_MESH_SHAPE_PROXYTYPE, FAST_CONCAVE_MESH_PROXYTYPE,           TERRAIN_SHAPE_PROXYTYPE,
	GIMPACT_SHAPE_PROXYTYPE,       MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE, STATIC_PLANE_PROXYTYPE};
}  // namespace

TEST(Registration, TakesConvexAndConcavePartnersInBothTablesAndOrders)
{
	BulletWorld scene;
	const btClodShape& shape = scene.addShape(patchHierarchy(ballMesh(1, 1)));
	for (const auto table : {BT_CONTACT_POINT_ALGORITHMS, BT_CLOSEST_POINT_ALGORITHMS})
	{
		EXPECT_TRUE(isOurs(scene.dispatcher, shape, shape, table));
		for (const int type : kPartnerTypes)
		{
			const TypeOnly partner(type);
			EXPECT_TRUE(isOurs(scene.dispatcher, shape, partner, table)) << type;
			EXPECT_TRUE(isOurs(scene.dispatcher, partner, shape, table)) << type;
		}
		// A planted fault: a dispatcher without the registration must not pass for one with it.
		btCollisionDispatcher plain(&scene.configuration);
		EXPECT_FALSE(isOurs(plain, shape, shape, table));
	}
}

// Of compounds those that have to do with ours are.
TEST(Registration, LeavesEmptyAndOtherCompoundsToBullet)
{
	BulletWorld scene;
	btClodShape& shape = scene.addShape(patchHierarchy(ballMesh(1, 1)));
	btBoxShape box(btVector3(1, 1, 1));
	const btEmptyShape empty;
	btCompoundShape compound, withOurs, outer;
	compound.addChildShape(btTransform::getIdentity(), &box);
	withOurs.addChildShape(btTransform::getIdentity(), &shape);
	outer.addChildShape(btTransform::getIdentity(), &withOurs);
	const btCollisionObject object;
	const auto isOursOfCompounds = [&](const btCollisionShape& a, const btCollisionShape& b)
	{
		const btCollisionObjectWrapper body0(nullptr, &a, &object, object.getWorldTransform(), -1, -1);
		const btCollisionObjectWrapper body1(nullptr, &b, &object, object.getWorldTransform(), -1, -1);
		btCollisionAlgorithm* found = scene.dispatcher.findAlgorithm(&body0, &body1, nullptr, BT_CONTACT_POINT_ALGORITHMS);
		const bool isOne = dynamic_cast<btClodCompoundAlgorithm*>(found) != nullptr;
		found->~btCollisionAlgorithm();
		scene.dispatcher.freeCollisionAlgorithm(found);
		return isOne;
	};
	const std::initializer_list<const btCollisionShape*> others = {&box, &compound};
	for (const btCollisionShape* other : others)
	{
		EXPECT_FALSE(isOursOfCompounds(compound, *other)) << other->getName();
		EXPECT_FALSE(isOursOfCompounds(*other, compound)) << other->getName();
		EXPECT_TRUE(isOursOfCompounds(withOurs, *other)) << other->getName();
		EXPECT_TRUE(isOursOfCompounds(*other, outer)) << other->getName();
	}
	EXPECT_TRUE(isOursOfCompounds(shape, compound));
	for (const btCollisionShape* partner : std::initializer_list<const btCollisionShape*>{&empty, &compound})
	{
		EXPECT_FALSE(isOurs(scene.dispatcher, shape, *partner, BT_CONTACT_POINT_ALGORITHMS)) << partner->getName();
		EXPECT_FALSE(isOurs(scene.dispatcher, *partner, shape, BT_CLOSEST_POINT_ALGORITHMS)) << partner->getName();
	}
}

TEST(Registration, LeavesTheSoftBodyRowAlone)
{
	btSoftBodyRigidBodyCollisionConfiguration configuration;
	const auto rows = [&]
	{
		std::vector<const btCollisionAlgorithmCreateFunc*> all;
		for (int type = 0; type < MAX_BROADPHASE_COLLISION_TYPES; ++type)
		{
			all.push_back(configuration.getCollisionAlgorithmCreateFunc(SOFTBODY_SHAPE_PROXYTYPE, type));
			all.push_back(configuration.getCollisionAlgorithmCreateFunc(type, SOFTBODY_SHAPE_PROXYTYPE));
			all.push_back(configuration.getClosestPointsAlgorithmCreateFunc(SOFTBODY_SHAPE_PROXYTYPE, type));
			all.push_back(configuration.getClosestPointsAlgorithmCreateFunc(type, SOFTBODY_SHAPE_PROXYTYPE));
		}
		return all;
	};
	const auto before = rows();
	btCollisionDispatcher dispatcher(&configuration);
	Context context;
	const auto registered = btClodCollisionAlgorithm::registerAlgorithm(&dispatcher, &context);
	ASSERT_TRUE(registered);
	EXPECT_EQ(rows(), before);
}

// A cloth falls on a slab, through Bullet's own algorithms.
TEST(Registration, SoftBodiesLieAsOnAMesh)
{
	const auto hierarchy = patchHierarchy(boxMesh({20, 1, 20}, {10, 1, 10}, 2));
	const Bvh theirs(*hierarchy);
	btClodShape ours(hierarchy);
	double height[2];
	for (const bool isOurs : {true, false})
	{
		btSoftBodyRigidBodyCollisionConfiguration configuration;
		btCollisionDispatcher dispatcher(&configuration);
		Context context;
		const auto registered = btClodCollisionAlgorithm::registerAlgorithm(&dispatcher, &context);
		ASSERT_TRUE(registered);
		btDbvtBroadphase broadphase;
		btSequentialImpulseConstraintSolver solver;
		btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
		btRigidBody ground(btRigidBody::btRigidBodyConstructionInfo(
			0, nullptr, isOurs ? static_cast<btCollisionShape*>(&ours) : theirs.shape.get()));
		world.addRigidBody(&ground);
		const auto corner = [](int x, int z) { return btVector3(btScalar(x), btScalar(1.2), btScalar(z)); };
		auto* const cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), corner(-1, -1), corner(1, -1),
														   corner(-1, 1), corner(1, 1), 9, 9, 0, true);
		cloth->getCollisionShape()->setMargin(btScalar(0.05));
		world.addSoftBody(cloth);
		for (int step = 0; step < 240; ++step) world.stepSimulation(btScalar(1.0 / 120), 0);
		double sum = 0;
		for (int i = 0; i < cloth->m_nodes.size(); ++i) sum += double(cloth->m_nodes[i].m_x.y());
		height[isOurs ? 0 : 1] = sum / cloth->m_nodes.size();
		world.removeSoftBody(cloth);
		delete cloth;
		world.removeRigidBody(&ground);
	}
	EXPECT_NEAR(height[0], height[1], 1e-3);
	EXPECT_NEAR(height[0], 0.6, 0.1);  // both keep their margins
}

TEST(Registration, FiltersAreObeyed)
{
	BulletWorld scene;
	btRigidBody& ground = scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	btRigidBody& body = scene.addBody(scene.addShape(cube()), 1, {0, 0.51, 0});
	scene.step(60);
	EXPECT_GT(scene.contacts(), 0);
	body.getBroadphaseProxy()->m_collisionFilterMask = btBroadphaseProxy::AllFilter ^ btBroadphaseProxy::StaticFilter;
	scene.broadphase.getOverlappingPairCache()->cleanProxyFromPairs(body.getBroadphaseProxy(), &scene.dispatcher);
	scene.broadphase.getOverlappingPairCache()->removeOverlappingPairsContainingProxy(body.getBroadphaseProxy(),
																					  &scene.dispatcher);
	scene.step(20);
	EXPECT_EQ(scene.contacts(), 0);
	EXPECT_LT(heightOf(body), 0.5);
	// Nor are two that say so themselves made to meet.
	BulletWorld other;
	btRigidBody& below = other.addBody(other.addShape(slab()), 0, {0, -0.5, 0});
	btRigidBody& above = other.addBody(other.addShape(cube()), 1, {0, 0.51, 0});
	above.setIgnoreCollisionCheck(&below, true);
	other.step(60);
	EXPECT_EQ(other.contacts(), 0);
	EXPECT_LT(heightOf(above), 0.3);
	EXPECT_EQ(heightOf(ground), -0.5);
}

TEST(Registration, RefusesWithAReason)
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	Context context;
	EXPECT_NE(btClodCollisionAlgorithm::registerAlgorithm(nullptr, &context).error(), "");
	EXPECT_NE(btClodCollisionAlgorithm::registerAlgorithm(&dispatcher, nullptr).error(), "");
	// Of the latter types' shapes Bullet asks what no other has, such as their own trees for rays.
	for (const int type : {int(STATIC_PLANE_PROXYTYPE), int(BOX_SHAPE_PROXYTYPE), int(EMPTY_SHAPE_PROXYTYPE), 77,
						   int(TRIANGLE_MESH_SHAPE_PROXYTYPE), int(SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE), int(TERRAIN_SHAPE_PROXYTYPE)})
		EXPECT_FALSE(btClodCollisionAlgorithm::registerAlgorithm(&dispatcher, &context, type)) << type;
}

// Bullet's pool overruns its elements without a word: the object must fit the smallest.
TEST(Registration, TheAlgorithmIsTiny)
{
	EXPECT_LE(sizeof(btClodCollisionAlgorithm), 64u);
}

TEST(Registration, AnotherTypeWorksToo)
{
	BulletWorld scene;
	ASSERT_TRUE(btClodCollisionAlgorithm::registerAlgorithm(&scene.dispatcher, &scene.context,
															MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE));
	auto& shape = scene.add(std::make_unique<btClodShape>(patchHierarchy(boxMesh({1, 1, 1}, {1, 1, 1}, 1)),
														  MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE));
	auto& plane = scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)));
	scene.addBody(plane, 0, {});
	const btRigidBody& body = scene.addBody(shape, 1, {0, 0.6, 0});
	scene.step(240);
	EXPECT_NEAR(heightOf(body), 0.5, 0.01);
}

TEST(Registration, TwoDispatchersInOneProcessDoNotMix)
{
	auto first = std::make_unique<BulletWorld>();
	BulletWorld second;
	for (BulletWorld* scene : {first.get(), &second})
	{
		auto& plane = scene->add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)));
		scene->addBody(plane, 0, {});
		scene->addBody(scene->addShape(patchHierarchy(boxMesh({1, 1, 1}, {1, 1, 1}, 1))), 1, {0, 0.5, 0});
		scene->step(10);
	}
	EXPECT_EQ(first->context.lastStep().pairs, 1u);
	first.reset();  // its pairs and algorithms die while the other lives on
	second.step(100);
	EXPECT_EQ(second.context.lastStep().pairs, 1u);
	EXPECT_NEAR(heightOf(*second.bodies[1]), 0.5, 0.01);
}
}  // namespace clod::test
