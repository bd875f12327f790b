// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies rest where they should, against every kind of partner; queries answer; signs follow Bullet.
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "clod/bullet/ConfigureWorld.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"

namespace clod::test
{
namespace
{
// A cube dropped from 0.1 above a partner whose top is at 0 must lie on it.
void expectRest(BulletWorld& scene, btCollisionShape& falling, double restHeight, double speed = 0.01)
{
	const btRigidBody& body = scene.addBody(falling, 1, {0.013, restHeight + 0.1, 0.027});
	scene.step(360);
	EXPECT_NEAR(heightOf(body), restHeight, 0.005);
	EXPECT_LT(double(body.getLinearVelocity().length()), speed);
	EXPECT_LT(double(body.getAngularVelocity().length()), 2 * speed);
}

std::unique_ptr<btTriangleMesh> floorTriangles(int cells, bool upward)
{
	auto mesh = std::make_unique<btTriangleMesh>();
	const auto corner = [cells](int i, int j)
	{ return btVector3(btScalar(10.0 * i / cells - 5), 0, btScalar(10.0 * j / cells - 5)); };
	for (int i = 0; i < cells; ++i)
		for (int j = 0; j < cells; ++j)
			for (int half = 0; half < 2; ++half)
			{
				const btVector3 a = corner(i + half, j + half), b = corner(i, j + 1), c = corner(i + 1, j);
				const bool swap = (half == 1) == upward;
				mesh->addTriangle(a, swap ? c : b, swap ? b : c);
			}
	return mesh;
}
struct Distances : btCollisionWorld::ContactResultCallback
{
	double least = 1;
	btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
							 const btCollisionObjectWrapper*, int, int) override
	{
		least = std::min(least, double(point.getDistance()));
		return 0;
	}
};
}  // namespace

TEST(Rest, OnAStaticPlane)
{
	BulletWorld scene;
	scene.addBody(scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0))), 0, {});
	expectRest(scene, scene.addShape(cube()), 0.5);
}

TEST(Rest, OnATiltedAndShiftedPlane)
{
	BulletWorld scene;
	const btVector3 normal = btVector3(1, 2, 0).normalized();
	scene.world.setGravity(btScalar(-9.81) * normal);
	auto& plane = scene.add(std::make_unique<btStaticPlaneShape>(normal, btScalar(0.25)));
	scene.addBody(plane, 0, {0, 1, 0});
	const btQuaternion rotation = shortestArcQuat(btVector3(0, 1, 0), normal);
	const btVector3 at = btVector3(0, 1, 0) + normal * btScalar(0.25 + 0.5 + 0.02);
	const btRigidBody& body =
		scene.addBody(scene.addShape(cube()), 1, {double(at.x()), double(at.y()), double(at.z())}, rotation);
	scene.step(240);
	const double height = double((body.getWorldTransform().getOrigin() - btVector3(0, 1, 0)).dot(normal));
	EXPECT_NEAR(height, 0.75, 0.005);
}

TEST(Rest, OnItsOwnKind)
{
	BulletWorld scene;
	scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	expectRest(scene, scene.addShape(cube()), 0.5);
}

TEST(Rest, OnItsOwnKindAtAnotherScale)
{
	BulletWorld scene;
	btClodShape& ground = scene.addShape(patchHierarchy(boxMesh({1, 0.1, 1}, {8, 1, 8}, 2)));
	ground.setLocalScaling(btVector3(10, 10, 10));
	scene.addBody(ground, 0, {0, -0.5, 0});
	expectRest(scene, scene.addShape(cube()), 0.5);
}

TEST(Rest, OnATriangleMeshOfEitherWinding)
{
	for (const bool upward : {true, false})
	{
		BulletWorld scene;
		const auto mesh = floorTriangles(20, upward);
		auto& ground = scene.add(std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true));
		scene.addBody(ground, 0, {});
		expectRest(scene, scene.addShape(cube()), 0.5);
	}
}

// Bodies made a little, or much, too low: upright, where each point over a corner lies on a wall of theirs, and aslant.
TEST(Rest, OutOfTheTriangleMeshTheyWereMadeIn)
{
	for (const double depth : {0.001, 0.02, 0.1, 0.3, 0.45})
		for (const double tilt : {0.0, 0.02})
			for (const int cells : {1, 40})
			{
				BulletWorld scene;
				const auto triangles = floorTriangles(cells, true);
				auto& mesh = scene.add(std::make_unique<btBvhTriangleMeshShape>(triangles.get(), true));
				btRigidBody& ground = scene.addBody(mesh, 0, {});
				btRigidBody& body = scene.addBody(scene.addShape(cube()), 1, {0.013, 0.5 - depth, 0.027},
												  btQuaternion(btVector3(1, 0, 0), btScalar(tilt)));
				const auto where = ::testing::Message() << depth << " deep, tilt " << tilt << ", " << cells << " cells";
				Distances found;
				scene.world.contactPairTest(&ground, &body, found);
				EXPECT_NEAR(found.least, -depth, 0.02) << where;
				EXPECT_LT(found.least, 0) << where;
				scene.step(480);
				EXPECT_NEAR(heightOf(body), 0.5, 0.005) << where;
			}
}

