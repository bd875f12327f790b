// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies of any scale: they rest, roll and answer as those that were made at that size.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include <BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>

#include "clod/bullet/ConvexPartner.h"
#include "clod/hierarchy/ScaledHierarchy.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
btVector3 vector(double x, double y, double z)
{
	return btVector3(btScalar(x), btScalar(y), btScalar(z));
}
// The last report of the only pair.
PairReport onlyPair(const Context& context)
{
	PairReport last;
	context.forEachPair([&last](const PairReport& report) { last = report; });
	return last;
}
}  // namespace

TEST(Scale, StretchedBodiesRestAtTheirHeight)
{
	for (const Vec3& scale : {Vec3{1, 2, 1}, Vec3{-1, 0.5, 1}, Vec3{2, -1, 0.5}, Vec3{-1, -1, -1}, Vec3{0.3, 0.3, 0.3}})
	{
		BulletWorld scene;
		scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
		btClodShape& shape = scene.addShape(cube());
		shape.setLocalScaling(vector(scale.x, scale.y, scale.z));
		EXPECT_EQ(shape.scalingError(), "");
		const btRigidBody& body = scene.addBody(shape, 1, {0.1, 0.5 * std::abs(scale.y) + 0.05, 0.2});
		scene.step(480);
		EXPECT_NEAR(heightOf(body), 0.5 * std::abs(scale.y), 2e-3) << scale.y;
		EXPECT_LT(double(body.getLinearVelocity().length()), 1e-3);
		EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
	}
}

// A ball of 5 cm on a slab of 10 m hovers by its own skin.
TEST(Scale, TheSkinFollowsTheSmallerBody)
{
	BulletWorld scene;
	scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	btClodShape& small = scene.addShape(cube());
	small.setLocalScaling(vector(0.05, 0.05, 0.05));
	const btRigidBody& body = scene.addBody(small, 1, {0, 0.03, 0});
	scene.step(240);
	EXPECT_NEAR(heightOf(body), 0.025, 0.001 * 0.05);
}

// Two toruses, one of them another size than the other: levels, facets and certified errors are the same as of one
// that was made so, and lengths of metrics those of the body scaled less.
TEST(Scale, UnequalScalesAnswerAsBodiesMadeAtThatSize)
{
	const auto torus = body("torus-900").hierarchy;
	for (const double factor : {1.001, 1.01, 10.0})
		for (const bool byLength : {false, true})
		{
			const double radius = double(torus->asset().radius), unit = 1 / radius;
			const ContactMetric metric = byLength ? ContactMetric() : ContactMetric::deviationShare(0.02);
			PairReport met[2], reports[2];
			for (const bool isMade : {false, true})
			{
				BulletWorld scene;
				scene.context.worldMetric = metric;
				if (byLength) scene.context.worldMetric.weightedDeviation = 0.02 * radius;
				btClodShape& large = isMade ? scene.addShape(scaledHierarchy(*torus, {factor, factor, factor}).value())
											: scene.addShape(torus);
				btClodShape& small = scene.addShape(torus);
				const double scale = isMade ? unit : factor * unit;
				large.setLocalScaling(vector(scale, scale, scale));
				small.setLocalScaling(vector(unit, unit, unit));
				scene.addBody(large, 0, {});
				const double height = (factor + 1) * 0.3;
				btRigidBody& body = scene.addBody(small, 1, {0.7 * (factor - 1), height, 0});
				body.setLinearVelocity(vector(0, -1, 0));
				for (int i = 0; i < 960 && scene.contacts() == 0; ++i) scene.step();
				met[isMade ? 1 : 0] = onlyPair(scene.context);
				scene.step(4);
				reports[isMade ? 1 : 0] = onlyPair(scene.context);
				EXPECT_GT(scene.contacts(), 0);
			}
			const auto levels = [](const PairReport& report)
			{ return std::make_tuple(report.finestLevel, report.coarsestLevel); };
			// Where they meet, facet by facet. Later their motions differ in the last bits of floats, and with them which of the
			// places that are equally far out stay (ContactReducer.cpp), and what is just possible in the step.
			EXPECT_EQ(met[0].candidates, met[1].candidates) << factor << " " << byLength;
			EXPECT_EQ(met[0].points, met[1].points) << factor << " " << byLength;
			EXPECT_EQ(levels(met[0]), levels(met[1])) << factor << " " << byLength;
			EXPECT_EQ(levels(reports[0]), levels(reports[1])) << factor << " " << byLength;
			EXPECT_NEAR(reports[0].contactError * radius, reports[1].contactError * radius, 1e-3) << factor;
		}
}

