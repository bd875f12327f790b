// SPDX-License-Identifier: GPL-3.0-or-later
// Bullet's convex shapes against ours: rest, distances and rolling, with closed forms and Bullet's own GJK beside.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include <BulletCollision/CollisionShapes/btConvexInternalShape.h>

#include "clod/bullet/ConvexPartner.h"
#include "clod/hierarchy/InputSurface.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"
#include "tests/query/Bodies.h"
#include "tests/query/TriangleGap.h"

namespace clod::test
{
namespace
{
struct Kind
{
	const char* name;
	std::function<std::unique_ptr<btCollisionShape>()> make;
	double height;     // of its lowest point under its origin, as it is put down
	double tolerance;  // of that, besides skin and resting height
};

std::unique_ptr<btConvexHullShape> hullOfCube(double half)
{
	auto hull = std::make_unique<btConvexHullShape>();
	for (int i = 0; i < 8; ++i)
		hull->addPoint(btVector3(btScalar((i & 1) != 0 ? half : -half), btScalar((i & 2) != 0 ? half : -half),
								 btScalar((i & 4) != 0 ? half : -half)));
	return hull;
}

const std::vector<Kind>& kinds()
{
	static const std::vector<Kind> all = {
		{"box", [] { return std::make_unique<btBoxShape>(btVector3(btScalar(0.5), btScalar(0.3), btScalar(0.4))); }, 0.3, 0},
		{"hull", [] { return hullOfCube(0.4); }, 0.44, 0},
		{"sheet",
		 []
		 {
			 auto sheet = std::make_unique<btConvexHullShape>();
			 for (int i = 0; i < 4; ++i) sheet->addPoint(btVector3(btScalar((i & 1) - 0.5), 0, btScalar((i >> 1) - 0.5)));
			 return sheet;
		 },
		 0.04, 0},
		{"sphere", [] { return std::make_unique<btSphereShape>(btScalar(0.5)); }, 0.5, 0},
		{"capsule", [] { return std::make_unique<btCapsuleShapeX>(btScalar(0.3), btScalar(0.8)); }, 0.3, 0},
		{"spheres",
		 []
		 {
			 const btVector3 places[2] = {btVector3(btScalar(-0.3), 0, 0), btVector3(btScalar(0.3), 0, 0)};
			 const btScalar radii[2] = {btScalar(0.25), btScalar(0.25)};
			 return std::make_unique<btMultiSphereShape>(places, radii, 2);
		 },
		 0.25, 0},
		{"unequal spheres",
		 []
		 {
			 const btVector3 places[2] = {btVector3(btScalar(-0.3), 0, 0), btVector3(btScalar(0.3), btScalar(-0.05), 0)};
			 const btScalar radii[2] = {btScalar(0.25), btScalar(0.2)};
			 return std::make_unique<btMultiSphereShape>(places, radii, 2);
		 },
		 0.25, 0.004},
		{"cylinder",
		 [] { return std::make_unique<btCylinderShape>(btVector3(btScalar(0.4), btScalar(0.3), btScalar(0.4))); }, 0.3, 0},
		{"cone", [] { return std::make_unique<btConeShape>(btScalar(0.4), btScalar(0.8)); }, 0.44, 0},
	};
	return all;
}
}  // namespace

// What touches with radii stands at them; nothing sinks, creeps or jumps. Ground and mover change places.
TEST(Convex, RestsWhereItsSurfaceSays)
{
	for (const Kind& kind : kinds())
		for (const bool clodIsGround : {true, false})
		{
			BulletWorld scene;
			btCollisionShape& convex = scene.add(kind.make());
			btClodShape& ours = scene.addShape(clodIsGround ? slab() : cube());
			if (!clodIsGround && std::string(kind.name) != "box") continue;
			btRigidBody& ground =
				clodIsGround ? scene.addBody(ours, 0, {0, -0.5, 0}) : scene.addBody(convex, 0, {0, -kind.height, 0});
			const double height = clodIsGround ? kind.height : 0.5;
			btRigidBody& body = clodIsGround ? scene.addBody(convex, 1, {0.1, height + 0.05, 0.2})
											 : scene.addBody(ours, 1, {0.1, height + 0.05, 0.05});
			body.setRollingFriction(btScalar(0.01));
			ground.setRollingFriction(btScalar(0.5));
			scene.step(720);
			EXPECT_NEAR(heightOf(body), height, 0.0015 + kind.tolerance) << kind.name;
			EXPECT_LT(double(body.getLinearVelocity().length()), 1e-3) << kind.name;
			EXPECT_TRUE(scene.warnings.empty()) << kind.name << ": " << scene.warnings.front();
			EXPECT_LE(scene.contacts(), 32) << kind.name;
		}
}

namespace
{
// A convex shape of Bullet's as triangles, those of a point or a segment without area, grown by a radius.
struct Grown
{
	std::unique_ptr<btCollisionShape> shape;
	TriangleSoup triangles;
	double radius;
};
std::vector<Grown> grownShapes()
{
	std::vector<Grown> all;
	all.push_back({std::make_unique<btSphereShape>(btScalar(0.4)), {{Vec3{}, Vec3{}, Vec3{}}}, 0.4});
	const Vec3 top{0, 0.3, 0}, bottom{0, -0.3, 0};
	all.push_back({std::make_unique<btCapsuleShape>(btScalar(0.2), btScalar(0.6)), {{top, bottom, bottom}}, 0.2});
	const Vec3 corners[4] = {{0.5, 0, 0}, {-0.25, 0.4, 0}, {-0.25, -0.2, 0.4}, {-0.25, -0.2, -0.4}};
	for (const double margin : {0.0, 0.1})
	{
		auto hull = std::make_unique<btConvexHullShape>();
		for (const Vec3& c : corners) hull->addPoint(btVector3(btScalar(c.x), btScalar(c.y), btScalar(c.z)));
		hull->setMargin(btScalar(margin));
		all.push_back({std::move(hull), {}, margin});
		for (std::size_t i = 0; i < 4; ++i)
			all.back().triangles.push_back({corners[i], corners[(i + 1) % 4], corners[(i + 2) % 4]});
	}
	return all;
}
}  // namespace

// Brute force over all triangles, at all distances up to twice the radius, in both orders.
TEST(Convex, ClosestPointsAreAsFarAsBruteForceSays)
{
	Random random(7);
	int compared = 0;
	for (const char* name : {"torus-900", "cup-3000"})
	{
		const Body& ours = body(name);
		const double scale = 1 / double(ours.hierarchy->asset().radius);
		for (Grown& grown : grownShapes())
		{
			BulletWorld scene;
			scene.context.worldMetric = ContactMetric::exactly();
			btClodShape& shape = scene.addShape(ours.hierarchy);
			shape.setLocalScaling(btVector3(btScalar(scale), btScalar(scale), btScalar(scale)));
			btRigidBody& a = scene.addBody(shape, 1, {});
			btRigidBody& b = scene.addBody(*grown.shape, 1, {});
			for (int pose = 0; pose < 30; ++pose)
			{
				const Mat3 turn = randomRotation(random);
				const Vec3 place = randomVector(random, 0.2, 1.6);
				btMatrix3x3 basis;
				for (int i = 0; i < 3; ++i)
					basis[i].setValue(btScalar(turn.row[i].x), btScalar(turn.row[i].y), btScalar(turn.row[i].z));
				b.setWorldTransform(btTransform(basis, btVector3(btScalar(place.x), btScalar(place.y), btScalar(place.z))));
				double expected = std::numeric_limits<double>::infinity();
				for (std::array<Vec3, 3> s : grown.triangles)
				{
					for (Vec3& p : s) p = (1 / scale) * (turn * p + place);
					for (const std::array<Vec3, 3>& t : ours.triangles)
						expected = std::min(expected, scale * triangleDistance(s, t));
				}
				if (expected < 1e-3 || windingNumber(ours.triangles, (1 / scale) * place) > 0.5) continue;
				expected -= grown.radius;
				++compared;
				for (const bool aFirst : {true, false})
				{
					Closest closest(2);
					scene.world.contactPairTest(aFirst ? &a : &b, aFirst ? &b : &a, closest);
					EXPECT_NEAR(closest.least, expected, 5e-6) << name << ", " << grown.shape->getName() << " " << grown.radius << ", pose " << pose;
				}
			}
		}
	}
	EXPECT_GT(compared, 120);
}

// A closed slab of flat triangles, in patches: what slides or rolls over it feels none of their borders.
TEST(Convex, FlatTrianglesHaveNoSeams)
{
	const auto grid = patchHierarchy(boxMesh({20, 1, 4}, {40, 1, 8}, 2));
	for (int round = 0; round < 2 * int(kinds().size()); ++round)
	{
		const Kind& kind = kinds()[std::size_t(round / 2)];
		const std::string name = kind.name;
		if (name == "cone" || name == "unequal spheres" || name == "cylinder") continue;
		BulletWorld scene;
		const int rate = round % 2 == 0 ? 240 : 60;
		scene.timeStep = 1.0 / rate;
		btRigidBody& ground = scene.addBody(scene.addShape(grid), 0, {0, -0.5, 0});
		btRigidBody& body = scene.addBody(scene.add(kind.make()), 1, {-8.5, kind.height + 0.0005, 0.1});
		ground.setFriction(0);
		const bool rolls = name == "sphere";
		body.setFriction(rolls ? 1 : 0);
		ground.setFriction(rolls ? 1 : 0);
		body.setLinearVelocity(btVector3(4, 0, 0));
		if (rolls) body.setAngularVelocity(btVector3(0, 0, btScalar(-4 / kind.height)));
		scene.step(rate / 12);
		const double start = heightOf(body);
		double low = start, high = start;
		for (int i = 0; i < 25 * rate / 6; ++i)
		{
			scene.step();
			low = std::min(low, heightOf(body));
			high = std::max(high, heightOf(body));
		}
		EXPECT_GT(double(body.getLinearVelocity().x()), 3.99) << name << " at " << rate;
		EXPECT_LT(high - low, 1e-4) << name << " at " << rate;
		EXPECT_LT(std::abs(double(body.getWorldTransform().getOrigin().z()) - 0.1), 1e-3) << name;
	}
}

// A torus, a cup and a spoon dropped on a box and on a hull: at rest, and no vertex deeper than the skin.
TEST(Convex, DetailedBodiesRestOnThem)
{
	for (const char* name : {"torus-900", "cup-3000", "spoon-3000"})
		for (const bool onHull : {false, true})
		{
			const Body& ours = body(name);
			const double scale = 1 / double(ours.hierarchy->asset().radius);
			BulletWorld scene;
			scene.timeStep = 1.0 / 60;
			auto& box = scene.add(std::make_unique<btBoxShape>(btVector3(5, 1, 5)));
			auto hull = hullOfCube(4);
			hull->setMargin(btScalar(0.01));
			scene.addBody(onHull ? static_cast<btCollisionShape&>(scene.add(std::move(hull))) : box, 0,
						  {0, onHull ? -4.01 : -1, 0});
			btClodShape& shape = scene.addShape(ours.hierarchy);
			shape.setLocalScaling(btVector3(btScalar(scale), btScalar(scale), btScalar(scale)));
			const btRigidBody& moving = scene.addBody(shape, 1, {0, 1.1, 0});
			scene.step(600);
			EXPECT_LT(double(moving.getLinearVelocity().length()), 1e-3) << name << onHull;
			double lowest = 1;
			for (const std::array<Vec3, 3>& t : ours.triangles)
				for (const Vec3& p : t)
				{
					const btVector3 world = moving.getWorldTransform() *
											btVector3(btScalar(scale * p.x), btScalar(scale * p.y), btScalar(scale * p.z));
					lowest = std::min(lowest, double(world.y()));
				}
			EXPECT_GT(lowest, -0.5 * kSkinShare) << name << onHull;
			EXPECT_LT(lowest, 4 * kSkinShare) << name << onHull;
		}
}

// A body that turns meets no more of itself on a wide box, or on one piece of ours, than on a plane, though their far corners
// turn fast as seen from it.
TEST(Convex, WhatTurnsMeetsAWideBoxAsItMeetsAPlane)
{
	const std::shared_ptr<const Hierarchy> torus = body("torus-900").hierarchy;
	const auto pairsMet = [&](int ground)
	{
		BulletWorld scene;
		scene.timeStep = 1.0 / 60;
		scene.context.worldMetric = ContactMetric::exactly();
		if (ground == 0)
			scene.addBody(scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0))), 0, {});
		else if (ground == 1)
			scene.addBody(scene.add(std::make_unique<btBoxShape>(btVector3(4, 1, 4))), 0, {0, -1, 0});
		else
			scene.addBody(scene.addShape(patchHierarchy(boxMesh({8, 2, 8}, {1, 1, 1}, 2))), 0, {0, -1, 0});
		btClodShape& shape = scene.addShape(torus, 1);
		btRigidBody& moving = scene.addBody(shape, 1, {0, 1.1, 0}, btQuaternion(btVector3(1, 0, 0), btScalar(0.4)));
		moving.setAngularVelocity(btVector3(4, 0, 3));
		std::uint32_t met = 0;
		for (int i = 0; i < 40; ++i)
		{
			scene.step();
			met += scene.context.lastStep().nodePairs;
		}
		return met;
	};
	const std::uint32_t onPlane = pairsMet(0);
	EXPECT_GT(onPlane, 100u);
	EXPECT_LT(pairsMet(1), onPlane);
	EXPECT_LT(pairsMet(2), onPlane);
}

