// SPDX-License-Identifier: GPL-3.0-or-later
// calculateTimeOfImpact against closed forms: balls and boxes that fly at each other and turn.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "clod/bullet/BodyState.h"
#include "clod/bullet/ConfigureWorld.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"
#include "tests/query/Questions.h"

namespace clod::test
{
namespace
{
struct Flight
{
	BulletWorld scene;
	btRigidBody *first = nullptr, *second = nullptr;
	btCollisionAlgorithm* algorithm = nullptr;

	~Flight()
	{
		if (!algorithm) return;
		algorithm->~btCollisionAlgorithm();
		scene.dispatcher.freeCollisionAlgorithm(algorithm);
	}
	double timeOfImpact(const btTransform& firstTo, const btTransform& secondTo)
	{
		first->setInterpolationWorldTransform(firstTo);
		second->setInterpolationWorldTransform(secondTo);
		if (!algorithm)
		{
			const btCollisionObjectWrapper a(nullptr, first->getCollisionShape(), first, first->getWorldTransform(), -1,
											 -1);
			const btCollisionObjectWrapper b(nullptr, second->getCollisionShape(), second, second->getWorldTransform(),
											 -1, -1);
			algorithm = scene.dispatcher.findAlgorithm(&a, &b, nullptr, BT_CONTACT_POINT_ALGORITHMS);
		}
		btManifoldResult result;
		return double(algorithm->calculateTimeOfImpact(first, second, scene.world.getDispatchInfo(), &result));
	}
};

btTransform at(double x, double y, double z, double turn = 0)
{
	return btTransform(btQuaternion(btVector3(0, 0, 1), btScalar(turn)),
					   btVector3(btScalar(x), btScalar(y), btScalar(z)));
}
}  // namespace

TEST(TimeOfImpact, OfBoxesThatFlyAtEachOther)
{
	Flight flight;
	btClodShape& box = flight.scene.addShape(patchHierarchy(boxMesh({1, 1, 1}, {2, 2, 2}, 1)));
	flight.first = &flight.scene.addBody(box, 1, {0, 0, 0});
	flight.second = &flight.scene.addBody(box, 1, {11, 0.2, 0.1});
	// 10 are between them, they close 40: met after a quarter.
	EXPECT_NEAR(flight.timeOfImpact(at(15, 0, 0), at(-14, 0.2, 0.1)), 0.25, 2e-3);
	EXPECT_LE(flight.timeOfImpact(at(15, 0, 0), at(-14, 0.2, 0.1)), 0.25);
	EXPECT_EQ(flight.timeOfImpact(at(-15, 0, 0), at(14, 0.2, 0.1)), 1);
	EXPECT_EQ(flight.timeOfImpact(at(0, 20, 0), at(11, 20.2, 0.1)), 1);
	// Just past.
	EXPECT_EQ(flight.timeOfImpact(at(22, 0, 0), at(0, 3.2, 0.1)), 1);
}

// Whichever of the two is A, which their contents decide.
TEST(TimeOfImpact, OfABarThatTurnsIntoABox)
{
	const auto ofBar = patchHierarchy(boxMesh({4, 0.2, 0.2}, {8, 1, 1}, 1));
	int barIsA = 0;
	for (const int cells : {1, 2, 3, 4, 5, 6})
	{
		const auto ofBox = patchHierarchy(boxMesh({1, 1, 1}, {cells, cells, cells}, 1));
		barIsA += ofBar->contentHash() < ofBox->contentHash();
		Flight flight;
		flight.first = &flight.scene.addBody(flight.scene.addShape(ofBar), 1, {0, 0, 0});
		flight.second = &flight.scene.addBody(flight.scene.addShape(ofBox), 1, {1.5, 1.5, 0});
		// The bar's upper corner, at (2, 0.1), rises to the box's lower side.
		const double angle = std::asin(1 / std::hypot(2.0, 0.1)) - std::atan2(0.1, 2.0);
		const double part = flight.timeOfImpact(at(0, 0, 0, 0.9), at(1.5, 1.5, 0));
		EXPECT_LE(part, angle / 0.9 + 1e-6) << cells;
		EXPECT_GT(part, angle / 0.9 - 5e-3) << cells;
		EXPECT_EQ(flight.timeOfImpact(at(0, 0, 0, -0.9), at(1.5, 1.5, 0)), 1) << cells;
	}
	EXPECT_GT(barIsA, 0);
	EXPECT_LT(barIsA, 6);
}

TEST(TimeOfImpact, OfABodyAndAPlane)
{
	Flight flight;
	btClodShape& box = flight.scene.addShape(patchHierarchy(boxMesh({1, 1, 1}, {2, 2, 2}, 1)));
	auto& plane = flight.scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)));
	flight.first = &flight.scene.addBody(box, 1, {0, 5.5, 0});
	flight.second = &flight.scene.addBody(plane, 0, {0, 0, 0});
	EXPECT_NEAR(flight.timeOfImpact(at(3, -4.5, 0), at(0, 0, 0)), 0.5, 2e-3);
	EXPECT_EQ(flight.timeOfImpact(at(3, 1, 0), at(0, 0, 0)), 1);
	box.setMargin(btScalar(0.5));
	EXPECT_NEAR(flight.timeOfImpact(at(3, -4.5, 0), at(0, 0, 0)), 0.45, 2e-3) << "the margin meets it first";
	EXPECT_EQ(flight.timeOfImpact(at(btScalar(NAN), -4.5, 0), at(0, 0, 0)), 1);
}