// Of thin walls no facet tells how deep they are, and of what is half in some tell the other way. Many cells: more pairs than
// are looked at one after the other on one side.
TEST(Rest, ThinWallsComeOutOfTheTriangleMeshTheyWereMadeIn)
{
	const auto plate = [](const Vec3& size, const std::array<int, 3>& n) { return singleTriangles(boxMesh(size, n, 1)); };
	const PatchedMesh walls = merged(plate({1, 1, 0.03}, {6, 6, 1}), plate({1, 1, 0.03}, {6, 6, 1}), {0, 0, 0.5});
	const auto hierarchy = patchHierarchy(walls);
	for (const double depth : {0.1, 0.3, 0.52})
		for (const double tilt : {0.0, 0.02})
			for (const int cells : {1, 40})
			{
				BulletWorld scene;
				const auto triangles = floorTriangles(cells, true);
				scene.addBody(scene.add(std::make_unique<btBvhTriangleMeshShape>(triangles.get(), true)), 0, {});
				btRigidBody& body = scene.addBody(scene.addShape(hierarchy), 1, {0.013, 0.5 - depth, 0.027},
												  btQuaternion(btVector3(1, 0, 0), btScalar(tilt)));
				double fastest = 0;
				for (int i = 0; i < 480; ++i)
				{
					scene.step();
					fastest = std::max(fastest, double(body.getLinearVelocity().length()));
				}
				const auto where = ::testing::Message() << depth << " deep, tilt " << tilt << ", " << cells << " cells";
				EXPECT_NEAR(heightOf(body), 0.5, 0.01) << where;
				EXPECT_LT(fastest, 2.5) << where;
			}
}

// A bar's edge across a ridge: neither has a corner in the other, and the bar's upper edges lie under the triangles' other sides.
TEST(ContactPairTest, EdgesSunkInARidgeOfTrianglesAreAsDeepAsTheyAre)
{
	btTriangleMesh triangles;
	for (const btScalar side : {btScalar(-1), btScalar(1)})
	{
		const btVector3 low(side * 5, -1, side * 5), along(side * 5, -1, side * -5);
		triangles.addTriangle(btVector3(0, 0, -5), btVector3(0, 0, 5), low);
		triangles.addTriangle(btVector3(0, 0, side * -5), low, along);
	}
	for (const double depth : {0.0005, 0.005, 0.02})
		for (const double turn : {0.0, 0.3, 0.7})
		{
			BulletWorld scene;
			auto& mesh = scene.add(std::make_unique<btBvhTriangleMeshShape>(&triangles, true));
			btRigidBody& ground = scene.addBody(mesh, 0, {});
			btClodShape& bar = scene.addShape(cube());
			bar.setLocalScaling(btVector3(2, btScalar(0.2), btScalar(0.2)));
			const btQuaternion onEdge(btVector3(1, 0, 0), btScalar(M_PI / 4)), about(btVector3(0, 1, 0), btScalar(turn));
			btRigidBody& body = scene.addBody(bar, 1, {0, 0.1 * std::sqrt(2.0) - depth, 0.4}, about * onEdge);
			Distances found;
			scene.world.contactPairTest(&ground, &body, found);
			EXPECT_NEAR(found.least, -depth, 1e-4) << depth << " deep, turned by " << turn;
			scene.step(240);
			EXPECT_GT(heightOf(body), 0.13) << depth << " deep, turned by " << turn;
		}
}

TEST(Rest, OnAScaledTriangleMesh)
{
	BulletWorld scene;
	const auto mesh = floorTriangles(10, true);
	auto& ground = scene.add(std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true));
	auto& scaled = scene.add(std::make_unique<btScaledBvhTriangleMeshShape>(&ground, btVector3(2, 1, 2)));
	scene.addBody(scaled, 0, {});
	expectRest(scene, scene.addShape(cube()), 0.5);
}

