// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies at rest whose level of detail is changed again and again: they neither jump nor fall.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "clod/bullet/ConfigureWorld.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
// A body on another, or on the ground, let come to rest; in units of the speed of a fall by its radius.
class Resting
{
public:
	enum class Ground
	{
		kPlane,
		kMesh,
		kBody
	};
	Resting(const std::string& upper, Ground ground, const std::string& lower = {}, double size = 1)
	{
		configureWorld(m_scene.world);
		if (ground == Ground::kBody)
			m_scene.addBody(shapeOf(lower, 1), 0, {});
		else if (ground == Ground::kPlane)
			m_scene.addBody(m_scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0))), 0, {});
		else
		{
			addGround(m_triangles, 4);
			m_scene.addBody(m_scene.add(std::make_unique<btBvhTriangleMeshShape>(&m_triangles, true)), 0, {});
		}
		m_radius = size;
		m_body = &m_scene.addBody(shapeOf(upper, size), 1, {0, 1, 0}, btQuaternion(btVector3(1, 0, 0), btScalar(0.2)));
		choose(true);
		m_scene.step(480);
		m_body->setDamping(btScalar(0.99), btScalar(0.99));
		m_scene.step(1440);
		m_body->setDamping(0, 0);
		m_scene.step(480);
	}
	void choose(bool isFine)
	{
		m_scene.context.worldMetric = isFine ? ContactMetric::exactly() : ContactMetric::deviationShare(0.035);
	}
	// The world takes it for a new body, at rest so many radii higher.
	void comeAgain(bool isFine, double higher = 0)
	{
		m_scene.world.removeRigidBody(m_body);
		m_body->translate(btVector3(0, btScalar(higher * m_radius), 0));
		choose(isFine);
		m_scene.world.addRigidBody(m_body);
	}
	void keepPoints(bool keeps) { m_scene.context.keepPoints = keeps; }
	int keptPairs() const { return int(m_scene.context.lastStep().keptPairs); }
	double speed() const
	{
		return (double(m_body->getLinearVelocity().length()) + m_radius * double(m_body->getAngularVelocity().length())) /
			   std::sqrt(9.81 * m_radius);
	}
	double deepest() { return m_scene.depthAt(*m_body) / m_radius; }
	double height() const { return heightOf(*m_body) / m_radius; }
	std::uint32_t coarsestLevel() const
	{
		std::uint32_t level = 0;
		m_scene.context.forEachPair([&](const PairReport& pair) { level = pair.result->stats.coarsestLevel; });
		return level;
	}
	void step() { m_scene.step(); }
	// Whatever pushes it, it stays where it is.
	void hold()
	{
		m_body->setLinearFactor(btVector3(0, 0, 0));
		m_body->setAngularFactor(0);
	}
	// By how much its points ask to be less deep after the next step, in radii.
	double leftAStep()
	{
		double most = 0;
		btDispatcher& dispatcher = *m_scene.world.getDispatcher();
		for (int k = 0; k < dispatcher.getNumManifolds(); ++k)
		{
			const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(k);
			for (int p = 0; p < manifold.getNumContacts(); ++p)
			{
				const btManifoldPoint& point = manifold.getContactPoint(p);
				most = std::max(most, -double(point.m_distance1) * double(point.m_contactERP));
			}
		}
		return most / m_radius;
	}

private:
	btClodShape& shapeOf(const std::string& name, double size)
	{
		btClodShape& shape = m_scene.addShape(body(name).hierarchy, size);
		return shape;
	}
	BulletWorld m_scene;
	btTriangleMesh m_triangles;
	btRigidBody* m_body = nullptr;
	double m_radius = 1;
};
}  // namespace

