// SPDX-License-Identifier: GPL-3.0-or-later
// A steady dispatch allocates nothing: operator new is counted, and so are Bullet's own allocations.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>
#include <optional>

#include "clod/bullet/btClodCollisionAlgorithm.h"
#include "clod/bullet/btClodDispatcher.h"
#include "tests/query/Bodies.h"

#include <btBulletDynamicsCommon.h>

namespace
{
std::atomic<long> allocations{0};

void* counted(std::size_t size)
{
	++allocations;
	return std::malloc(size ? size : 1);
}
}  // namespace

// Inlined in part, GCC takes malloc or free for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size)
{
	if (void* p = counted(size)) return p;
	throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept
{
	std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept
{
	std::free(p);
}

namespace clod::test
{
namespace
{
// A torus that moves to and fro, a little, on another that lies.
class MovingTorus
{
public:
	explicit MovingTorus(const ContactMetric& metric) : m_dispatcher(&m_configuration, &context)
	{
		if (!btClodCollisionAlgorithm::registerAlgorithm(&m_dispatcher, &context)) std::abort();
		context.warn = {};
		context.worldMetric = metric;
		m_world.getDispatchInfo().m_timeStep = btScalar(1.0 / 240);
		const btScalar scale = btScalar(1 / double(m_shape.hierarchy().asset().radius));
		m_shape.setLocalScaling({scale, scale, scale});
		m_lower.emplace(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &m_shape));
		m_upper.emplace(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &m_shape, btVector3(1, 1, 1)));
		m_world.addRigidBody(&*m_lower);
		m_world.addRigidBody(&*m_upper);
		while (context.lastStep().points < 8 && m_height > 0)
		{
			place(0, m_height -= 0.001, 0);
			m_world.performDiscreteCollisionDetection();
		}
	}
	~MovingTorus()
	{
		m_world.removeRigidBody(&*m_upper);
		m_world.removeRigidBody(&*m_lower);
	}

	// 50 dispatches; returns what they allocated.
	long swing()
	{
		const long before = allocations;
		for (int step = 0; step < 50; ++step)
		{
			const double phase = 2 * 3.14159265358979 * step / 50;
			place(0.002 * std::cos(phase), m_height, 0.001 * std::sin(2 * phase));
			m_upper->setLinearVelocity(
				btVector3(btScalar(-0.06 * std::sin(phase)), 0, btScalar(0.06 * std::cos(phase))));
			m_world.performDiscreteCollisionDetection();
		}
		return allocations - before;
	}

	Context context;

private:
	void place(double x, double y, double z)
	{
		m_upper->getWorldTransform().setOrigin(btVector3(btScalar(0.05 + x), btScalar(y), btScalar(0.03 + z)));
	}

	btClodShape m_shape{test::body("torus", 900).hierarchy};
	btDefaultCollisionConfiguration m_configuration;
	btClodDispatcher m_dispatcher;
	btDbvtBroadphase m_broadphase;
	btSequentialImpulseConstraintSolver m_solver;
	btDiscreteDynamicsWorld m_world{&m_dispatcher, &m_broadphase, &m_solver, &m_configuration};
	std::optional<btRigidBody> m_lower, m_upper;
	double m_height = 1;
};

struct Case
{
	const char* name;
	ContactMetric metric;
	Budget budget;
};

void* countedForBullet(std::size_t size)
{
	return counted(size);
}
}  // namespace

TEST(Dispatch, SteadyStepsAllocateNothing)
{
	// Without alignment of our own: Bullet puts an aligned block into one of these.
	btAlignedAllocSetCustom(countedForBullet, std::free);
	const long before = allocations;
	btAlignedFree(btAlignedAlloc(8, 16));
	ASSERT_EQ(allocations - before, 1);
	const Case cases[] = {{"exact", ContactMetric::exactly(), {}},
						  {"certified", ContactMetric::errorShare(0.005), {}},
						  {"size", ContactMetric::deviationShare(0.035), {}},
						  {"velocity", ContactMetric::velocityFactor(0.3), {}},
						  {"tests", ContactMetric::deviationShare(0.001), {1500, kOff}},
						  {"no tests", ContactMetric::deviationShare(0.001), {0, kOff}},
						  {"time", ContactMetric::deviationShare(0.001), {kOff, 0}}};
	for (const Case& each : cases)
	{
		MovingTorus scene(each.metric);
		scene.context.budget = each.budget;
		EXPECT_GT(scene.swing() + scene.swing(), 0) << each.name;  // the first ones grow the buffers
		EXPECT_EQ(scene.swing(), 0) << each.name;
		const StepReport sums = scene.context.lastStep();
		EXPECT_GE(sums.points, 2u) << each.name;
		EXPECT_EQ(sums.keptPairs, 0u) << each.name;
	}
}
}  // namespace clod::test