// A ball dropped into a cup comes to rest on its bottom, as far off as bodies rest.
TEST(Convex, ABallRestsInACup)
{
	constexpr double kBall = 0.25;
	const std::shared_ptr<const Hierarchy> cup = body("cup-3000").hierarchy;
	const double scale = 1 / double(cup->asset().radius);
	for (const int rate : {60, 240})
	{
		BulletWorld scene;
		scene.timeStep = 1.0 / rate;
		scene.context.worldMetric = ContactMetric::exactly();
		btClodShape& shape = scene.addShape(cup);
		shape.setLocalScaling(btVector3(btScalar(scale), btScalar(scale), btScalar(scale)));
		scene.addBody(shape, 0, {}).setRollingFriction(1);
		btRigidBody& ball = scene.addBody(scene.add(std::make_unique<btSphereShape>(btScalar(kBall))), 1, {0.02, 1.5, 0.01});
		ball.setRollingFriction(btScalar(0.05));
		scene.step(5 * rate);
		EXPECT_LT(double(ball.getLinearVelocity().length()), 1e-3) << rate;
		const btVector3& place = ball.getWorldTransform().getOrigin();
		std::uint32_t visited = 0;
		const Vec3 own = (1 / scale) * Vec3{double(place.x()), double(place.y()), double(place.z())};
		EXPECT_NEAR(scale * distanceToInput(*cup, own, visited).distance - kBall, kSkinShare * kBall, 0.1 * kSkinShare * kBall) << rate;
		EXPECT_LT(double(place.y()), 0.2) << rate;
	}
}