// Ten are between the faces; a ball, a capsule and a hull are met with their radii.
TEST(TimeOfImpact, OfABoxAndConvexShapes)
{
	for (int kind = 0; kind < 4; ++kind)
		for (const bool oursFirst : {true, false})
		{
			Flight flight;
			btClodShape& box = flight.scene.addShape(patchHierarchy(boxMesh({1, 1, 1}, {2, 2, 2}, 1)));
			std::unique_ptr<btConvexShape> convex;
			const btVector3 half(btScalar(0.3), btScalar(0.3), btScalar(0.3));
			if (kind == 0) convex = std::make_unique<btSphereShape>(btScalar(0.5));
			if (kind == 1) convex = std::make_unique<btCapsuleShapeX>(btScalar(0.2), btScalar(0.6));
			if (kind == 2)
				convex = std::make_unique<btBoxShape>(btVector3(btScalar(0.5), btScalar(0.3), btScalar(0.3)));
			if (kind == 3)
			{
				auto hull = std::make_unique<btConvexHullShape>();
				for (int i = 0; i < 8; ++i)
					hull->addPoint(half * btVector3(btScalar((i & 1) != 0 ? 1 : -1), btScalar((i & 2) != 0 ? 1 : -1),
													btScalar((i & 4) != 0 ? 1 : -1)));
				hull->setMargin(btScalar(0.2));
				convex = std::move(hull);
			}
			btConvexShape& shape = flight.scene.add(std::move(convex));
			const auto fly = [&](const btTransform& boxTo, const btTransform& convexTo)
			{ return oursFirst ? flight.timeOfImpact(boxTo, convexTo) : flight.timeOfImpact(convexTo, boxTo); };
			btRigidBody& ours = flight.scene.addBody(box, 1, {0, 0, 0});
			btRigidBody& theirs = flight.scene.addBody(shape, 1, {11, 0.2, 0.1});
			flight.first = oursFirst ? &ours : &theirs;
			flight.second = oursFirst ? &theirs : &ours;
			EXPECT_NEAR(fly(at(15, 0, 0), at(-14, 0.2, 0.1)), 0.25, 2e-3) << kind;
			EXPECT_LE(fly(at(15, 0, 0), at(-14, 0.2, 0.1)), 0.25) << kind;
			EXPECT_EQ(fly(at(-15, 0, 0), at(14, 0.2, 0.1)), 1) << kind;
			EXPECT_EQ(fly(at(0, 20, 0), at(11, 20.2, 0.1)), 1) << kind;
			EXPECT_EQ(fly(at(22, 0, 0), at(0, 3.2, 0.1)), 1) << kind;
		}
}