TEST(Rest, OnAHeightfield)
{
	BulletWorld scene;
	const std::vector<btScalar> heights(16 * 16, 0);  // this constructor reads scalars
	auto& ground = scene.add(std::make_unique<btHeightfieldTerrainShape>(
		16, 16, heights.data(), btScalar(1), btScalar(-1), btScalar(1), 1, PHY_FLOAT, false));
	scene.addBody(ground, 0, {});
	expectRest(scene, scene.addShape(cube()), 0.5);
}

TEST(Rest, InsideACompound)
{
	for (const bool ownKind : {true, false})
	{
		BulletWorld scene;
		if (ownKind)
			scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
		else
			scene.addBody(scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0))), 0, {});
		btClodShape& child = scene.addShape(cube());
		auto& compound = scene.add(std::make_unique<btCompoundShape>());
		for (const double x : {-1.0, 1.0})
			compound.addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(x), btScalar(0.25), 0)),
								   &child);
		expectRest(scene, compound, 0.25);
	}
}

TEST(Rest, BulletsConvexShapesOnOurs)
{
	BulletWorld scene;
	scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	auto& box = scene.add(std::make_unique<btBoxShape>(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5))));
	expectRest(scene, box, 0.5, 0.1);  // Bullet's own triangle path jitters more
}

TEST(Rest, OursOnBulletsConvexShapes)
{
	BulletWorld scene;
	auto& box = scene.add(std::make_unique<btBoxShape>(btVector3(5, btScalar(0.5), 5)));
	scene.addBody(box, 0, {0, -0.5, 0});
	expectRest(scene, scene.addShape(cube()), 0.5);
}

// Its lower corners and edges lie on the slab, between whose walls, as deep as it is wide, they are, too.
TEST(Rest, AMovingTriangleMeshOnOurs)
{
	const PatchedMesh box = boxMesh({1, 1, 1}, {1, 1, 1}, 1);
	btTriangleMesh triangles;
	const auto corner = [&](std::uint32_t v)
	{
		const Vec3& p = box.vertices[v];
		return btVector3(btScalar(p.x), btScalar(p.y), btScalar(p.z));
	};
	for (const auto& t : box.triangles) triangles.addTriangle(corner(t[0]), corner(t[1]), corner(t[2]));
	for (int i = 0; i < 8; ++i)
	{
		BulletWorld scene;
		configureWorld(scene.world);
		scene.addBody(scene.addShape(patchHierarchy(boxMesh({8, 2, 8}, {1, 1, 1}, 1))), 0, {0, -1, 0});
		auto& mesh = scene.add(std::make_unique<btGImpactMeshShape>(&triangles));
		mesh.updateBound();
		const btRigidBody& body = scene.addBody(mesh, 1, {0.03, 0.51 + 0.06 * i, 0.02});
		scene.step(480);
		EXPECT_NEAR(heightOf(body), 0.5, 0.005) << i;
		EXPECT_LT(double(body.getLinearVelocity().length()), 0.01) << i;
	}
}

TEST(Rest, AtAHundredTimesTheUnit)
{
	BulletWorld scene;
	scene.world.setGravity(btVector3(0, btScalar(-981), 0));
	btClodShape& ground = scene.addShape(patchHierarchy(boxMesh({0.1, 0.01, 0.1}, {20, 1, 20}, 2)));
	btClodShape& small = scene.addShape(patchHierarchy(boxMesh({0.01, 0.01, 0.01}, {2, 2, 2}, 1)));
	for (btClodShape* shape : {&ground, &small}) shape->setLocalScaling(btVector3(100, 100, 100));
	scene.addBody(ground, 0, {0, -0.5, 0});
	expectRest(scene, small, 0.5);
}

TEST(Rest, MarginsKeepBodiesApart)
{
	BulletWorld scene;
	btClodShape& ground = scene.addShape(slab());
	btClodShape& falling = scene.addShape(cube());
	ground.setMargin(btScalar(0.05));
	falling.setMargin(btScalar(0.02));
	scene.addBody(ground, 0, {0, -0.5, 0});
	expectRest(scene, falling, 0.57);
}

namespace
{
struct Collected : btCollisionWorld::ContactResultCallback
{
	std::vector<btManifoldPoint> points;
	std::vector<bool> firstIsBody;
	const btCollisionObject* body = nullptr;
	btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* wrapper0, int, int,
							 const btCollisionObjectWrapper*, int, int) override
	{
		points.push_back(point);
		firstIsBody.push_back(wrapper0->getCollisionObject() == body);
		return 0;
	}
};
}  // namespace

