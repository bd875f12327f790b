// SPDX-License-Identifier: Zlib
// A consumer's whole program, of at most 20 lines of code: a body falls on a floor and comes to rest.
#include <btBulletDynamicsCommon.h>
#include <clod/bullet/ConfigureWorld.h>
#include <clod/bullet/Context.h>
#include <clod/bullet/btClodDispatcher.h>

#include <cstdio>

int main(int, char** arguments)
{
	const auto model = clod::Hierarchy::load(arguments[1]);
	if (!model) return std::puts(model.error().c_str()), 1;
	const btVector3 scale = btVector3(1, 1, 1) / btScalar(model.value()->asset().radius);
	const btTransform start(btQuaternion(btVector3(1, 0, 0), btScalar(0.1)), btVector3(0, 2, 0));
	const auto cup = clod::ClodBody::make(model.value(), {1, scale, start});
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btRigidBody floor(0, nullptr, &plane), &body = cup.value()->body();
	clod::Context context;
	btDefaultCollisionConfiguration configuration;
	btClodDispatcher dispatcher(&configuration, &context);
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	if (!clod::setUpWorld(world, context)) return 1;
	for (btRigidBody* each : {&floor, &body}) world.addRigidBody(each);
	for (int step = 0; step < 1200; ++step) world.stepSimulation(btScalar(1.0 / 240), 0);
	const btScalar height = body.getWorldTransform().getOrigin().y(), speed = body.getLinearVelocity().length();
	const bool rests = height > 0 && height < btScalar(1.1) && speed < btScalar(0.02);
	return std::printf("%s: height %.4f\n", rests ? "rests" : "does not rest", double(height)), rests ? 0 : 1;
}