// A child goes with its body, and meets where it is: 8 are between the faces of these two, or 9 to a box alone.
TEST(TimeOfImpact, OfChildrenOfCompounds)
{
	for (const bool isOfTwo : {true, false})
		for (const bool isNested : {true, false})
		{
			Flight flight;
			btClodShape& box = flight.scene.addShape(patchHierarchy(boxMesh({1, 1, 1}, {2, 2, 2}, 1)));
			auto& behind = flight.scene.add(std::make_unique<btCompoundShape>());
			auto& inner = flight.scene.add(std::make_unique<btCompoundShape>());
			auto& outer = flight.scene.add(std::make_unique<btCompoundShape>());
			behind.addChildShape(at(-1, 0, 0), &box);
			behind.addChildShape(at(-1, 7, 0), &box);
			inner.addChildShape(at(1, 0, 0), &box);
			outer.addChildShape(at(0, 0, 0), isNested ? static_cast<btCollisionShape*>(&inner) : &box);
			flight.first = &flight.scene.addBody(outer, 1, {isNested ? 0.0 : 1.0, 0, 0});
			flight.second =
				isOfTwo ? &flight.scene.addBody(behind, 1, {11, 0, 0}) : &flight.scene.addBody(box, 1, {11, 0, 0});
			flight.scene.world.getDispatchInfo().m_timeStep = 1;
			const double start = isNested ? 0 : 1, apart = isOfTwo ? 8 : 9;
			EXPECT_NEAR(flight.timeOfImpact(at(start + 20, 0, 0), at(11 - 20, 0, 0)), apart / 40, 2e-3)
				<< isOfTwo << isNested;
			EXPECT_EQ(flight.timeOfImpact(at(start - 20, 0, 0), at(11 + 20, 0, 0)), 1) << isOfTwo << isNested;
			// Half a turn about its own middle carries a child to the other side.
			if (!isNested) continue;
			EXPECT_EQ(flight.timeOfImpact(at(apart + 1.5, 0, 0, 3), at(11, 0, 0)), 1) << isOfTwo;
			EXPECT_LT(flight.timeOfImpact(at(apart + 1.5, 0, 0), at(11, 0, 0)), 1) << isOfTwo;
		}
}