// Thirty balls let go just over flat ground stay where they are.
TEST(Convex, BallsOnFlatGroundDoNotRollOff)
{
	BulletWorld scene;
	scene.addBody(scene.addShape(patchHierarchy(boxMesh({20, 1, 20}, {20, 1, 20}, 2))), 0, {0, -0.5, 0});
	btCollisionShape& ball = scene.add(std::make_unique<btSphereShape>(btScalar(0.5)));
	Random random(3);
	std::vector<btRigidBody*> balls;
	for (int i = 0; i < 30; ++i)
		balls.push_back(&scene.addBody(ball, 1,
									   {1.5 * (i % 6) - 4 + uniform(random, -0.2, 0.2), 0.6,
										1.5 * (i / 6) - 3 + uniform(random, -0.2, 0.2)}));
	scene.step(720);
	for (const btRigidBody* one : balls) EXPECT_LT(double(one->getLinearVelocity().length()), 1e-3);
}

// As a ball turns nothing of it moves: contacts are looked for no farther.
TEST(Convex, ABallThatSpinsMeetsWhatOneThatDoesNotMeets)
{
	PairReport reports[2];
	std::uint32_t tests[2];
	for (const int spins : {0, 1})
	{
		BulletWorld scene;
		scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
		btRigidBody& ball = scene.addBody(scene.add(std::make_unique<btSphereShape>(btScalar(0.3))), 1, {0, 0.3, 0});
		ball.setLinearVelocity(btVector3(1, 0, 0));
		ball.setAngularVelocity(btVector3(0, 5, -40) * btScalar(spins));
		scene.step();
		scene.context.forEachPair(
			[&](const PairReport& report)
			{
				reports[spins] = report;
				tests[spins] = report.result->stats.boxTests;
			});
	}
	EXPECT_GT(reports[0].motion, 1.0 / 240);
	EXPECT_EQ(reports[1].motion, reports[0].motion);
	EXPECT_EQ(reports[1].tolerance, reports[0].tolerance);
	EXPECT_EQ(tests[1], tests[0]);
}