TEST(Scale, ShapesOfOneHierarchyAndScaleShareWhatIsDerived)
{
	const auto given = cube();
	btClodShape one(given), other(given);
	for (const double factor : {2.0, 3.0})
		for (btClodShape* shape : {&one, &other}) shape->setLocalScaling(vector(factor, factor, factor));
	EXPECT_EQ(one.inWorldLengths(), other.inWorldLengths());
	other.setLocalScaling(vector(2, 2, 2));
	EXPECT_NE(one.inWorldLengths(), other.inWorldLengths());
	for (btClodShape* shape : {&one, &other}) shape->setLocalScaling(vector(1, 2, 1));
	EXPECT_EQ(one.sharedHierarchy(), other.sharedHierarchy());
	// What nobody holds is gone.
	const std::weak_ptr<const Hierarchy> held = one.sharedHierarchy();
	for (btClodShape* shape : {&one, &other}) shape->setLocalScaling(vector(1, 1, 1));
	EXPECT_TRUE(held.expired());
}

TEST(Scale, ARefusedScaleIsToldOf)
{
	BulletWorld scene;
	scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	btClodShape& shape = scene.addShape(cube());
	shape.setLocalScaling(vector(1, 0, 1));
	EXPECT_NE(shape.scalingError().find("zero"), std::string::npos) << shape.scalingError();
	const btRigidBody& body = scene.addBody(shape, 1, {0, 0.5, 0});
	scene.step(10);
	ASSERT_EQ(scene.warnings.size(), 1u);
	EXPECT_NE(scene.warnings[0].find(shape.scalingError()), std::string::npos) << scene.warnings[0];
	EXPECT_NEAR(heightOf(body), 0.5, 0.01);
}

// While a pair lives.
TEST(Scale, StretchingABodyAtRestIsNoticed)
{
	BulletWorld scene;
	scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	btClodShape& shape = scene.addShape(cube());
	btRigidBody& body = scene.addBody(shape, 1, {0, 0.5, 0});
	scene.step(60);
	shape.setLocalScaling(vector(1, 0.5, 1));
	scene.step(240);
	EXPECT_NEAR(heightOf(body), 0.25, 2e-3);
	shape.setLocalScaling(vector(1, 1, 1));
	body.translate(vector(0, 0.26, 0));
	scene.step(240);
	EXPECT_NEAR(heightOf(body), 0.5, 2e-3);
}

TEST(Scale, RaysMeetTheStretchedSurface)
{
	BulletWorld scene;
	btClodShape& shape = scene.addShape(cube());
	shape.setLocalScaling(vector(-1, 3, 1));
	scene.addBody(shape, 0, {});
	const btVector3 from = vector(0.1, 5, 0.2), to = vector(0.1, -5, 0.2);
	btCollisionWorld::ClosestRayResultCallback ray(from, to);
	scene.world.updateAabbs();
	scene.world.rayTest(from, to, ray);
	ASSERT_TRUE(ray.hasHit());
	EXPECT_NEAR(double(ray.m_hitPointWorld.y()), 1.5, 1e-4);
	EXPECT_GT(double(ray.m_hitNormalWorld.y()), 0.99);
}

// A program may set a shape's scale in every step. The same one again changes nothing: what is kept of contacts stays.
TEST(Scale, TheSameScaleAgainChangesNothing)
{
	for (const Vec3& scale : {Vec3{0.5, 0.5, 0.5}, Vec3{1, 2, 1}})
	{
		BulletWorld scene;
		scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
		btClodShape& shape = scene.addShape(cube());
		shape.setLocalScaling(vector(scale.x, scale.y, scale.z));
		scene.addBody(shape, 1, {0.1, 0.5 * scale.y, 0.2});
		scene.step(240);
		const Hierarchy* before = &shape.hierarchy();
		shape.setLocalScaling(vector(scale.x, 0, scale.z));
		EXPECT_NE(shape.scalingError(), "");
		shape.setLocalScaling(vector(scale.x, scale.y, scale.z));
		EXPECT_EQ(shape.scalingError(), "");
		EXPECT_EQ(&shape.hierarchy(), before);
		scene.step();
		EXPECT_EQ(scene.context.lastStep().keptPairs, 1u);
		for (int i = 0; i < scene.dispatcher.getNumManifolds(); ++i)
			EXPECT_GT(scene.dispatcher.getManifoldByIndexInternal(i)->getContactPoint(0).getLifeTime(), 100);
	}
}

// Dimensions may change while a pair lives, and so may the shape.
TEST(Scale, ShapesOfBulletsThatChangeAreSeen)
{
	BulletWorld scene;
	scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	auto& box = scene.add(std::make_unique<btBoxShape>(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5))));
	btRigidBody& body = scene.addBody(box, 1, {0, 0.5, 0});
	scene.step(120);
	EXPECT_NEAR(heightOf(body), 0.5, 2e-3);
	box.setLocalScaling(btVector3(1, btScalar(0.5), 1));
	scene.step(240);
	EXPECT_NEAR(heightOf(body), 0.25, 2e-3);
	auto& sphere = scene.add(std::make_unique<btSphereShape>(btScalar(0.4)));
	body.setCollisionShape(&sphere);
	body.translate(btVector3(0, btScalar(0.2), 0));
	scene.step(240);
	EXPECT_NEAR(heightOf(body), 0.4, 2e-3);
}