// Random ways, turns of up to a whole radian: where the exact gap first vanishes along the way, looked at from pose to
// pose. Of models alike in size, and of a rod that flies and turns by a plate, far from its middle, whichever of the
// two is A.
TEST(TimeOfImpact, OfBodiesThatFlyAndTurn)
{
	Random random(7);
	constexpr int kPoses = 20;
	int met = 0, missed = 0, early = 0;
	std::vector<std::pair<Body, Body>> flights{{body("torus-900"), body("number8-600")},
											   {body("cup-3000"), body("spoon-3000")}};
	for (const int cells : {1, 2, 3, 4})
		flights.push_back({bodyOf("plate", patchHierarchy(boxMesh({40, 1, 40}, {8, 1, 8}, 1))),
						   bodyOf("rod", patchHierarchy(boxMesh({0.4, 0.05, 0.05}, {cells, 1, 1}, 1)))});
	for (const auto& bodies : flights)
		for (int i = 0; i < 30; ++i)
		{
			const Body &a = bodies.first, &b = bodies.second;
			const double radius = smallerRadius(a, b);
			Flight flight;
			flight.scene.context.worldMetric = ContactMetric::exactly();
			flight.first = &flight.scene.addBody(flight.scene.addShape(a.hierarchy), 1, {0, 0, 0});
			flight.second = &flight.scene.addBody(flight.scene.addShape(b.hierarchy), 1, {0, 0, 0});
			const Transform pose = poseWithGap(random, a, b, uniform(random, 0.02, 0.2));
			const auto& [x, y, z] = pose.rotation.row;
			const btTransform start(
				btMatrix3x3(btScalar(x.x), btScalar(x.y), btScalar(x.z), btScalar(y.x), btScalar(y.y), btScalar(y.z),
							btScalar(z.x), btScalar(z.y), btScalar(z.z)),
				toBullet(pose.translation));
			flight.second->setWorldTransform(start);
			const auto turnOf = [&](double most)
			{
				const btVector3 axis = toBullet(randomDirection(random));
				return btQuaternion(axis, btScalar(uniform(random, 0, most)));
			};
			// A large body that turns sweeps the small one away at once.
			const bool isLarge = double(a.hierarchy->asset().radius) > 5 * radius;
			const btQuaternion turnA = turnOf(isLarge ? 0
											  : i % 2 ? 1
													  : 0.1),
							   turnB = turnOf(i % 3 ? 0.5 + isLarge : 0.02);
			const btVector3 linear = toBullet(randomVector(random, 0, 1.4 * radius));
			const auto firstAt = [&](double share)
			{ return btTransform(btQuaternion::getIdentity().slerp(turnA, btScalar(share))); };
			const auto secondAt = [&](double share)
			{
				return btTransform(btQuaternion::getIdentity().slerp(turnB, btScalar(share)) * start.getRotation(),
								   start.getOrigin() + btScalar(share) * linear);
			};
			const auto gapAt = [&](double share)
			{
				Settings settings = exactSettings(0);
				settings.distance = true;
				return fresh({a, b}, toTransform(firstAt(share).inverse() * secondAt(share)), settings).minDistance /
					   radius;
			};
			const double impact = flight.timeOfImpact(firstAt(1), secondAt(1));
			// Nothing is passed over: to the rounding of poses far from the middle.
			for (int k = 0; double(k) / kPoses < impact; ++k)
				ASSERT_GT(gapAt(double(k) / kPoses), -1e-4) << a.name << i;
			const double left = impact < 1 ? gapAt(impact) : 0;
			EXPECT_GT(left, -1e-4) << a.name << i;
			EXPECT_LT(left, 5e-3) << a.name << i;  // where steps creep along a grazing way
			early += left > 1.1e-3;
			++(impact < 1 ? met : missed);
		}
	EXPECT_GT(met, 40);
	EXPECT_GT(missed, 40);
	EXPECT_LT(early, 10);
}

// A small rod that turns flies at the end of a long bar, far from the bar's middle: the face at 50 is met after 0.3 of
// 0.5.
TEST(TimeOfImpact, OfARodAndTheEndOfALongBar)
{
	int barIsA = 0;
	for (int cells = 1; cells < 13; ++cells)
	{
		const auto ofBar = patchHierarchy(boxMesh({100, 1, 1}, {cells, 1, 1}, 1));
		const auto ofRod = patchHierarchy(boxMesh({0.05, 0.05, 0.4}, {1, 1, 13 - cells}, 1));
		const double ahead = 0.325 + 0.005 * cells;
		barIsA += ofBar->contentHash() < ofRod->contentHash();
		Flight flight;
		flight.scene.context.worldMetric = ContactMetric::exactly();
		flight.first = &flight.scene.addBody(flight.scene.addShape(ofBar), 1, {0, 0, 0});
		flight.second = &flight.scene.addBody(flight.scene.addShape(ofRod), 1, {50 + ahead, 0, 0});
		// Turned about its own length by half a radian, it is wider by its edges.
		const double share = flight.timeOfImpact(at(0, 0, 0), at(49.5 + ahead, 0, 0, 0.5)), turn = 0.5 * share;
		const double gap = ahead - 0.5 * share - 0.025 * (std::cos(turn) + std::sin(turn));
		EXPECT_GT(gap, 0) << cells;
		EXPECT_LT(gap, 3e-4) << cells;
	}
	EXPECT_GT(barIsA, 0);
	EXPECT_LT(barIsA, 12);
}

// A bullet that spins fast, on a long way past nothing, meets nothing.
TEST(TimeOfImpact, OfASpinningBulletThatMeetsNothing)
{
	Flight flight;
	btClodShape& bullet = flight.scene.addShape(patchHierarchy(boxMesh({0.02, 0.01, 0.01}, {2, 1, 1}, 1)));
	btClodShape& box = flight.scene.addShape(patchHierarchy(boxMesh({1, 1, 1}, {2, 2, 2}, 1)));
	flight.first = &flight.scene.addBody(bullet, 1, {0, 3, 0});
	flight.second = &flight.scene.addBody(box, 1, {5, 0, 0});
	EXPECT_EQ(flight.timeOfImpact(at(20, 3, 0, 1.7), at(5, 0, 0)), 1);
	EXPECT_NEAR(flight.timeOfImpact(at(20, -9, 0, 1.7), at(5, 0, 0)), 0.25, 0.03);
}

