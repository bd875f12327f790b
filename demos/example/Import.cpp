// SPDX-License-Identifier: Zlib
// A saved world goes on for a second.
#include <btBulletDynamicsCommon.h>
#include <clod/bullet/ConfigureWorld.h>

#include <cstdio>

#include "demos/example/Importer.h"

int main(int argc, char** argv)
{
	clod::Context context;
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	ClodImporter importer(&world);
	if (argc != 2 || !clod::setUpWorld(world, context) || !importer.loadFile(argv[1]))
	{
		std::fprintf(stderr, "usage: clod_import saved.bullet\n");
		return 1;
	}
	clod::configureWorld(world);  // files hold some of a world's settings, and the rest is Bullet's again
	for (const std::string& problem : importer.problems()) std::fprintf(stderr, "%s\n", problem.c_str());
	for (int step = 0; step < 240; ++step) world.stepSimulation(btScalar(1.0 / 240), 0);
	for (int i = 0; i < world.getNumCollisionObjects(); ++i)
	{
		const btCollisionObject& object = *world.getCollisionObjectArray()[i];
		std::printf("%s at height %.4f\n", object.getCollisionShape()->getName(),
					double(object.getWorldTransform().getOrigin().y()));
	}
	return importer.problems().empty() ? 0 : 1;
}
