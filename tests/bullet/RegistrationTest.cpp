// SPDX-License-Identifier: GPL-3.0-or-later
// Who answers for which pair of types, in both of Bullet's tables and both orders.
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <gtest/gtest.h>

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
	btCollisionDispatcher dispatcher(&configuration);
	Context context;
	ASSERT_TRUE(btClodCollisionAlgorithm::registerAlgorithm(&dispatcher, &context));
	const btClodShape shape(patchHierarchy(ballMesh(1, 1)));
	const TypeOnly soft(SOFTBODY_SHAPE_PROXYTYPE);
	EXPECT_NE(configuration.getCollisionAlgorithmCreateFunc(SOFTBODY_SHAPE_PROXYTYPE, FAST_CONCAVE_MESH_PROXYTYPE),
			  configuration.getCollisionAlgorithmCreateFunc(EMPTY_SHAPE_PROXYTYPE, EMPTY_SHAPE_PROXYTYPE));
	// Creating Bullet's soft algorithm needs a soft body; that ours is not created is the point.
	EXPECT_EQ(shape.getShapeType(), FAST_CONCAVE_MESH_PROXYTYPE);
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
