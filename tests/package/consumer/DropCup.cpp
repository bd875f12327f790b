// SPDX-License-Identifier: Zlib
// A consumer's whole program: a body falls on a floor and comes to rest.
#include <btBulletDynamicsCommon.h>
#include <clod/bullet/btClodCollisionAlgorithm.h>
#include <clod/bullet/btClodDispatcher.h>
#include <clod/bullet/btClodShape.h>

#include <cstdio>

int main(int, char** arguments)
{
	const auto model = clod::Hierarchy::load(arguments[1]);
	if (!model) return std::puts(model.error().c_str()), 1;
	clod::Context context;
	btDefaultCollisionConfiguration configuration;
	btClodDispatcher dispatcher(&configuration, &context);
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	if (!btClodCollisionAlgorithm::registerAlgorithm(&dispatcher, &context)) return 1;
	const btScalar scale = btScalar(1 / model.value()->asset().radius);
	btClodShape shape(model.value());
	shape.setLocalScaling(btVector3(scale, scale, scale));
	btVector3 inertia;
	shape.calculateLocalInertia(1, inertia);
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btRigidBody floor(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &plane));
	btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, inertia));
	body.setWorldTransform(btTransform(btQuaternion(btVector3(1, 0, 0), btScalar(0.1)), btVector3(0, 2, 0)));
	for (btRigidBody* each : {&floor, &body}) world.addRigidBody(each);
	for (int step = 0; step < 1200; ++step) world.stepSimulation(btScalar(1.0 / 240), 0);
	const double height = double(body.getWorldTransform().getOrigin().y());
	const double speed = double(body.getLinearVelocity().length() + body.getAngularVelocity().length());
	const bool rests = height > 0 && height < 1.1 && speed < 0.02 && context.lastStep().points > 0;
	std::printf("%s: height %.4f, speed %.5f, %u contact points\n", rests ? "rests" : "does not rest", height, speed,
				context.lastStep().points);
	for (btRigidBody* each : {&floor, &body}) world.removeRigidBody(each);
	return rests ? 0 : 1;
}