TEST(TimeOfImpact, WhatTouchesAlreadyIsLeftToItsContacts)
{
	Flight flight;
	btClodShape& box = flight.scene.addShape(patchHierarchy(boxMesh({1, 1, 1}, {2, 2, 2}, 1)));
	flight.first = &flight.scene.addBody(box, 1, {0, 0, 0});
	flight.second = &flight.scene.addBody(box, 1, {1, 0, 0});
	EXPECT_EQ(flight.timeOfImpact(at(1, 0, 0), at(0, 0, 0)), 1);
}

namespace
{
// A ball without spin over a slab, turned so that a coarse level lies back from the surface by some of its size. It
// falls at a speed that takes it, within a step, to where only the surface would overlap the slab; half-way there it
// asks for full resolution.
struct SwitchAtImpact
{
	static constexpr double kWay = 0.1, kRate = 60;
	BulletWorld scene{true};
	btRigidBody *slab = nullptr, *ball = nullptr;
	ContactMetric coarse = ContactMetric::errorShare(0.1);
	double lag = 0;  // between the two surfaces
	double start = 0;

	explicit SwitchAtImpact(double restitution)
	{
		scene.timeStep = 1 / kRate;
		configureWorld(scene.world);
		scene.world.setGravity({0, 0, 0});
		dynamic_cast<btClodDynamicsWorld&>(scene.world).setStepping(btClodDynamicsWorld::Stepping::kImpacts);
		btClodShape& shape = scene.addShape(body("sphere-300").hierarchy, 1);
		slab = &scene.addBody(scene.addShape(patchHierarchy(boxMesh({10, 1, 10}, {2, 1, 2}, 1))), 0, {0, -0.5, 0});
		ball = &scene.addBody(shape, 1, {0, 3, 0});
		for (btRigidBody* one : {slab, ball}) one->setFriction(0);
		slab->setRestitution(1);
		ball->setRestitution(btScalar(restitution));
		ball->setAngularFactor(0);
		ball->setDamping(0, 0);
		btQuaternion best = ball->getWorldTransform().getRotation();
		for (int i = 0; i < 24; ++i)
		{
			ball->getWorldTransform().setRotation(
				btQuaternion(btVector3(1, 0.3f, 0.1f).normalized(), btScalar(0.13 * i)));
			const double here = gap(coarse, 3) - gap(ContactMetric::exactly(), 3);
			if (here <= lag) continue;
			lag = here;
			best = ball->getWorldTransform().getRotation();
		}
		ball->getWorldTransform().setRotation(best);
		start = 3 - gap(coarse, 3) + kWay + 0.5 * lag;
		ball->getWorldTransform().getOrigin().setY(btScalar(start));
		ball->setLinearVelocity(btVector3(0, btScalar(-kWay * kRate), 0));
		scene.context.pairMetric = [this](const btCollisionObject&, const btCollisionObject&, ContactMetric& metric)
		{
			metric = heightOf(*ball) < start - 0.5 * kWay ? ContactMetric::exactly() : coarse;
			return true;
		};
	}
	// Of the surfaces that a metric allows, the ball at that height.
	double gap(const ContactMetric& metric, double height) const
	{
		const auto& a = static_cast<const btClodShape&>(*slab->getCollisionShape());
		const auto& b = static_cast<const btClodShape&>(*ball->getCollisionShape());
		btTransform there = ball->getWorldTransform();
		there.getOrigin().setY(btScalar(height));
		GapSettings settings;
		MetricFrame frame;
		frame.radius = 1;
		settings.metric = resolve(metric, frame);
		settings.tolerance = 4;
		PairCache cache;
		ContactResult result;
		contacts(*a.inWorldLengths(), *b.inWorldLengths(),
				 inverse(toTransform(slab->getWorldTransform())) * toTransform(there), settings, cache, result);
		double nearest = 4;
		for (const Contact& contact : result.contacts) nearest = std::min(nearest, contact.lower);
		return nearest;
	}
	bool isCoarse() const
	{
		bool is = false;
		scene.context.forEachPair([&](const PairReport& pair) { is = !pair.metric.exact; });
		return is;
	}
};
}  // namespace

