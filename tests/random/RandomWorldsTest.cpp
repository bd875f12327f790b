// SPDX-License-Identifier: GPL-3.0-or-later
// Worlds that nobody has thought of: seeded piles of our bodies, stretched, mirrored, in compounds, beside Bullet's convex
// shapes, on every kind of ground, at every metric and step. Nothing is lost, stands still for ever or flies off by itself.
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clod/bullet/ConfigureWorld.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/query/Bodies.h"
#include "tests/query/Questions.h"

namespace clod::test
{
namespace
{
constexpr double kGravity = 9.81;
constexpr double kHalfGround = 40;  // of the bodies' size
constexpr double kMostGain = 0.1;   // of the energy of all bodies lifted by their size
constexpr const char* kModels[] = {"cup-3000", "spoon-3000", "torus-900", "number8-600", "ring", "rod", "plate", "box-12", "sphere-300"};

class RandomWorld
{
public:
	explicit RandomWorld(std::uint64_t seed)
		: m_random(seed), m_rate(std::array{60.0, 120.0, 240.0}[pick(3)]), m_size(std::array{0.1, 0.5, 1.0}[pick(3)]), m_scene(pick(2) == 1)
	{
		m_scene.timeStep = 1 / m_rate;
		const ContactMetric metrics[] = {ContactMetric::exactly(), ContactMetric::errorShare(0.005), ContactMetric::errorShare(0.03),
										 ContactMetric::deviationShare(0.035)};
		m_scene.context.worldMetric = metrics[pick(4)];
		configureWorld(m_scene.world);
		putGround();
		double top = m_size;
		for (std::size_t i = 0, count = 2 + pick(6); i < count; ++i)
		{
			const double radius = m_size * between(0.8, 1.4);
			top += 1.05 * radius;
			putBody(radius, top);
			top += 1.05 * radius;
		}
	}
	// Empty, or what went wrong first.
	std::string run(double seconds)
	{
		double lowest = energy();
		const double start = lowest;
		for (int step = 0; step < int(seconds * m_rate); ++step)
		{
			m_scene.step();
			const double now = energy();
			const std::string when = " in step " + std::to_string(step);
			if (!std::isfinite(now)) return "not finite" + when;
			if (now - lowest > kMostGain * m_weight * m_size) return "energy is made" + when;
			lowest = std::min(lowest, now);
			for (const Moving& moving : m_moving)
			{
				const btVector3& at = moving.body->getWorldTransform().getOrigin();
				const bool isOverGround = std::max(std::abs(at.x()), std::abs(at.z())) < 0.9 * kHalfGround * m_size;
				if (moving.isOurs && isOverGround && at.y() < -moving.radius) return "through the ground" + when;
			}
		}
		return lowest < start ? "" : "nothing fell";
	}

private:
	struct Moving
	{
		btRigidBody* body;
		double radius;
		bool isOurs;
	};
	std::size_t pick(std::size_t count) { return std::size_t(m_random() % count); }
	double between(double low, double high) { return uniform(m_random, low, high); }
	btVector3 vector(double longest)
	{
		const Vec3 v = randomVector(m_random, 0, longest);
		return btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z));
	}
	btQuaternion turn()
	{
		const Vec3 axis = randomDirection(m_random);
		return btQuaternion(btVector3(btScalar(axis.x), btScalar(axis.y), btScalar(axis.z)), btScalar(between(0, 3.1)));
	}
	double heightAt(int x, int z) const
	{
		return m_size * (0.3 * std::sin(0.9 * x) * std::cos(0.7 * z) - 0.3);
	}
	// Its top at most at height 0.
	void putGround()
	{
		const btScalar half = btScalar(kHalfGround * m_size), low = btScalar(-m_size);
		switch (pick(4))
		{
			case 0: put(m_scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), 0)), 0); break;
			case 1: put(m_scene.add(std::make_unique<btBoxShape>(btVector3(half, -low, half))), low); break;
			case 2:
			{
				btClodShape& box = m_scene.addShape(body("box-12").hierarchy);
				btVector3 least, most;
				box.getAabb(btTransform::getIdentity(), least, most);
				box.setLocalScaling(btVector3(half / most.x(), -low / most.y(), half / most.z()));
				put(box, low);
				break;
			}
			default:
			{
				constexpr int kPoints = 17;
				for (int z = 0; z < kPoints; ++z)
					for (int x = 0; x < kPoints; ++x) m_heights.push_back(btScalar(heightAt(x, z)));
				auto& field = m_scene.add(std::make_unique<btHeightfieldTerrainShape>(kPoints, kPoints, m_heights.data(), btScalar(1),
																					  low, -low, 1, PHY_FLOAT, false));
				field.setLocalScaling(btVector3(2 * half / (kPoints - 1), 1, 2 * half / (kPoints - 1)));
				put(field, 0);
			}
		}
	}
	void put(btCollisionShape& shape, btScalar height)
	{
		m_scene.addBody(shape, 0, {0, double(height), 0}).setFriction(1);
	}
	btCollisionShape& ours(double radius)
	{
		const Body& model = body(kModels[pick(std::size(kModels))]);
		btClodShape& shape = m_scene.addShape(model.hierarchy);
		btVector3 scale(1, 1, 1);
		const std::size_t kind = pick(4);
		if (kind == 0)
			for (int k = 0; k < 3; ++k) scale[k] = btScalar(between(0.6, 1.5));
		if (kind == 1) scale.setX(-1);
		shape.setLocalScaling(scale * btScalar(radius / double(model.hierarchy->asset().radius)));
		return shape;
	}
	btCollisionShape& compound(double radius)
	{
		auto& whole = m_scene.add(std::make_unique<btCompoundShape>());
		for (const double side : {-0.5, 0.5})
		{
			btTransform place(turn());
			place.setOrigin(btVector3(btScalar(side * radius), 0, 0));
			whole.addChildShape(place, &ours(0.5 * radius));
		}
		return whole;
	}
	btCollisionShape& bullets(double radius)
	{
		const btScalar r = btScalar(radius);
		switch (pick(4))
		{
			case 0: return m_scene.add(std::make_unique<btBoxShape>(btScalar(0.5) * btVector3(r, r, r)));
			case 1: return m_scene.add(std::make_unique<btSphereShape>(btScalar(0.8) * r));
			case 2: return m_scene.add(std::make_unique<btCapsuleShape>(btScalar(0.3) * r, r));
			default: return m_scene.add(std::make_unique<btCylinderShape>(btScalar(0.5) * btVector3(r, r, r)));
		}
	}
	void putBody(double radius, double height)
	{
		const std::size_t kind = m_moving.empty() ? 0 : pick(8);
		btCollisionShape& shape = kind < 6 ? ours(radius) : kind == 6 ? compound(radius) : bullets(radius);
		const double mass = between(0.6, 1.6) * radius * radius * radius * 500;
		const btVector3 aside = vector(0.5 * m_size);
		btRigidBody& body = m_scene.addBody(shape, mass, {double(aside.x()), height, double(aside.z())}, turn());
		body.setFriction(btScalar(between(0.1, 1)));
		body.setLinearVelocity(vector(0.4 * std::sqrt(kGravity * m_size)));
		body.setAngularVelocity(vector(1));
		m_moving.push_back({&body, 1.6 * radius, kind < 7});
		m_weight += mass * kGravity;
	}
	double energy() const
	{
		double sum = 0;
		for (const Moving& moving : m_moving)
		{
			const btRigidBody& body = *moving.body;
			const double mass = 1 / double(body.getInvMass());
			const btVector3 spin = body.getWorldTransform().getBasis().transpose() * body.getAngularVelocity();
			sum += 0.5 * mass * double(body.getLinearVelocity().length2()) +
				   mass * kGravity * double(body.getWorldTransform().getOrigin().y());
			for (int k = 0; k < 3; ++k) sum += 0.5 * double(spin[k] * spin[k] / body.getInvInertiaDiagLocal()[k]);
		}
		return sum;
	}

	Random m_random;
	const double m_rate, m_size;
	BulletWorld m_scene;
	std::vector<btScalar> m_heights;  // which Bullet calls PHY_FLOAT, whatever they are
	std::vector<Moving> m_moving;
	double m_weight = 0;
};
}  // namespace

TEST(RandomWorlds, KeepTheirBodiesAndTheirEnergy)
{
	const int starts = setting("CLOD_STARTS", 12);
	for (int seed = 0; seed < starts; ++seed) EXPECT_EQ(RandomWorld(std::uint64_t(seed)).run(3), "") << "seed " << seed;
}
}  // namespace clod::test
