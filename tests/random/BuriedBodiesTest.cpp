// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies that a program has made some way into a ground of triangles, thin ones and compact ones, at any turn, up to 45 % of
// their height deep, on few or many triangles of either winding and on rough heightfields: they come out, and are not thrown.
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
constexpr double kRadius = 0.5, kHalfWidth = 4;
constexpr double kMostFallen = 0.03;  // of all: rings and cups on heightfields as rough as they; 10 of 400 do
constexpr double kMostThrown = 4;     // m/s, on the way out and down again
constexpr int kRough = 48;            // heights along a side

class Buried
{
public:
	explicit Buried(std::uint64_t seed) : m_draw(seed)
	{
		configureWorld(m_scene.world);
		const std::size_t kind = m_draw.pick(3);
		btCollisionShape& ground = kind == 0 ? flat() : rough(kind == 1 ? 0.03 : 0.1);
		m_scene.addBody(ground, 0, {});
		constexpr const char* kModels[] = {"box-12", "torus-900", "cup-3000", "spoon-3000", "sphere-300", "rod", "number8-600"};
		const Body& model = body(kModels[m_draw.pick(std::size(kModels))]);
		btClodShape& shape = m_scene.addShape(model.hierarchy);
		const double scale = kRadius / double(model.hierarchy->asset().radius);
		shape.setLocalScaling(btVector3(btScalar(scale), btScalar(scale), btScalar(scale)));
		const bool isUpright = m_draw.pick(5) < 2;
		const btQuaternion turn =
			isUpright ? btQuaternion(btVector3(1, btScalar(0.2), btScalar(0.3)).normalized(), btScalar(m_draw.between(0, 0.1)))
					  : m_draw.turn();
		double low = 1e9, high = -1e9;
		for (const std::array<Vec3, 3>& triangle : model.triangles)
			for (const Vec3& v : triangle)
			{
				const btVector3 place = quatRotate(turn, btScalar(scale) * btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z)));
				low = std::min(low, double(place.y()));
				high = std::max(high, double(place.y()));
			}
		const double share = m_draw.between(0.02, 0.45);
		m_body = &m_scene.addBody(shape, 1, {m_draw.between(-0.5, 0.5), -low - share * (high - low), m_draw.between(-0.5, 0.5)}, turn);
		m_what = model.name + (kind == 0 ? " on a flat ground, " : " on a rough ground, ") + std::to_string(share) + " deep";
	}
	const std::string& what() const { return m_what; }
	// Where it is then, and the fastest it was on its way.
	double run(double seconds, double& fastest)
	{
		for (int step = 0; step < int(seconds / m_scene.timeStep); ++step)
		{
			m_scene.step();
			fastest = std::max(fastest, double(m_body->getLinearVelocity().length()));
		}
		return heightOf(*m_body);
	}

private:
	btCollisionShape& flat()
	{
		const auto cells = int(1 + m_draw.pick(40));
		const bool isUp = m_draw.pick(2) == 1;
		const auto corner = [cells](int i, int j)
		{
			const auto along = [cells](int k) { return btScalar(2 * kHalfWidth * k / cells - kHalfWidth); };
			return btVector3(along(i), 0, along(j));
		};
		for (int i = 0; i < cells; ++i)
			for (int j = 0; j < cells; ++j)
				for (const int half : {0, 1})
				{
					const btVector3 a = corner(i + half, j + half), b = corner(i, j + 1), c = corner(i + 1, j);
					const bool isSwapped = (half == 1) == isUp;
					m_mesh.addTriangle(a, isSwapped ? c : b, isSwapped ? b : c);
				}
		return m_scene.add(std::make_unique<btBvhTriangleMeshShape>(&m_mesh, true));
	}
	btCollisionShape& rough(double amplitude)
	{
		m_heights.resize(kRough * kRough);
		for (int i = 0; i < kRough * kRough; ++i)
			m_heights[std::size_t(i)] = btScalar(amplitude * (std::sin(0.9 * (i % kRough)) * std::cos(0.7 * (i / kRough)) +
														   m_draw.between(-0.3, 0.3)));
		auto& ground = m_scene.add(std::make_unique<btHeightfieldTerrainShape>(
			kRough, kRough, m_heights.data(), btScalar(1), btScalar(-0.5), btScalar(0.5), 1, PHY_FLOAT, false));
		const btScalar cell = btScalar(2 * kHalfWidth / kRough);
		ground.setLocalScaling(btVector3(cell, 1, cell));
		return ground;
	}

	RandomShapes m_draw;
	btTriangleMesh m_mesh;
	std::vector<btScalar> m_heights;
	BulletWorld m_scene;
	btRigidBody* m_body = nullptr;
	std::string m_what;
};
}  // namespace

TEST(BuriedBodies, ComeOutOfGroundsOfTriangles)
{
	const int starts = setting("CLOD_STARTS", 12);
	int fallen = 0;
	std::string who;
	for (int seed = 0; seed < starts; ++seed)
	{
		Buried buried(std::uint64_t(seed) + 1);
		double fastest = 0;
		if (buried.run(3, fastest) < -1)
		{
			++fallen;
			who += "\n" + std::to_string(seed) + ": " + buried.what();
		}
		else
			EXPECT_LT(fastest, kMostThrown) << seed << ": " << buried.what();
	}
	EXPECT_LE(fallen, kMostFallen * starts) << "of " << starts << who;
}
}  // namespace clod::test