TEST(LevelSwitch, BodiesAtRestNeitherJumpNorFall)
{
	for (const int which : {0, 1, 2, 3, 4})
	{
		Resting scene = which == 0	 ? Resting("torus-900", Resting::Ground::kPlane)
						: which == 1 ? Resting("cup-3000", Resting::Ground::kPlane)
						: which == 2 ? Resting("torus-900", Resting::Ground::kBody, "cup-3000", 0.5)
						: which == 3 ? Resting("torus-900", Resting::Ground::kMesh)
									 : Resting("cup-3000", Resting::Ground::kMesh);
		ASSERT_LT(scene.speed(), 2e-4) << which;
		for (const int every : {1, 2, 7, 60})
		{
			int switches = 0;
			std::uint32_t level = 0;
			double fastest = 0;
			for (int i = 0; i < 240; ++i)
			{
				scene.choose(i / every % 2 != 0);
				scene.step();
				fastest = std::max(fastest, scene.speed());
				switches += scene.coarsestLevel() != level ? 1 : 0;
				level = scene.coarsestLevel();
			}
			EXPECT_GE(switches, 240 / every / 2) << which << ", every " << every;
			EXPECT_LT(fastest, 1e-3) << which << ", every " << every;
		}
	}
}

// What overlaps on the level on which it is first seen, by no more than that may err, is not thrust out either.
TEST(LevelSwitch, ABodySeenFirstOnACoarseLevelIsNotLifted)
{
	for (const auto& [upper, lower] : {std::pair("torus-900", "cup-3000"), {"spoon-3000", "cup-3000"}})
	{
		Resting scene(upper, Resting::Ground::kBody, lower, 0.5);
		const double before = scene.height();
		scene.comeAgain(false);
		for (int i = 0; i < 24; ++i)
		{
			scene.step();
			EXPECT_LT(scene.height() - before, 1e-4) << upper;
		}
		EXPECT_GT(scene.coarsestLevel(), 0u) << upper;
	}
}

// But what is deeper than levels err overlaps in truth: it stayed as deep as they may err for minutes.
TEST(LevelSwitch, ABodyThatStartsDeeperThanItsLevelErrsComesUpAllTheWay)
{
	for (const auto ground : {Resting::Ground::kPlane, Resting::Ground::kBody})
	{
		Resting scene("torus-900", ground, "cup-3000", 0.5);
		double height[2];
		for (const bool isSunk : {true, false})  // let down where it came up: friction holds it there
		{
			scene.comeAgain(false, isSunk ? -0.1 : 0.01);
			for (int i = 0; i < 480; ++i) scene.step();
			EXPECT_GT(scene.coarsestLevel(), 0u);
			EXPECT_LT(scene.speed(), 1e-3) << isSunk;
			EXPECT_LT(scene.deepest(), 1e-4) << int(ground) << isSunk;
			height[isSunk ? 1 : 0] = scene.height();
		}
		EXPECT_NEAR(height[1], height[0], 1e-3) << int(ground);
	}
}

// How a body at rest goes on, after its level was changed.
struct Settling
{
	std::vector<double> heights;  // after each 40 steps, over the one given
	int kept = 0;                 // pairs that kept their points, over all steps
	double fastest = 0;

	void follow(Resting& scene, double from, int steps)
	{
		for (int i = 0; i < steps; ++i)
		{
			scene.step();
			kept += scene.keptPairs();
			fastest = std::max(fastest, scene.speed());
			if (i % 40 == 39) heights.push_back(scene.height() - from);
		}
	}
};

