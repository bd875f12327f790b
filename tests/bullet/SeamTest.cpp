// SPDX-License-Identifier: GPL-3.0-or-later
// Borders that a moving body must not feel: between static bodies that lie flush, children of a compound, and the facets of
// a curved ground, where it may feel their angle and no more.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "clod/bullet/ConfigureWorld.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
btTransform at(double x, double y, double z)
{
	return btTransform(btQuaternion::getIdentity(), btVector3(btScalar(x), btScalar(y), btScalar(z)));
}

struct Mover
{
	const char* name;
	std::function<btCollisionShape&(BulletWorld&)> make;
	double height;  // of its origin over flat ground
};
const std::vector<Mover>& movers()
{
	static const std::vector<Mover> all = {
		{"box",
		 [](BulletWorld& scene) -> btCollisionShape&
		 { return scene.add(std::make_unique<btBoxShape>(btVector3(btScalar(0.4), btScalar(0.2), btScalar(0.3)))); },
		 0.2},
		{"sphere",
		 [](BulletWorld& scene) -> btCollisionShape& { return scene.add(std::make_unique<btSphereShape>(btScalar(0.3))); },
		 0.3},
		{"capsule",
		 [](BulletWorld& scene) -> btCollisionShape&
		 { return scene.add(std::make_unique<btCapsuleShapeX>(btScalar(0.2), btScalar(0.4))); },
		 0.2},
		{"ours",
		 [](BulletWorld& scene) -> btCollisionShape&
		 { return scene.addShape(patchHierarchy(boxMesh({0.8, 0.4, 0.6}, {3, 2, 2}, 1))); },
		 0.2}};
	return all;
}

// Slides over the ground's upper side, at height 0, from x = -4 to 4 at 4 m/s. Without friction: how much slower, how much
// up and down.
struct Ride
{
	double slower, bump;
};
// aside: by so much later. Where it rolls, with friction.
Ride ride(const Mover& mover, int rate, double aside, bool rolls, const std::function<void(BulletWorld&)>& addGround)
{
	BulletWorld scene;
	configureWorld(scene.world);
	scene.timeStep = 1.0 / rate;
	addGround(scene);
	for (const auto& ground : scene.bodies) ground->setFriction(rolls ? 1 : 0);
	btRigidBody& body = scene.addBody(mover.make(scene), 1, {-4 - aside, mover.height + 0.0005, 0.1});
	body.setFriction(rolls ? 1 : 0);
	body.setLinearVelocity(btVector3(4, 0, 0));
	if (rolls) body.setAngularVelocity(btVector3(0, 0, btScalar(-4 / mover.height)));
	scene.step(rate / 6);
	double low = heightOf(body), high = low;
	for (int i = 0; i < 11 * rate / 6; ++i)
	{
		scene.step();
		low = std::min(low, heightOf(body));
		high = std::max(high, heightOf(body));
	}
	return {4 - double(body.getLinearVelocity().x()), high - low};
}
// Wherever in a step it crosses the border. Over two flush boxes of Bullet's own a box of Bullet's stops, and a ball loses 0.06 m/s
// and jumps 8 mm at 1/60 s.
void expectSmooth(const std::function<void(BulletWorld&)>& addGround, bool oursOnly = false)
{
	constexpr int kPhases = 8;
	for (const Mover& mover : movers())
		for (const int rate : {240, 60})
			for (int phase = 0; phase < 2 * kPhases; ++phase)
			{
				if (oursOnly && std::string(mover.name) != "ours") continue;
				const bool rolls = phase >= kPhases;
				if (rolls && std::string(mover.name) != "sphere") continue;
				const Ride felt = ride(mover, rate, phase % kPhases * 4.0 / (rate * kPhases), rolls, addGround);
				EXPECT_LT(felt.slower, 0.001) << mover.name << " at " << rate << ", " << phase;
				EXPECT_LT(felt.bump, 1e-5) << mover.name << " at " << rate << ", " << phase;
			}
}
// What ground may be made of: a plate at x, its upper side at height 0, 3 long.
using AddPlate = std::function<void(BulletWorld&, double x)>;
constexpr double kPlate = 3;
const std::shared_ptr<const Hierarchy>& plate()
{
	static const std::shared_ptr<const Hierarchy> one = patchHierarchy(boxMesh({kPlate, 1, 10}, {1, 1, 1}, 1));
	return one;
}
void addOurs(BulletWorld& scene, double x)
{
	scene.addBody(scene.addShape(plate()), 0, {x, -0.5, 0});
}
void addBox(BulletWorld& scene, double x)
{
	scene.addBody(scene.add(std::make_unique<btBoxShape>(btVector3(btScalar(kPlate / 2), btScalar(0.5), 5))), 0, {x, -0.5, 0});
}
void addMesh(BulletWorld& scene, double x)
{
	static const Bvh bvh(*plate());
	scene.addBody(*bvh.shape, 0, {x, -0.5, 0});
}
void addPlane(BulletWorld& scene, double)
{
	scene.addBody(scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0))), 0, {});
}
const std::vector<Mover>& curvedMovers()
{
	const auto moverOf = [](const char* name, const std::shared_ptr<const Hierarchy>& hierarchy)
	{
		const double scale = 0.3 / double(hierarchy->asset().radius);
		double lowest = 0;
		for (const std::array<Vec3, 3>& triangle : inputTriangles(*hierarchy))
			for (const Vec3& corner : triangle) lowest = std::min(lowest, scale * corner.y);
		const auto make = [=](BulletWorld& scene) -> btCollisionShape&
		{
			btClodShape& shape = scene.addShape(hierarchy);
			shape.setLocalScaling(btVector3(btScalar(scale), btScalar(scale), btScalar(scale)));
			return shape;
		};
		return Mover{name, make, -lowest};
	};
	static const std::vector<Mover> all = {moverOf("ball", patchHierarchy(ballMesh(1, 3))),
										   moverOf("torus", body("torus", 900).hierarchy)};
	return all;
}
}  // namespace