// Radii below Bullet's margin too, which its own support takes off all of them: over a flat ground the distance is that of the
// lowest sphere.
TEST(Convex, SpheresOfAnyRadiiAreAsFarAsTheLowest)
{
	Random random(31);
	const btVector3 places[3] = {btVector3(btScalar(-0.2), 0, 0), btVector3(btScalar(0.2), 0, 0),
								 btVector3(0, btScalar(0.2), btScalar(0.04))};
	for (const double size : {0.3, 1.0, 4.0})
		for (const auto& [isEqual, unit] : {std::pair{true, 1.0}, std::pair{false, 1.0}, std::pair{false, 100.0}})
		{
			btScalar radii[3] = {btScalar(0.06), btScalar(0.1), btScalar(0.03)};
			if (isEqual) radii[1] = radii[2] = radii[0];
			BulletWorld scene;
			scene.context.worldMetric = ContactMetric::exactly();
			btClodShape& slab = scene.addShape(patchHierarchy(boxMesh({9 / unit, 1 / unit, 9 / unit}, {1, 1, 1}, 1)));
			slab.setLocalScaling(btVector3(btScalar(unit), btScalar(unit), btScalar(unit)));
			btRigidBody& ground = scene.addBody(slab, 0, {0, -0.5, 0});
			auto& shape = scene.add(std::make_unique<btMultiSphereShape>(places, radii, 3));
			shape.setLocalScaling(btVector3(btScalar(size), btScalar(size), btScalar(size)));
			btRigidBody& body = scene.addBody(shape, 1, {});
			for (int pose = 0; pose < 40; ++pose)
			{
				const Mat3 turn = randomRotation(random);
				const double height = uniform(random, 0.35, 0.5) * size;
				double expected = std::numeric_limits<double>::infinity();
				for (std::size_t i = 0; i < 3; ++i)
				{
					const Vec3 place{double(places[i].x()), double(places[i].y()), double(places[i].z())};
					expected = std::min(expected, height + size * (dot(turn.row[1], place) - double(radii[i])));
				}
				btMatrix3x3 basis;
				for (int i = 0; i < 3; ++i)
					basis[i].setValue(btScalar(turn.row[i].x), btScalar(turn.row[i].y), btScalar(turn.row[i].z));
				body.setWorldTransform(btTransform(basis, btVector3(0, btScalar(height), 0)));
				Closest nearest(size);
				scene.world.contactPairTest(&ground, &body, nearest);
				EXPECT_NEAR(nearest.least, expected, 0.004 * size)
					<< size << ", equal " << isEqual << ", unit " << unit << ", pose " << pose;
			}
		}
}

