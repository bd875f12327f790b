// SPDX-License-Identifier: GPL-3.0-or-later
// A program of a user's, as small as can be, compiled for each of Bullet's precisions and linked by tests.
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>

#include "clod/bullet/btClodCollisionAlgorithm.h"

int main(int, char** arguments)
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	clod::Context context;
	if (!btClodCollisionAlgorithm::registerAlgorithm(&dispatcher, &context)) return 1;
	auto hierarchy = clod::Hierarchy::load(arguments[1]);
	return hierarchy && btClodShape(*hierarchy).scale() == 1 ? 0 : 1;
}