// The surface that is asked for is reached in the end, and as slowly whether points are found anew in every step or not.
TEST(LevelSwitch, ABodyIsLetDownOntoTheSurfaceThatIsAskedFor)
{
	Settling settling[2];
	for (const bool keeps : {false, true})
	{
		Resting scene("cup-3000", Resting::Ground::kPlane);
		const double fine = scene.height();
		scene.keepPoints(keeps);
		scene.choose(false);
		for (int i = 0; i < 2400; ++i) scene.step();
		const double coarse = scene.height();
		EXPECT_GT(coarse - fine, 1e-4);
		scene.choose(true);
		settling[keeps].follow(scene, fine, 240);
		EXPECT_EQ(settling[keeps].kept > 200, keeps) << settling[keeps].kept;
		settling[keeps].follow(scene, fine, 2160);
		EXPECT_NEAR(scene.height(), fine, 1e-5);
	}
	const std::vector<double>&found = settling[false].heights, &kept = settling[true].heights;
	ASSERT_EQ(found.size(), 60u);
	for (std::size_t i = 0; i < found.size(); ++i)
	{
		const bool hasLanded = i >= 30;
		EXPECT_NEAR(kept[i], found[i], hasLanded ? 1e-6 : 0.04 * found.front()) << i;
	}
}

// The coarse surface reaches deeper: the body is lifted as slowly whether its points are found anew in every step or not.
TEST(LevelSwitch, AnOverlapIsLeftAsSlowlyByPointsThatAreKept)
{
	Settling settling[2];
	for (const bool keeps : {false, true})
	{
		Resting scene("cup-3000", Resting::Ground::kPlane);
		const double fine = scene.height();
		scene.keepPoints(keeps);
		scene.choose(false);
		settling[keeps].follow(scene, fine, 480);
		EXPECT_LT(settling[keeps].fastest, 1e-3);
		EXPECT_GT(settling[keeps].heights.back(), 5e-5);
		EXPECT_EQ(settling[keeps].kept > 240, keeps) << settling[keeps].kept;
	}
	const std::vector<double>&found = settling[false].heights, &kept = settling[true].heights;
	ASSERT_EQ(found.size(), 12u);
	for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(kept[i], found[i], 3e-6) << i;
}

// So it is if something holds it, but not for ever: it stayed as deep, as that was all that was asked of it.
TEST(LevelSwitch, AnOverlapThatIsHeldIsNotLeftSlowlyForEver)
{
	for (const bool keeps : {false, true})
	{
		Resting scene("cup-3000", Resting::Ground::kPlane);
		scene.keepPoints(keeps);
		scene.hold();
		scene.choose(false);
		scene.step();
		scene.step();
		const double first = scene.leftAStep();
		int kept = 0;
		for (int i = 0; i < 1440; ++i)
		{
			scene.step();
			kept += scene.keptPairs();
		}
		EXPECT_EQ(kept > 720, keeps) << kept;
		EXPECT_GT(first, 0) << keeps;
		EXPECT_GT(scene.leftAStep(), 4 * first) << keeps;
	}
}

// On a coarse level the underside of a flat body is uneven. Nothing that is met within the error of the level is met
// before the rest.
TEST(Bounce, FlatBodiesDoNotTurnOnCoarseLevels)
{
	for (const char* name : {"cup-3000", "number8-600"})
		for (int i = 0; i < 40; ++i)
		{
			BulletWorld scene;
			configureWorld(scene.world);
			scene.context.worldMetric = ContactMetric::deviationShare(0.1);
			auto& plane = scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)));
			btRigidBody& ground = scene.addBody(plane, 0, {});
			ground.setRestitution(1);
			ground.setFriction(0);
			btClodShape& shape = scene.addShape(body(name).hierarchy, 0.7);
			const btQuaternion flat(btVector3(1, 0, 0), btScalar(name[0] == 'n' ? 1.57079632679 : 0));
			btRigidBody& moving = scene.addBody(shape, 1, {0, 1 + 0.0137 * i, 0}, flat);
			moving.setRestitution(1);
			moving.setDamping(0, 0);
			for (int k = 0; k < 240 && !(moving.getLinearVelocity().y() > 0); ++k) scene.step();
			EXPECT_GT(double(moving.getLinearVelocity().y()), 1) << name << " " << i;
			EXPECT_LT(double(moving.getAngularVelocity().length()), 0.1) << name << " " << i;
		}
}
}  // namespace clod::test
