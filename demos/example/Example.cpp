// SPDX-License-Identifier: Zlib
// Two copies of a model fall onto each other and a floor.
//   clod-build build model.obj -o model.clod && clod_example model.clod
#include <btBulletDynamicsCommon.h>
#include <clod/bullet/ConfigureWorld.h>
#include <clod/bullet/btClodCollisionAlgorithm.h>
#include <clod/bullet/btClodShape.h>

#include <cstdio>

int main(int argc, char** argv)
{
	const auto model = clod::Hierarchy::load(argc > 1 ? argv[1] : "model.clod");
	if (!model)
	{
		std::fprintf(stderr, "%s\n", model.error().c_str());
		return 1;
	}

	clod::Context context;  // thresholds and statistics; outlives the world
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	const auto registered = btClodCollisionAlgorithm::registerAlgorithm(&dispatcher, &context);
	if (!registered)
	{
		std::fprintf(stderr, "%s\n", registered.error().c_str());
		return 1;
	}
	world.setGravity(btVector3(0, btScalar(-9.81), 0));
	clod::configureWorld(world);  // iterations, friction and soft corrections, recommended

	// Bullet's constants suit bodies of about one unit, so the model falls as if its radius were 1 m.
	const btScalar scale = btScalar(1 / model.value()->asset().radius);
	btClodShape shape(model.value());
	shape.setLocalScaling(btVector3(scale, scale, scale));
	shape.setMetric(clod::ContactMetric::errorShare(0.01));  // contacts certified to 1 % of the radius

	btVector3 inertia;
	shape.calculateLocalInertia(1, inertia);
	btStaticPlaneShape floor(btVector3(0, 1, 0), 0);
	btRigidBody ground(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &floor));
	btRigidBody lower(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, inertia));
	btRigidBody upper(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, inertia));
	lower.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(1.2), 0)));
	upper.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.1), btScalar(3.4), 0)));
	for (btRigidBody* body : {&ground, &lower, &upper}) world.addRigidBody(body);

	for (int step = 0; step < 480; ++step)
	{
		world.stepSimulation(btScalar(1.0 / 240), 0);
		if (step % 60 != 59) continue;
		const clod::StepReport now = context.lastStep();
		std::printf("step %3d: heights %6.3f %6.3f, %u contact points in %u clusters, query %.0f us\n", step + 1,
					double(lower.getWorldTransform().getOrigin().y()),
					double(upper.getWorldTransform().getOrigin().y()), now.points, now.clusters, now.queryMicroseconds);
	}
	for (btRigidBody* body : {&ground, &lower, &upper}) world.removeRigidBody(body);
	return 0;
}
