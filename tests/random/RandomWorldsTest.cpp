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
#include "tests/query/Questions.h"
#include "tests/random/RandomShapes.h"

namespace clod::test
{
namespace
{
constexpr double kGravity = 9.81;
constexpr double kHalfGround = 40;  // of the bodies' size
constexpr double kMostGain = 0.1;   // of the energy of all bodies lifted by their size

class RandomWorld
{
public:
	explicit RandomWorld(std::uint64_t seed)
		: m_draw(seed),
		  m_rate(std::array{60.0, 120.0, 240.0}[m_draw.pick(3)]),
		  m_size(std::array{0.1, 0.5, 1.0}[m_draw.pick(3)]),
		  m_scene(m_draw.pick(2) == 1)
	{
		m_scene.timeStep = 1 / m_rate;
		const ContactMetric metrics[] = {ContactMetric::exactly(), ContactMetric::errorShare(0.005), ContactMetric::errorShare(0.03),
										 ContactMetric::deviationShare(0.035)};
		m_scene.context.worldMetric = metrics[m_draw.pick(4)];
		configureWorld(m_scene.world);
		putGround();
		double top = m_size;
		for (std::size_t i = 0, count = 2 + m_draw.pick(6); i < count; ++i)
		{
			const double radius = m_size * m_draw.between(0.8, 1.4);
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
	double heightAt(int x, int z) const
	{
		return m_size * (0.3 * std::sin(0.9 * x) * std::cos(0.7 * z) - 0.3);
	}
	// Its top at most at height 0.
	void putGround()
	{
		const btScalar half = btScalar(kHalfGround * m_size), low = btScalar(-m_size);
		switch (m_draw.pick(4))
		{
			case 0: put(m_scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), 0)), 0); break;
			case 1: put(m_scene.add(std::make_unique<btBoxShape>(btVector3(half, -low, half))), low); break;
			case 2: put(m_draw.slab(double(half), -double(low)), low); break;
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
	void putBody(double radius, double height)
	{
		const std::size_t kind = m_moving.empty() ? 0 : m_draw.pick(8);
		btCollisionShape& shape = kind < 6	? static_cast<btCollisionShape&>(m_draw.ours(radius))
								  : kind == 6 ? m_draw.compound(radius)
											  : static_cast<btCollisionShape&>(m_draw.bullets(radius));
		const double mass = m_draw.between(0.6, 1.6) * radius * radius * radius * 500;
		const btVector3 aside = m_draw.vector(0.5 * m_size);
		btRigidBody& body = m_scene.addBody(shape, mass, {double(aside.x()), height, double(aside.z())}, m_draw.turn());
		body.setFriction(btScalar(m_draw.between(0.1, 1)));
		body.setLinearVelocity(m_draw.vector(0.4 * std::sqrt(kGravity * m_size)));
		body.setAngularVelocity(m_draw.vector(1));
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

	RandomShapes m_draw;
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