TEST(ContactPairTest, FindsPointsOfItsOwnKindAndOfAPlane)
{
	for (const bool ownKind : {true, false})
	{
		BulletWorld scene;
		btRigidBody& ground =
			ownKind ? scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0})
					: scene.addBody(scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0))), 0,
									{});
		btRigidBody& body = scene.addBody(scene.addShape(cube()), 1, {0, 0.49, 0});
		Collected touching;
		scene.world.contactPairTest(&body, &ground, touching);
		EXPECT_GE(touching.points.size(), 4u);
		for (const btManifoldPoint& point : touching.points) EXPECT_NEAR(double(point.getDistance()), -0.01, 1e-4);

		body.getWorldTransform().setOrigin(btVector3(0, btScalar(1.5), 0));
		Collected apart, within;
		scene.world.contactPairTest(&body, &ground, apart);
		EXPECT_TRUE(apart.points.empty());
		within.m_closestDistanceThreshold = 2;
		scene.world.contactPairTest(&body, &ground, within);
		ASSERT_GE(within.points.size(), 4u);
		for (const btManifoldPoint& point : within.points) EXPECT_NEAR(double(point.getDistance()), 1, 1e-4);
		EXPECT_EQ(scene.dispatcher.getNumManifolds(), 0);
	}
}

// Where the bodies are, that is, and not where a step would bring them; and no pair of the world's counts it.
TEST(ContactPairTest, TellsOfCompoundsAsOfTheirChildren)
{
	for (const double gap : {0.0002, -0.01})
		for (const bool isFirst : {true, false})
		{
			BulletWorld scene;
			scene.world.getDispatchInfo().m_timeStep = btScalar(1.0 / 60);
			btClodShape& child = scene.addShape(cube());
			auto& compound = scene.add(std::make_unique<btCompoundShape>());
			compound.addChildShape(btTransform::getIdentity(), &child);
			auto& withBox = scene.add(std::make_unique<btCompoundShape>());
			const btVector3 half(btScalar(0.5), btScalar(0.5), btScalar(0.5));
			withBox.addChildShape(btTransform::getIdentity(), &scene.add(std::make_unique<btBoxShape>(half)));
			btRigidBody& body = scene.addBody(compound, 1, {0, 0, 0});
			body.setLinearVelocity(btVector3(50, 0, 0));
			body.setInterpolationLinearVelocity(btVector3(50, 0, 0));
			body.setInterpolationWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(1, 0, 0)));
			for (btCollisionShape* other : std::initializer_list<btCollisionShape*>{&child, &compound, &withBox})
			{
				btRigidBody& second = scene.addBody(*other, 1, {1 + gap, 0.1, 0.2});
				Collected found;
				scene.world.contactPairTest(isFirst ? &body : &second, isFirst ? &second : &body, found);
				EXPECT_GE(found.points.size(), 4u);
				for (const btManifoldPoint& point : found.points) EXPECT_NEAR(double(point.getDistance()), gap, 1e-6);
				scene.world.removeRigidBody(&second);
			}
			EXPECT_EQ(scene.dispatcher.getNumManifolds(), 0);
			EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
		}
}

TEST(ContactPairTest, SwappedBodiesNegateTheNormalAndKeepTheDistance)
{
	BulletWorld scene;
	btRigidBody& ground = scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	btRigidBody& body = scene.addBody(scene.addShape(cube()), 1, {0.1, 0.49, 0.2});
	Collected forward, backward;
	forward.body = backward.body = &body;
	scene.world.contactPairTest(&body, &ground, forward);
	scene.world.contactPairTest(&ground, &body, backward);
	ASSERT_EQ(forward.points.size(), backward.points.size());
	ASSERT_FALSE(forward.points.empty());
	for (std::size_t i = 0; i < forward.points.size(); ++i)
	{
		// Bullet: the normal points to body 0 of the result.
		EXPECT_TRUE(forward.firstIsBody[i]);
		EXPECT_FALSE(backward.firstIsBody[i]);
		EXPECT_NEAR(double(forward.points[i].m_normalWorldOnB.y()), 1, 1e-5);
		EXPECT_NEAR(double(backward.points[i].m_normalWorldOnB.y()), -1, 1e-5);
		EXPECT_NEAR(double(forward.points[i].getDistance()), double(backward.points[i].getDistance()), 1e-6);
		const btVector3 onB = forward.points[i].getPositionWorldOnB(), onA = backward.points[i].getPositionWorldOnA();
		EXPECT_LT(double((onB - onA).length()), 1e-5);
		EXPECT_NEAR(double(onB.y()), 0, 1e-5);
	}
}