TEST(Seam, FlushStaticBodiesAreOneGround)
{
	expectSmooth(
		[](BulletWorld& scene)
		{
			btClodShape& plate = scene.addShape(slab());
			for (const double x : {-5.0, 5.0}) scene.addBody(plate, 0, {x, -0.5, 0});
		});
}

// Curved bodies touch edges beside them aslant.
TEST(Seam, CurvedBodiesPassOverFlushPlates)
{
	const std::vector<std::pair<AddPlate, AddPlate>> grounds = {
		{addOurs, addOurs}, {addBox, addBox}, {addMesh, addMesh}, {addOurs, addMesh}, {addBox, addPlane}};
	for (const Mover& mover : curvedMovers())
		for (std::size_t ground = 0; ground < grounds.size(); ++ground)
			for (const int rate : {240, 60})
				for (const double phase : {0.1, 0.7})
				{
					const std::string what = std::string(mover.name) + " on " + std::to_string(ground) + " at " +
											 std::to_string(rate) + ", " + std::to_string(phase);
					const Ride felt = ride(mover, rate, 4 * phase / rate, false,
										   [&](BulletWorld& scene)
										   {
											   for (int i = -2; i <= 2; ++i)
												   (i % 2 == 0 ? grounds[ground].first : grounds[ground].second)(scene, kPlate * i);
										   });
					EXPECT_LT(felt.slower, 0.001) << what;
					EXPECT_LT(felt.bump, 2e-5) << what;
				}
}