// A bad shape is told of, by name of its cause, and is no contact.
TEST(Convex, WhatIsNotFiniteIsRefusedWithAReason)
{
	BulletWorld scene;
	scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	auto& hull = scene.add(hullOfCube(0.5));
	hull.getUnscaledPoints()[0].setX(std::numeric_limits<btScalar>::quiet_NaN());
	scene.addBody(hull, 1, {0, 0.4, 0});
	scene.step(3);
	ASSERT_FALSE(scene.warnings.empty());
	EXPECT_NE(scene.warnings.front().find("not finite"), std::string::npos) << scene.warnings.front();
	EXPECT_EQ(scene.contacts(), 0);
}

// A user's own class, of which no more is known than its support: an upright prism.
class Prism : public btConvexInternalShape
{
public:
	int sides = 8;
	Prism()
	{
		m_shapeType = CUSTOM_CONVEX_SHAPE_TYPE;
		setMargin(0);
	}
	btVector3 localGetSupportingVertex(const btVector3& d) const override
	{
		btVector3 best(0, 0, 0);
		btScalar most = -BT_LARGE_FLOAT;
		for (int i = 0; i < 2 * sides; ++i)
		{
			const double angle = 2 * 3.14159265358979 * (i / 2) / sides;
			const btVector3 corner(btScalar(0.5 * std::cos(angle)), btScalar(0.5 * std::sin(angle)),
								   btScalar(i % 2 == 0 ? -0.5 : 0.5));
			if (corner.dot(d) <= most) continue;
			best = corner;
			most = corner.dot(d);
		}
		return best;
	}
	btVector3 localGetSupportingVertexWithoutMargin(const btVector3& d) const override
	{
		return localGetSupportingVertex(d);
	}
	void batchedUnitVectorGetSupportingVertexWithoutMargin(const btVector3* d, btVector3* out, int count) const override
	{
		for (int i = 0; i < count; ++i) out[i] = localGetSupportingVertex(d[i]);
	}
	void calculateLocalInertia(btScalar, btVector3& inertia) const override { inertia.setValue(1, 1, 1); }
	void getAabb(const btTransform& pose, btVector3& low, btVector3& high) const override
	{
		low = pose.getOrigin() - btVector3(1, 1, 1), high = pose.getOrigin() + btVector3(1, 1, 1);
	}
	const char* getName() const override { return "Prism"; }
};