// What a solver corrects by positions stays corrected while the end of a step is looked at.
TEST(SwitchImpact, LooksAheadWithoutATrace)
{
	for (const bool atImpacts : {false, true})
	{
		BulletWorld scene(true);
		configureWorld(scene.world);
		scene.world.setGravity({0, 0, 0});
		if (atImpacts)
			dynamic_cast<btClodDynamicsWorld&>(scene.world).setStepping(btClodDynamicsWorld::Stepping::kImpacts);
		const btRigidBody& lower = scene.addBody(scene.addShape(cube()), 1, {0, 0, 0});
		const btRigidBody& upper = scene.addBody(scene.addShape(cube()), 1, {0, 0.98, 0});
		scene.step(60);
		EXPECT_GT(heightOf(upper) - heightOf(lower), 0.9995) << atImpacts;
	}
}

// Neither level alone has an impact to look for: one never meets the slab, the other is in it already once it is asked
// for. Its time is where the separation of the one and the depth of the other cancel.
TEST(SwitchImpact, HasTheTimeBetweenTheSeparationAndTheDepth)
{
	SwitchAtImpact fall(1);
	ASSERT_GT(fall.lag, 0.01);
	const double separation = SwitchAtImpact::kWay + 0.5 * fall.lag, depth = 0.5 * fall.lag;
	const double share = separation / (separation + depth);
	fall.scene.step();
	EXPECT_NEAR(double(fall.ball->getLinearVelocity().y()), SwitchAtImpact::kWay * SwitchAtImpact::kRate, 0.01);
	EXPECT_NEAR(heightOf(*fall.ball), fall.start + (1 - 2 * share) * SwitchAtImpact::kWay, 0.01 * SwitchAtImpact::kWay);
}

// It parts slowly: the fine level would find it in the slab for some steps.
TEST(SwitchImpact, IsNotRefinedUntilTheFinerLevelIsApartToo)
{
	SwitchAtImpact fall(0.015);
	int held = 0, apart = 0;
	for (int i = 0; i < 60; ++i)
	{
		const double before = heightOf(*fall.ball);
		fall.scene.step();
		if (i == 0) continue;
		ASSERT_GT(double(fall.ball->getLinearVelocity().y()), 0) << i;
		const bool isApart = fall.gap(ContactMetric::exactly(), before) > 0;
		if (before > fall.start - 0.5 * SwitchAtImpact::kWay) break;
		EXPECT_EQ(fall.isCoarse(), !isApart) << i;
		++(isApart ? apart : held);
	}
	EXPECT_GT(held, 2);
	EXPECT_GT(apart, 2);
}

// One that comes to rest there is let down onto the surface that is asked for: the metric stays a hard limit.
TEST(SwitchImpact, WhatDoesNotPartIsRefinedAtOnce)
{
	SwitchAtImpact fall(0);
	fall.scene.world.setGravity(btVector3(0, btScalar(-9.81), 0));
	fall.scene.step();
	EXPECT_TRUE(fall.isCoarse());
	EXPECT_LT(std::abs(double(fall.ball->getLinearVelocity().y())), 0.01);
	double fastest = 0;
	for (int i = 0; i < 240; ++i)
	{
		fall.scene.step();
		EXPECT_FALSE(fall.isCoarse()) << i;
		fastest = std::max(fastest, std::abs(double(fall.ball->getLinearVelocity().y())));
	}
	EXPECT_LT(fastest, 0.1);
	EXPECT_GT(fall.gap(ContactMetric::exactly(), heightOf(*fall.ball)), -1e-3);
}
}  // namespace clod::test
