// SPDX-License-Identifier: Zlib
// The pieces of code of plugin/docs/how-to.md, which a test finds here line by line. Compiled, not run.
#include <btBulletDynamicsCommon.h>
#include <clod/bullet/ConfigureWorld.h>
#include <clod/bullet/btClodCollisionAlgorithm.h>
#include <clod/bullet/btClodDispatcher.h>
#include <clod/bullet/btClodDynamicsWorld.h>
#include <clod/bullet/btClodShape.h>

#include <cstdio>
#include <memory>
#include <stdexcept>

namespace howto
{
namespace
{
constexpr int kImportant = 1;
}

void setUp(btDiscreteDynamicsWorld& world)
{
	clod::Context context;  // declare it before the world, which uses it to the end
	const clod::Result<int> ready = clod::setUpWorld(world, context);
	if (!ready) throw std::runtime_error(ready.error());

	clod::BodySettings settings;
	settings.mass = 0.2;
	auto made = clod::ClodBody::load("part.clod", settings);
	if (!made) throw std::runtime_error(made.error());
	world.addRigidBody(&made.value()->body());
}

void meetImpacts(btDefaultCollisionConfiguration& configuration, btCollisionDispatcher& dispatcher,
				 btDbvtBroadphase& broadphase, btSequentialImpulseConstraintSolver& solver, clod::Context& context)
{
	btClodDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, &context);
	world.stepSimulation(btScalar(1.0 / 60), 0);
}

btClodShape* makeShape()
{
	const clod::Result<std::shared_ptr<const clod::Hierarchy>> part = clod::Hierarchy::load("part.clod");
	if (!part) throw std::runtime_error(part.error());
	btClodShape* const shape = new btClodShape(part.value());
	return shape;
}

void chooseAccuracy(clod::Context& context, btClodShape* shape)
{
	context.worldMetric = clod::ContactMetric::errorShare(0.005);  // certified: 0.5 % of the smaller radius, the default
	shape->setMetric(clod::ContactMetric::exactly());              // this one's pairs: the full meshes
	context.pairMetric = [](const btCollisionObject& a, const btCollisionObject&, clod::ContactMetric& metric)
	{
		if (a.getUserIndex() != kImportant) return false;
		metric = clod::ContactMetric::errorShare(0.001);
		return true;
	};
}

void scale(btClodShape* shape, btDiscreteDynamicsWorld& world)
{
	shape->setLocalScaling(btVector3(100, 100, 100));  // tableware in metres
	world.setGravity(btVector3(0, -981, 0));
}

void setBudget(btDefaultCollisionConfiguration& configuration, clod::Context& context)
{
	btClodDispatcher dispatcher(&configuration, &context);
	context.budget.tests = 20000;        // repeats bit for bit
	context.budget.microseconds = 2000;  // or of time: a guess, that can be overrun
}

void readWhatHappened(const clod::Context& context)
{
	const clod::StepReport step = context.lastStep();
	context.forEachPair([](const clod::PairReport& pair) { std::printf("error at most %g\n", pair.contactError); });
	std::printf("%s\n", step.fastPairs > 0 ? "fast" : "");
}
}  // namespace howto
