// SPDX-License-Identifier: GPL-3.0-or-later
// A steady dispatch allocates nothing and takes no lock a pair: operator new is counted, and so are Bullet's own allocations and
// the mutexes that are locked. And what a pair keeps: bytes that are not given back.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <pthread.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "clod/bullet/btClodCollisionAlgorithm.h"
#include "clod/bullet/btClodDispatcher.h"
#include "clod/manifold/ContactSurface.h"
#include "tests/query/Bodies.h"

#include <btBulletDynamicsCommon.h>

namespace
{
std::atomic<long> allocations{0}, bytes{0}, locks{0};

void* allocate(std::size_t size)
{
	++allocations;
	void* p = std::malloc(size ? size : 1);
	bytes += long(malloc_usable_size(p));
	return p;
}
void release(void* p)
{
	bytes -= long(malloc_usable_size(p));
	std::free(p);
}
}  // namespace

#include "tests/support/ReplacedNew.h"

#ifndef __SANITIZE_THREAD__  // whose own this would hide
extern "C" int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept
{
	static const auto lock = reinterpret_cast<int (*)(pthread_mutex_t*)>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
	++locks;
	return lock(mutex);
}
#endif

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

	// Dispatches in which it hardly moves: bytes then.
	long hold(int dispatches)
	{
		m_upper->setLinearVelocity(btVector3(0, 0, 0));
		for (int i = 0; i < dispatches; ++i)
		{
			place(1e-6 * i, m_height, 0);
			m_world.performDiscreteCollisionDetection();
		}
		return bytes;
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
	return allocate(size);
}
}  // namespace

// What the first contact would have to make of the surface.
TEST(Dispatch, ContactsOfAPreparedShapeFindTheirSurfaceMade)
{
	const auto hierarchy = test::body("torus", 900).hierarchy;
	const long before = bytes;
	btClodShape(hierarchy).prepareContacts();
	const long made = bytes - before;
	EXPECT_GT(made, 100 * 900);
	const MovingTorus pair(ContactMetric::exactly());
	EXPECT_LT(bytes - before - made, made / 2);
	// Nor does the first overlap.
	const ContactSurface& surface = hierarchy->derived<ContactSurfaces>().level(0);
	const long known = bytes;
	surface.isInside({});
	EXPECT_EQ(bytes, known);
}

TEST(Dispatch, WhatMeetsOtherScalesIsPreparedInTheLengthsOfTheWorld)
{
	btClodShape shape(test::body("torus", 900).hierarchy);
	shape.setLocalScaling({2, 2, 2});
	shape.prepareContacts(0, true);
	const long before = bytes;
	const auto scaled = shape.inWorldLengths();
	EXPECT_EQ(double(scaled->asset().radius), double(roundUp(2 * double(shape.hierarchy().asset().radius))));
	scaled->derived<ContactSurfaces>().level(0).isInside({});
	EXPECT_EQ(bytes, before);
}

TEST(Dispatch, SteadyStepsAllocateNothing)
{
	// Without alignment of our own: Bullet puts an aligned block into one of these.
	btAlignedAllocSetCustom(countedForBullet, release);
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
		scene.context.keepPoints = false;
		scene.context.budget = each.budget;
		EXPECT_GT(scene.swing() + scene.swing(), 0) << each.name;  // the first ones grow the buffers
		EXPECT_EQ(scene.swing(), 0) << each.name;
		const StepReport sums = scene.context.lastStep();
		EXPECT_GE(sums.points, 2u) << each.name;
		EXPECT_EQ(sums.keptPairs, 0u) << each.name;
	}
}

namespace
{
// Pairs of digits, one flat or tilted on the other and slipping about, that part later.
class Digits
{
public:
	Digits(const ContactMetric& metric, double tilt, double upperScale = 1) : m_tilt(tilt), m_dispatcher(&m_configuration, &context)
	{
		if (!btClodCollisionAlgorithm::registerAlgorithm(&m_dispatcher, &context)) std::abort();
		context.warn = {};
		context.worldMetric = metric;
		m_world.getDispatchInfo().m_timeStep = btScalar(1.0 / 240);
		const btScalar scale = btScalar(1 / double(m_shape.hierarchy().asset().radius));
		m_shape.setLocalScaling({scale, scale, scale});
		m_upperShape.setLocalScaling(btScalar(upperScale) * m_shape.getLocalScaling());
		for (int i = 0; i < 2 * kPairs; ++i)
		{
			m_bodies.push_back(std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(
				btScalar(i % 2), nullptr, i % 2 == 0 ? &m_shape : &m_upperShape, btVector3(1, 1, 1))));
			place(*m_bodies.back(), 6 * (i / 2), 0, i % 2, 0);
			m_world.addRigidBody(m_bodies.back().get());
		}
	}
	~Digits() { end(); }
	// No pair is left: only what all share, and threads.
	void end()
	{
		for (const auto& body : m_bodies)
			if (body->isInWorld()) m_world.removeRigidBody(body.get());
	}
	// Some steps with the upper digits so high above the lower ones, or aside of them, where only boxes along the axes meet:
	// bytes then.
	long steps(double height, double aside = 0)
	{
		for (int step = 0; step < (aside > 0 ? 160 : 40); ++step)
		{
			for (int i = 0; i < kPairs; ++i)
			{
				const double phase = 0.3 * i + 0.05 * step;
				btRigidBody &lower = *m_bodies[std::size_t(2 * i)], &upper = *m_bodies[std::size_t(2 * i + 1)];
				place(lower, 6 * i, 0, 0, aside);
				place(upper, 6 * i + 0.1 * std::sin(phase) + aside, 0.1 * std::cos(phase) + aside, height, aside);
				upper.setLinearVelocity(btVector3(btScalar(0.1 * std::cos(phase)), btScalar(-0.1 * std::sin(phase)), 0));
			}
			m_world.performDiscreteCollisionDetection();
		}
		return bytes;
	}
	void setThreads(unsigned count) { m_dispatcher.setThreads(count); }
	Context context;
	static constexpr int kPairs = 24;

private:
	void place(btRigidBody& body, double x, double y, double z, double aside)
	{
		btQuaternion turn(btVector3(1, 2, 0).normalized(), btScalar(body.isStaticObject() ? 0 : m_tilt));
		if (aside > 0) turn = btQuaternion(btVector3(0, 0, 1), btScalar(0.25 * 3.14159265358979));
		const btTransform pose(turn, btVector3(btScalar(x), btScalar(y), btScalar(z)));
		body.setCenterOfMassTransform(pose);
	}
	const double m_tilt;
	btClodShape m_shape{test::body("number8", 600).hierarchy}, m_upperShape{test::body("number8", 600).hierarchy};
	btDefaultCollisionConfiguration m_configuration;
	btClodDispatcher m_dispatcher;
	btDbvtBroadphase m_broadphase;
	btSequentialImpulseConstraintSolver m_solver;
	btDiscreteDynamicsWorld m_world{&m_dispatcher, &m_broadphase, &m_solver, &m_configuration};
	std::vector<std::unique_ptr<btRigidBody>> m_bodies;
};
}  // namespace