// A board of two plates, one compound, slides over fixed balls.
TEST(Seam, ChildrenOfAMovingCompoundAreOneBoard)
{
	for (const int rate : {240, 60})
	{
		BulletWorld scene;
		configureWorld(scene.world);
		scene.timeStep = 1.0 / rate;
		const Mover& ball = curvedMovers()[0];
		for (const double x : {-1.2, 0.0, 1.2})
			for (const double z : {-2.0, 2.0}) scene.addBody(ball.make(scene), 0, {x, -ball.height, z}).setFriction(0);
		btClodShape& plate = scene.addShape(patchHierarchy(boxMesh({kPlate, 0.2, 6}, {1, 1, 1}, 1)));
		auto& board = scene.add(std::make_unique<btCompoundShape>());
		for (const double x : {-kPlate / 2, kPlate / 2}) board.addChildShape(at(x, 0, 0), &plate);
		btRigidBody& body = scene.addBody(board, 1, {-0.41, 0.1002, 0});
		body.setFriction(0);
		scene.step(rate / 6);
		body.setLinearVelocity(btVector3(4, 0, 0));
		for (int i = 0; i < rate / 5; ++i)
		{
			scene.step();
			ASSERT_LT(std::abs(double(body.getLinearVelocity().y())), 0.01) << rate << ", " << i;
		}
		EXPECT_GT(double(body.getLinearVelocity().x()), 3.999) << rate;
		EXPECT_GT(double(body.getWorldTransform().getOrigin().x()), 0.3) << rate;
	}
}

