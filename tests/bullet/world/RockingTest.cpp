// SPDX-License-Identifier: GPL-3.0-or-later
// A body that rocks on another starts each step from the impulses that a solver would end at.
#include <gtest/gtest.h>

#include <cmath>

#include "clod/bullet/ConfigureWorld.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
// Tells by how much of the load contacts are given something else than what they start from.
struct WatchingSolver : btSequentialImpulseConstraintSolver
{
	double changed = 0, load = 0;
	btScalar solveGroup(btCollisionObject** bodies, int bodyCount, btPersistentManifold** manifolds, int manifoldCount,
						btTypedConstraint** constraints, int constraintCount, const btContactSolverInfo& info,
						btIDebugDraw* drawer, btDispatcher* dispatcher) override
	{
		const auto impulses = [&](double share)
		{
			std::vector<double> list;
			for (int i = 0; i < manifoldCount; ++i)
				for (int k = 0; k < manifolds[i]->getNumContacts(); ++k)
					list.push_back(share * double(manifolds[i]->getContactPoint(k).m_appliedImpulse));
			return list;
		};
		const std::vector<double> before = impulses(double(info.m_warmstartingFactor));
		const btScalar residual = btSequentialImpulseConstraintSolver::solveGroup(
			bodies, bodyCount, manifolds, manifoldCount, constraints, constraintCount, info, drawer, dispatcher);
		const std::vector<double> after = impulses(1);
		for (std::size_t i = 0; i < after.size(); ++i)
		{
			changed += std::abs(after[i] - before[i]);
			load += after[i];
		}
		return residual;
	}
};

// A ring of ours that swings on a rod, without friction.
struct SwingingRing
{
	BulletWorld scene;
	WatchingSolver solver;
	btRigidBody& ring;
	SwingingRing() : ring(hang()) {}

private:
	btRigidBody& hang()
	{
		constexpr double kRadius = 0.5, kHole = 0.2209, kRod = 0.1, kAngle = 0.3;  // radii
		scene.world.setConstraintSolver(&solver);
		configureWorld(scene.world);
		scene.timeStep = 1.0 / 60;
		btClodShape& shape = scene.addShape(body("torus-900").hierarchy, kRadius);
		scene.addBody(scene.add(std::make_unique<btCapsuleShapeZ>(btScalar(kRod), btScalar(2))), 0, {});
		const double reach = kHole - kRod;
		btRigidBody& hung = scene.addBody(shape, 1, {reach * std::sin(kAngle), -reach * std::cos(kAngle), 0},
										  btQuaternion(btVector3(1, 0, 0), SIMD_HALF_PI));
		hung.setFriction(0);
		return hung;
	}
};
}  // namespace

// A ring that swings on a rod has contacts close together, between which a solver's iterations shift the load slowly.
// So they start from what they would end at, and have nothing left to do. Without friction, from none of which they
// start in any case.
TEST(Rocking, StartsFromWhatIterationsEndAt)
{
	SwingingRing swing;
	swing.scene.world.getSolverInfo().m_numIterations = 2000;
	swing.scene.world.getSolverInfo().m_leastSquaresResidualThreshold = 0;
	swing.scene.step(20);
	swing.solver.changed = swing.solver.load = 0;
	swing.scene.step(100);
	EXPECT_GT(double(swing.ring.getLinearVelocity().length()), 0.001);
	EXPECT_LT(swing.solver.changed, 1e-3 * swing.solver.load);
}

// On springs from what they pushed with: what would stop rigid bodies is far more.
TEST(Rocking, OnSpringsStartsFromTheLastImpulses)
{
	SwingingRing swing;
	swing.ring.setContactStiffnessAndDamping(2000, 5);
	swing.scene.step(20);
	swing.solver.changed = swing.solver.load = 0;
	swing.scene.step(100);
	EXPECT_GT(swing.solver.load, 0);
	EXPECT_LT(swing.solver.changed, 0.5 * swing.solver.load);
}
}  // namespace clod::test