// Threads would wait for each other: there is none but what hands out a step's work, a few times each.
TEST(Dispatch, SteadyStepsTakeNoLockAPair)
{
	constexpr double kMeets = 0.6;
	for (const auto& [upperScale, threads] : {std::pair{1.0, 1U}, {1.01, 1U}, {1.01, 2U}})
	{
		Digits scene(ContactMetric::deviationShare(0.035), 0.4, upperScale);
		scene.setThreads(threads);
		scene.steps(kMeets);
		EXPECT_GT(scene.context.lastStep().pairsInContact, unsigned(Digits::kPairs / 2)) << upperScale;
		const long before = locks;
		scene.steps(kMeets);
		EXPECT_LE(locks - before, 40 * (threads == 1 ? 0 : 6)) << upperScale << ", " << threads;
		EXPECT_TRUE(threads == 1 || locks > before);  // which are seen
	}
}

// Where nothing is near any longer what was remembered is given back.
TEST(Memory, OfAPairIsWhatItsContactsTake)
{
	const std::pair<const char*, ContactMetric> metrics[] = {{"exact", ContactMetric::exactly()},
															 {"certified", ContactMetric::errorShare(0.005)},
															 {"size", ContactMetric::deviationShare(0.035)}};
	for (int i = 0; i < 6; ++i)
	{
		const auto& [name, metric] = metrics[i % 3];
		const bool isFlat = i < 3;
		double height = isFlat ? 0.6 : 0.8;
		Digits scene(metric, isFlat ? 0 : 0.4);
		long touching = scene.steps(height);
		while (scene.context.lastStep().pairsInContact < unsigned(Digits::kPairs) && height > 0)
			touching = scene.steps(height -= 0.02);
		const StepReport report = scene.context.lastStep();
		long apart = scene.steps(0.3, 1.1);
		EXPECT_EQ(scene.context.lastStep().points, 0u) << name;
		scene.end();
		ASSERT_EQ(scene.context.lastStep().pairs, 0u);
		for (long* each : {&touching, &apart}) *each = (*each - bytes) / Digits::kPairs;
		std::printf("%s, %s: %ld bytes a pair touching (%.1f points, %.1f node pairs), %ld apart again\n", name, isFlat ? "flat" : "tilted", touching,
					double(report.points) / report.pairs, double(report.nodePairs) / report.pairs, apart);
		EXPECT_EQ(report.pairsInContact, unsigned(Digits::kPairs)) << name;
		EXPECT_EQ(report.pairs, unsigned(Digits::kPairs)) << name;
		EXPECT_GT(apart, 0) << name;
		EXPECT_LE(apart, 5 << 10) << name;
		// While they move a front of base levels is not kept. Bullet's places are twice as long in double.
		const int most = sizeof(btScalar) > sizeof(float) ? 18 : 16;
		EXPECT_LE(touching, (metric.weightedDeviationShare < kOff && !isFlat ? most - 5 : most) << 10) << name;
	}
}

// A pair that keeps its points asks nothing: what queries remember is given back, and taken again by one that asks.
TEST(Memory, OfAPairThatKeepsItsPointsIsGivenBack)
{
	MovingTorus scene(ContactMetric::deviationShare(0.035));
	for (int round = 0; round < 2; ++round)
	{
		scene.swing();
		const long asking = scene.hold(1), keeping = scene.hold(40);
		EXPECT_EQ(scene.context.lastStep().keptPairs, 1u);
		EXPECT_LT(keeping, asking - (2 << 10));
		EXPECT_EQ(scene.hold(40), keeping);
		scene.swing();
		EXPECT_GT(scene.hold(1), keeping + (2 << 10));
	}
}
}  // namespace clod::test