// What is made of a shape whose points are known is exact, whoever holds the points, and however it is scaled.
TEST(Scale, PointsOfMeshesAndScaledShapesAreTakenAsTheyAre)
{
	Random random(6);
	btTriangleMesh mesh;
	btConvexHullShape points;
	for (int i = 0; i < 900; ++i)
	{
		btVector3 corners[3];
		for (btVector3& corner : corners)
		{
			const Vec3 p = 0.4 * randomDirection(random);
			points.addPoint(corner = vector(p.x, p.y, p.z), false);
		}
		mesh.addTriangle(corners[0], corners[1], corners[2]);
	}
	btConvexTriangleMeshShape hull(&mesh);
	const btVector3 stretch = vector(0.5, 1, 1.5);
	hull.setLocalScaling(stretch), points.setLocalScaling(stretch);
	btCapsuleShape capsule(btScalar(0.1), btScalar(0.3)), larger(btScalar(0.15), btScalar(0.45));
	const btVector3 centers[] = {vector(-0.2, 0, 0), vector(0.2, 0, 0)}, wider = btScalar(1.5) * centers[1];
	const btVector3 widerCenters[] = {-wider, wider};
	const btScalar radii[] = {btScalar(0.1), btScalar(0.2)}, widerRadii[] = {btScalar(0.15), btScalar(0.3)};
	btMultiSphereShape spheres(centers, radii, 2), widerSpheres(widerCenters, widerRadii, 2);
	btUniformScalingShape scaledCapsule(&capsule, btScalar(1.5)), scaledSpheres(&spheres, btScalar(1.5));
	BulletWorld scene;
	btRigidBody& ground = scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	for (const auto& [shape, same] : std::vector<std::array<btConvexShape*, 2>>{
			 {&hull, &points}, {&scaledCapsule, &larger}, {&scaledSpheres, &widerSpheres}})
		for (int pose = 0; pose < 6; ++pose)
		{
			const btQuaternion turn(vector(1, pose, 0.5).normalized(), btScalar(pose));
			double least[2];
			for (int i = 0; i < 2; ++i)
			{
				btRigidBody& body = scene.addBody(i == 0 ? *shape : *same, 1, {0, 0.9, 0}, turn);
				Closest nearest(1);
				scene.world.contactPairTest(&ground, &body, nearest);
				least[i] = nearest.least;
				scene.world.removeRigidBody(&body);
			}
			EXPECT_NEAR(least[0], least[1], 2e-6) << shape->getName() << pose;
		}
}

// A program may move a mesh's corners, or name others, under the same shape; and it need not set how many rows of
// corners there are, which Bullet does not read.
TEST(Scale, AChangedConvexMeshIsSeen)
{
	for (const int rows : {5, 0, std::numeric_limits<int>::max()})
	{
		btScalar corners[] = {-1, 0, -1, 1, 0, -1, 0, 0, 1, 0, -1, 0, 0, -2, 0};
		int faces[] = {0, 1, 2, 0, 1, 3, 1, 2, 3, 2, 0, 3};
		btTriangleIndexVertexArray mesh(4, faces, 3 * sizeof(int), rows, corners, 3 * sizeof(btScalar));
		btConvexTriangleMeshShape shape(&mesh);
		shape.setMargin(0);
		btUniformScalingShape twice(&shape, 2);
		BulletWorld scene;
		btRigidBody& ground = scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
		btRigidBody &single = scene.addBody(shape, 1, {0, 2.5, 0}), &scaled = scene.addBody(twice, 1, {0, 4.5, 0});
		const auto expect = [&](double below)
		{
			const double heights[] = {2.5 - below, 4.5 - 2 * below};
			for (btRigidBody* body : {&single, &scaled})
			{
				Closest nearest(3);
				scene.world.contactPairTest(&ground, body, nearest);
				EXPECT_NEAR(nearest.least, heights[body == &scaled], 1e-3) << below << " of " << rows;
			}
		};
		expect(1);
		corners[10] = btScalar(-1.5);
		expect(1.5);
		for (int& corner : faces) corner = corner == 3 ? 4 : corner;
		expect(2);
	}
}

// One corner is enough, the first or any other that a triangle names; where none does it is no part of the mesh.
TEST(Scale, AMeshThatIsNotFiniteIsRefusedWithAReason)
{
	for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
		for (int corner = 0; corner < 5; ++corner)
		{
			btScalar corners[] = {-1, 0, -1, 1, 0, -1, 0, 0, 1, 0, -1, 0, 0, -2, 0};
			int faces[] = {0, 1, 2, 0, 1, 3, 1, 2, 3, 2, 0, 3};
			btTriangleIndexVertexArray mesh(4, faces, 3 * sizeof(int), 5, corners, 3 * sizeof(btScalar));
			btConvexTriangleMeshShape shape(&mesh);
			corners[3 * corner + corner % 3] = btScalar(bad);
			ConvexPartners partners;
			const auto partner = partners.of(shape, 1, nullptr);
			EXPECT_EQ(partner->problem, corner < 4 ? "a number of the shape is not finite" : "") << bad << corner;
			EXPECT_EQ(partner->hierarchy != nullptr, corner == 4) << bad << corner;
		}
}
}  // namespace clod::test
