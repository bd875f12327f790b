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