// A shape that changes where nobody looks at it is another all the same, also in the same place: prisms of 8 and 64
// sides, whose extremes along 26 directions are the same. What does not change is prepared once.
TEST(Convex, ShapesKnownByTheirSupportAreNotTakenForEachOther)
{
	BulletWorld scene;
	btRigidBody& ground = scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	Prism shape;
	ConvexPartners partners;
	std::shared_ptr<const ConvexPartner> last;
	for (const int sides : {8, 64, 8})
	{
		shape.sides = sides;
		const double half = 3.14159265358979 / 8;
		btRigidBody& body = scene.addBody(shape, 1, {0, 0.6, 0}, btQuaternion(btVector3(0, 0, 1), btScalar(half)));
		Closest nearest(1);
		scene.world.contactPairTest(&ground, &body, nearest);
		EXPECT_NEAR(nearest.least, 0.6 - (sides == 8 ? 0.5 * std::cos(half) : 0.5), 1e-3) << sides;
		scene.world.removeRigidBody(&body);
		const auto prepared = partners.of(shape, 1, nullptr);
		EXPECT_NE(prepared, last);
		EXPECT_EQ(prepared, partners.of(shape, 1, nullptr));
		last = prepared;
	}
}

// Two spheres of which one is larger, and four whose centres are the numbers that tell of those.
TEST(Convex, SpheresOfTwoSizesAreNotTakenForMoreOfOneSize)
{
	BulletWorld scene;
	btRigidBody& ground = scene.addBody(scene.addShape(slab()), 0, {0, -0.5, 0});
	const btVector3 centers[] = {{btScalar(-0.25), 0, 0}, {btScalar(0.5), 0, 0}, {btScalar(0.125), 0, 0}, {btScalar(0.25), 0, 0}};
	const btScalar radii[] = {btScalar(0.125), btScalar(0.25)}, equal[] = {radii[0], radii[0], radii[0], radii[0]};
	btMultiSphereShape two(centers, radii, 2), four(centers, equal, 4);
	for (btMultiSphereShape* shape : {&two, &four})
	{
		btRigidBody& body = scene.addBody(*shape, 1, {0, 0.5, 0});
		Closest nearest(1);
		scene.world.contactPairTest(&ground, &body, nearest);
		EXPECT_NEAR(nearest.least, shape == &two ? 0.25 : 0.375, 1e-3);
		scene.world.removeRigidBody(&body);
	}
}
}  // namespace clod::test
