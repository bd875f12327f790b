// SPDX-License-Identifier: Zlib
#include "clod/bullet/ConfigureWorld.h"

#include <BulletDynamics/Dynamics/btDynamicsWorld.h>

namespace clod
{
void configureWorld(btDynamicsWorld& world, const WorldSettings& settings)
{
	btContactSolverInfo& solver = world.getSolverInfo();
	solver.m_numIterations = settings.solverIterations;
	solver.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
	solver.m_splitImpulse = true;
	solver.m_splitImpulsePenetrationThreshold = btScalar(settings.splitImpulsePenetrationThreshold);
	solver.m_erp = btScalar(settings.erp);
	solver.m_erp2 = btScalar(settings.erp2);
}
}  // namespace clod
