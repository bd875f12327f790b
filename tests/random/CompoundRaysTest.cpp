// SPDX-License-Identifier: GPL-3.0-or-later
// Rays and sweeps at compounds of ours, children scaled, parents too, mirrored or not, against compounds of Bullet's own
// meshes of the same triangles.
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/query/Questions.h"
#include "tests/random/RandomShapes.h"

namespace clod::test
{
namespace
{
struct Triangles : btTriangleCallback
{
	std::unique_ptr<btTriangleMesh> mesh = std::make_unique<btTriangleMesh>();
	void processTriangle(btVector3* corners, int, int) override { mesh->addTriangle(corners[0], corners[1], corners[2]); }
};

// The same compound twice, in the same place.
class Twins
{
public:
	explicit Twins(std::uint64_t seed) : m_draw(seed), m_ours(m_draw.pick(2) == 1), m_theirs(m_draw.pick(2) == 1)
	{
		for (std::size_t count = 1 + m_draw.pick(4); count > 0; --count)
		{
			btTransform place(m_draw.turn());
			place.setOrigin(m_draw.vector(1));
			m_ours.addChildShape(place, &m_draw.ours(m_draw.between(0.3, 1)));
		}
		btVector3 scale(1, 1, 1);
		const std::size_t kind = m_draw.pick(3);
		if (kind == 0) scale *= btScalar(m_draw.between(0.5, 2));
		if (kind == 1) scale.setX(-1);
		m_ours.setLocalScaling(scale * btScalar(std::pow(10, m_draw.between(-1, 1))));
		const btScalar all = btScalar(1e9);
		for (int i = 0; i < m_ours.getNumChildShapes(); ++i)
		{
			Triangles triangles;
			static_cast<btClodShape*>(m_ours.getChildShape(i))->processAllTriangles(&triangles, btVector3(-all, -all, -all),
																					btVector3(all, all, all));
			m_meshes.push_back(std::move(triangles.mesh));
			auto& shape = m_draw.add(std::make_unique<btBvhTriangleMeshShape>(m_meshes.back().get(), false));
			shape.setMargin(0);
			m_theirs.addChildShape(m_ours.getChildTransform(i), &shape);
		}
		m_pose = btTransform(m_draw.turn(), m_draw.vector(5));
		m_object[0].setCollisionShape(&m_ours);
		m_object[1].setCollisionShape(&m_theirs);
		for (btCollisionObject& object : m_object) object.setWorldTransform(m_pose);
		btVector3 low, high;
		m_ours.getAabb(m_pose, low, high);
		m_middle = btScalar(0.5) * (low + high);
		m_radius = 0.5 * double((high - low).length());
	}
	// Of a way through or beside them. Returns whether theirs is hit.
	bool compareRay(int seed)
	{
		const btVector3 from = anyPlace(), to = anyPlace();
		const unsigned flags = m_draw.oneOf(3) ? unsigned(btTriangleRaycastCallback::kF_FilterBackfaces) : 0;
		const btTransform start(btQuaternion::getIdentity(), from), end(btQuaternion::getIdentity(), to);
		btCollisionWorld::ClosestRayResultCallback hits[2] = {{from, to}, {from, to}};
		for (int i = 0; i < 2; ++i)
		{
			hits[i].m_flags = flags;
			btCollisionWorld::rayTestSingle(start, end, &m_object[i], m_object[i].getCollisionShape(), m_pose, hits[i]);
		}
		compare(hits[0], hits[1], seed, 0);
		return hits[1].hasHit();
	}
	bool compareSweep(int seed)
	{
		btTransform from(m_draw.turn(), anyPlace()), to(m_draw.turn(), anyPlace());
		if (m_draw.pick(2)) to.setBasis(from.getBasis());
		btConvexInternalShape& shape = m_draw.bullets(0.3 * m_radius);
		btCollisionWorld::ClosestConvexResultCallback hits[2] = {{from.getOrigin(), to.getOrigin()},
																 {from.getOrigin(), to.getOrigin()}};
		for (int i = 0; i < 2; ++i)
			btCollisionWorld::objectQuerySingle(&shape, from, to, &m_object[i], m_object[i].getCollisionShape(), m_pose,
												hits[i], 0);
		compare(hits[0], hits[1], seed, 1e-4);
		return hits[1].hasHit();
	}

private:
	btVector3 anyPlace() { return m_middle + m_draw.vector(2 * m_radius); }
	template <class Hit>
	static void compare(const Hit& ours, const Hit& theirs, int seed, double room)
	{
		EXPECT_EQ(ours.hasHit(), theirs.hasHit()) << "seed " << seed;
		EXPECT_NEAR(double(ours.m_closestHitFraction), double(theirs.m_closestHitFraction), room) << "seed " << seed;
		if (!ours.hasHit() || !theirs.hasHit()) return;
		EXPECT_NEAR(double(ours.m_hitNormalWorld.length()), 1, 1e-3) << "seed " << seed;
		// Of a sweep that begins in an overlap, or ends at an edge, any triangle of those may tell.
		const bool isTurned = double(ours.m_hitNormalWorld.dot(theirs.m_hitNormalWorld)) < 1 - 1e-3;
		if (room == 0)
		{
			EXPECT_FALSE(isTurned) << "seed " << seed;
		}
		else if (ours.m_closestHitFraction > 0 && isTurned)
			++s_turned;
	}

	RandomShapes m_draw;
	btCompoundShape m_ours, m_theirs;
	std::vector<std::unique_ptr<btTriangleMesh>> m_meshes;
	btTransform m_pose;
	btCollisionObject m_object[2];
	btVector3 m_middle;
	double m_radius = 0;

public:
	static inline int s_turned = 0;
};
}  // namespace

TEST(RandomCompounds, RaysAndSweepsHitThemAsTheyHitBulletsMeshes)
{
	const int starts = setting("CLOD_STARTS", 12);
	int rays = 0, sweeps = 0;
	Twins::s_turned = 0;
	for (int seed = 0; seed < starts; ++seed)
	{
		Twins twins{std::uint64_t(seed)};
		for (int i = 0; i < 60; ++i) rays += twins.compareRay(seed) ? 1 : 0;
		for (int i = 0; i < 10; ++i) sweeps += twins.compareSweep(seed) ? 1 : 0;
	}
	EXPECT_GT(rays, 10 * starts);
	EXPECT_LT(rays, 55 * starts);
	EXPECT_GT(sweeps, 2 * starts);
	EXPECT_LE(Twins::s_turned, sweeps / 20) << sweeps;
}
}  // namespace clod::test