TEST(ContactTest, FindsEveryPartner)
{
	BulletWorld scene;
	scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	btRigidBody& body = scene.addBody(scene.addShape(cube()), 1, {0.1, 0.495, 0.2});
	Collected all;
	scene.world.contactTest(&body, all);
	EXPECT_GE(all.points.size(), 4u);
}

TEST(RayTest, HitsOursAloneAndInACompound)
{
	BulletWorld scene;
	btClodShape& child = scene.addShape(cube());
	auto& compound = scene.add(std::make_unique<btCompoundShape>());
	compound.addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(3, 0, 0)), &child);
	scene.addBody(child, 0, {});
	scene.addBody(compound, 0, {});
	scene.world.updateAabbs();
	for (const btScalar x : {btScalar(0.1), btScalar(3.1)})
	{
		const btVector3 from(x, 5, btScalar(0.1)), to(x, -5, btScalar(0.1));
		btCollisionWorld::ClosestRayResultCallback hit(from, to);
		scene.world.rayTest(from, to, hit);
		ASSERT_TRUE(hit.hasHit());
		EXPECT_NEAR(double(hit.m_hitPointWorld.y()), 0.5, 1e-4);
	}
}

TEST(SweepTest, AConvexShapeMeetsOurs)
{
	BulletWorld scene;
	scene.addBody(scene.addShape(cube()), 0, {});
	scene.world.updateAabbs();
	const btSphereShape ball(btScalar(0.25));
	const btTransform from(btQuaternion::getIdentity(), btVector3(0, 3, 0)),
		to(btQuaternion::getIdentity(), btVector3(0, -3, 0));
	btCollisionWorld::ClosestConvexResultCallback hit(from.getOrigin(), to.getOrigin());
	scene.world.convexSweepTest(&ball, from, to, hit);
	ASSERT_TRUE(hit.hasHit());
	EXPECT_NEAR(double(hit.m_hitPointWorld.y()), 0.5, 0.01);
}

// A box that turns on its way meets first what it meets of all triangles, each cast alone: Bullet asks for those in a box of
// its last pose, and its own mesh passes over others.
TEST(SweepTest, ATurningBoxMeetsWhatItMeetsOfAllTriangles)
{
	struct Whole : btTriangleMeshShape
	{
		explicit Whole(btStridingMeshInterface& mesh) : btTriangleMeshShape(&mesh) { m_shapeType = CUSTOM_CONCAVE_SHAPE_TYPE; }
		void processAllTriangles(btTriangleCallback* callback, const btVector3&, const btVector3&) const override
		{
			const btVector3 far(btScalar(1e3), btScalar(1e3), btScalar(1e3));
			btTriangleMeshShape::processAllTriangles(callback, -far, far);
		}
	};
	struct ToMesh : btTriangleCallback
	{
		btTriangleMesh mesh;
		void processTriangle(btVector3* corners, int, int) override { mesh.addTriangle(corners[0], corners[1], corners[2]); }
	} all;
	const btClodShape ours(patchHierarchy(ballMesh(1, 2)));
	const btVector3 far(btScalar(1e3), btScalar(1e3), btScalar(1e3));
	ours.processAllTriangles(&all, -far, far);
	Whole whole(all.mesh);
	const btBoxShape box(btVector3(btScalar(0.1), btScalar(0.05), btScalar(0.6)));
	std::mt19937 random(5);
	const auto direction = [&random]
	{
		const auto number = [&random] { return btScalar(random()) / btScalar(std::mt19937::max()) - btScalar(0.5); };
		const btScalar x = number(), y = number();
		return btVector3(x, y, number()).normalized();
	};
	int hits = 0;
	for (int round = 0; round < 150; ++round)
	{
		const btQuaternion before(direction(), 2), after(direction(), 2);
		const btTransform from(before, 2 * direction());
		const btTransform to(after, btScalar(1.8) * direction());
		double share[2] = {};
		for (const bool isOurs : {true, false})
		{
			BulletWorld scene;
			btCollisionObject object;
			object.setCollisionShape(isOurs ? const_cast<btClodShape*>(&ours) : static_cast<btCollisionShape*>(&whole));
			scene.world.addCollisionObject(&object);
			btCollisionWorld::ClosestConvexResultCallback hit(from.getOrigin(), to.getOrigin());
			scene.world.convexSweepTest(&box, from, to, hit);
			share[isOurs] = double(hit.m_closestHitFraction);
			scene.world.removeCollisionObject(&object);
		}
		EXPECT_EQ(share[true], share[false]) << round;
		hits += share[false] < 1;
	}
	EXPECT_GT(hits, 45);
	EXPECT_LT(hits, 145);
}
}  // namespace clod::test