// Two platforms that a program moves alike, under a ball that stays where it is.
TEST(Seam, PlatformsThatMoveAlikeAreOneGround)
{
	for (const int rate : {240, 60})
	{
		BulletWorld scene;
		configureWorld(scene.world);
		scene.timeStep = 1.0 / rate;
		for (const double x : {0.0, kPlate}) addOurs(scene, x);
		for (const auto& platform : scene.bodies)
		{
			platform->setFriction(0);
			platform->setCollisionFlags(platform->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
		}
		btRigidBody& ball = scene.addBody(curvedMovers()[0].make(scene), 1, {0.77, curvedMovers()[0].height + 0.0005, 0.1});
		ball.setFriction(0);
		scene.step(rate / 6);
		for (int i = 0; i < rate / 2; ++i)
		{
			for (std::size_t k = 0; k < 2; ++k)
				scene.bodies[k]->setWorldTransform(at(kPlate * double(k) - 4.0 * (i + 1) / rate, -0.5, 0));
			scene.step();
			ASSERT_LT(double(ball.getLinearVelocity().length()), 0.01) << rate << ", " << i;
		}
	}
}

// Bodies far from the origin lie as flush as floats allow.
TEST(Seam, FarPlatesAreFlushToRounding)
{
	const std::shared_ptr<const Hierarchy> plate = patchHierarchy(boxMesh({3.3, 1, 10}, {1, 1, 1}, 1)), ball = patchHierarchy(ballMesh(0.05, 3));
	for (const int rate : {240, 60})
	{
		BulletWorld scene;
		configureWorld(scene.world);
		scene.timeStep = 1.0 / rate;
		btClodShape& shape = scene.addShape(plate);
		for (int i = 0; i < 4; ++i) scene.addBody(shape, 0, {151.7 + 3.3 * i, 87.3, 0}).setFriction(0);
		btRigidBody& body = scene.addBody(scene.addShape(ball), 1, {151.3, 87.8 + 0.0502, 0.1});
		body.setFriction(0);
		scene.step(rate / 6);
		body.setLinearVelocity(btVector3(4, 0, 0));
		for (int i = 0; i < 2 * rate; ++i)
		{
			scene.step();
			ASSERT_LT(std::abs(double(body.getLinearVelocity().y())), 0.02) << rate << ", " << i;
		}
		EXPECT_GT(double(body.getLinearVelocity().x()), 3.999) << rate;
	}
}

// Only what lies flush covers anything, and only while it is there and pushes.
TEST(Seam, WhatIsNoSeamIsFelt)
{
	const Mover& sphere = movers()[1];
	const auto speedAfter = [&](const std::function<void(BulletWorld&)>& addGround)
	{ return 4 - ride(sphere, 60, 0, false, addGround).slower; };
	const double step = speedAfter(
		[](BulletWorld& scene)
		{
			for (const double x : {-4.5, -1.5}) addOurs(scene, x);
			addOurs(scene, 1.5);
			scene.bodies.back()->translate(btVector3(0, btScalar(0.003), 0));
		});
	EXPECT_LT(step, 3.95);
	const double wall = speedAfter(
		[](BulletWorld& scene)
		{
			for (const double x : {-4.5, -1.5, 1.5}) addOurs(scene, x);
			scene.addBody(scene.add(std::make_unique<btBoxShape>(btVector3(btScalar(0.5), btScalar(0.5), 5))), 0, {2.5, 0.5, 0});
		});
	EXPECT_LT(wall, 0.1);
}

// What rolls off an edge touches it as if nothing lay beside it, where that does not push, or is there no longer.
TEST(Seam, WhatDoesNotPushHidesNoEdge)
{
	enum class Beside
	{
		kNothing,
		kSensor,
		kGone
	};
	const auto pathWith = [](Beside beside)
	{
		BulletWorld scene;
		configureWorld(scene.world);
		addOurs(scene, -1.5);
		if (beside != Beside::kNothing) addOurs(scene, 1.5);
		btRigidBody& ball = scene.addBody(curvedMovers()[0].make(scene), 1, {-0.2, curvedMovers()[0].height + 0.0001, 0.1});
		if (beside == Beside::kSensor)
			scene.bodies[1]->setCollisionFlags(scene.bodies[1]->getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
		scene.step(60);
		if (beside == Beside::kGone) scene.world.removeRigidBody(scene.bodies[1].get());
		ball.setLinearVelocity(btVector3(btScalar(1.5), 0, 0));
		std::vector<double> path;
		for (int i = 0; i < 240; ++i)
		{
			scene.step();
			path.push_back(heightOf(ball));
		}
		return path;
	};
	const std::vector<double> alone = pathWith(Beside::kNothing), sensor = pathWith(Beside::kSensor), gone = pathWith(Beside::kGone);
	EXPECT_LT(alone.back(), -0.5);
	for (std::size_t i = 0; i < alone.size(); ++i)
	{
		ASSERT_NEAR(sensor[i], alone[i], 1e-5) << i;
		ASSERT_NEAR(gone[i], alone[i], 1e-5) << i;
	}
}

// Four plates meet in a corner, that balls pass over.
TEST(Seam, NoCornerIsFeltWhereFourPlatesMeet)
{
	const std::vector<Mover> balls = {curvedMovers()[0], movers()[1]};
	for (const Mover& mover : balls)
		for (const int rate : {240, 60})
		{
			const auto addGround = [](BulletWorld& scene)
			{
				for (int i = -2; i <= 2; ++i)
					for (const double z : {-4.9, 5.1})
					{
						addOurs(scene, kPlate * i);
						scene.bodies.back()->translate(btVector3(0, 0, btScalar(z)));
					}
			};
			const Ride felt = ride(mover, rate, 0.3 / rate, false, addGround);
			EXPECT_LT(felt.slower, 0.001) << mover.name << " at " << rate;
			EXPECT_LT(felt.bump, 2e-5) << mover.name << " at " << rate;
		}
}

// Beside one of Bullet's boxes, whose pairs with Bullet's other shapes are not ours.
TEST(Seam, ABodyOfOursAndABoxAreOneGround)
{
	expectSmooth(
		[](BulletWorld& scene)
		{
			scene.addBody(scene.addShape(slab()), 0, {-5, -0.5, 0});
			scene.addBody(scene.add(std::make_unique<btBoxShape>(btVector3(5, btScalar(0.5), 5))), 0, {5, -0.5, 0});
		},
		true);
}

TEST(Seam, ChildrenOfACompoundAreOneGround)
{
	expectSmooth(
		[](BulletWorld& scene)
		{
			btClodShape& plate = scene.addShape(slab());
			auto& compound = scene.add(std::make_unique<btCompoundShape>());
			for (const double x : {-5.0, 5.0}) compound.addChildShape(at(x, -0.5, 0), &plate);
			scene.addBody(compound, 0, {});
		});
}

// A compound refreshes its children's points before they are asked: those of what has moved on keep their impulses all the same.
TEST(Seam, ImpulsesFollowWhatMovesOverACompound)
{
	BulletWorld scene;
	scene.timeStep = 1.0 / 60;
	auto& compound = scene.add(std::make_unique<btCompoundShape>());
	compound.addChildShape(at(0, -0.5, 0), &scene.addShape(slab()));
	scene.addBody(compound, 0, {}).setFriction(0);
	btRigidBody& body = scene.addBody(movers()[1].make(scene), 1, {-4, 0.3005, 0.1});
	body.setLinearVelocity(btVector3(4, 0, 0));
	scene.step(30);
	scene.world.performDiscreteCollisionDetection();
	double carried = 0;
	for (int i = 0; i < scene.dispatcher.getNumManifolds(); ++i)
		for (int k = 0; k < scene.dispatcher.getManifoldByIndexInternal(i)->getNumContacts(); ++k)
			carried += double(scene.dispatcher.getManifoldByIndexInternal(i)->getContactPoint(k).m_appliedImpulse);
	EXPECT_NEAR(carried, 9.81 / 60, 1e-3);
}

// A trough of facets one long, of a radius of 20: what crosses from one to the next feels their angle and no more. (On a ridge
// a body with a flat side falls from facet to facet; a ball does not.)
TEST(Seam, OfACurvedGroundTheAngleOfItsFacetsIsFelt)
{
	constexpr double kRadius = 20;
	for (const bool isTrough : {true, false})
	{
		PatchedMesh mesh = boxMesh({20, 2, 4}, {20, 1, 8}, 1);
		for (Vec3& v : mesh.vertices)
			if (v.y > 0)
			{
				const double sagitta = kRadius - std::sqrt(kRadius * kRadius - v.x * v.x);
				v.y += isTrough ? sagitta : 3 - sagitta;
			}
		for (const Mover& mover : movers())
			for (const int rate : {240, 60})
			{
				if (!isTrough && std::string(mover.name) != "sphere") continue;
				BulletWorld scene;
				scene.timeStep = 1.0 / rate;
				btClodShape& shape = scene.addShape(patchHierarchy(mesh));
				btRigidBody& ground = scene.addBody(shape, 0, {});
				ground.setWorldTransform(shape.meshFromBody());
				ground.setFriction(0);
				btRigidBody& body = scene.addBody(mover.make(scene), 1, {0.5, (isTrough ? 1.0 : 4.0) + mover.height + 0.02, 0.1});
				body.setFriction(0);
				scene.step(rate / 4);
				body.setLinearVelocity(btVector3(4, 0, 0));
				int crossed = 0;
				for (int i = 0; i < rate; ++i)
				{
					const btVector3 before = body.getLinearVelocity();
					scene.step();
					const double x = double(body.getWorldTransform().getOrigin().x()), speed = double(before.length());
					const double angle = 1.02 / std::sqrt(kRadius * kRadius - (x + 1) * (x + 1));
					// Its weight, and what leads it along the curve, are no bump.
					const double steady = (9.81 + speed * speed / kRadius) * scene.timeStep;
					EXPECT_LT(double((body.getLinearVelocity() - before).length()), 1.1 * speed * angle + steady)
						<< mover.name << (isTrough ? ", trough" : ", ridge") << " at " << rate << ", x " << x;
					crossed = std::max(crossed, int(x));
				}
				EXPECT_GE(crossed, 2);
				EXPECT_LT(std::abs(double(body.getLinearVelocity().z())), 0.01) << mover.name;
			}
	}
}
}  // namespace clod::test
