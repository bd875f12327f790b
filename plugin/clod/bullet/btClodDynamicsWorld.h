// SPDX-License-Identifier: Zlib
// A discrete dynamics world in which impacts within a step are met within it. A step's contacts are found for the motion
// that the bodies start with; what an impact then makes of it may lead them into what nobody had looked for, or bend their
// way otherwise than was reckoned with. So after the solve
// - the pairs whose contacts may miss something of the motion as solved (PairState::surprise) are asked again for that
//   motion; what they find is added to their contacts, the bodies are put back, and the step is solved anew, from the
//   impulses so far: a further pass;
// - where passes do not settle it (a chain that whips round), the step is taken in parts: contacts, solve and motion for
//   each, passes included.
// Impact stepping besides ends a part where two bodies first meet, as the paper does: see Stepping.
//
// Forces, damping, actions and tick callbacks happen once a step. Shapes of ours only: other pairs keep Bullet's contacts.
// With one pass and one part it is a btDiscreteDynamicsWorld.
//
// Cost: a pass is the dispatch of the pairs it asks and a solve of the world; a part is a step without its bookkeeping.
//
// Based on: Otaduy & Lin 2003, sec. 5.3; Mirtich 1996 (conservative advancement). Departs from the paper, which always goes
// back to the time of an impact: where many bodies touch, impacts come by the hundred a step.
#pragma once
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <vector>

#include "clod/Export.h"
#include "clod/bullet/Context.h"

class CLOD_API btClodDynamicsWorld : public btDiscreteDynamicsWorld
{
public:
	// The context must be the one registerAlgorithm is given for this dispatcher, and outlive the world.
	btClodDynamicsWorld(btDispatcher* dispatcher, btBroadphaseInterface* pairCache, btConstraintSolver* solver,
						btCollisionConfiguration* configuration, clod::Context* context);

	// Where a step is divided.
	enum class Stepping
	{
		kFixed,   // nowhere, or evenly, see setMostParts
		kImpacts  // at times of impact, too
	};
	void setStepping(Stepping stepping) { m_stepping = stepping; }
	// How often contacts are found and solved for the same motion, and how many parts a step may have; at least once. A
	// step with more impacts than parts takes what is left of it in one, without rebounds: no sequence of impacts, and no
	// change of level at one, can hold time up.
	void setMostPasses(int passes) { m_mostPasses = passes; }
	void setMostParts(int parts) { m_mostParts = parts; }
	// Of the last step; passes of all parts together.
	int passes() const { return m_passes; }
	int parts() const { return m_parts; }
	int pairsAskedAgain() const { return m_pairsAskedAgain; }

	void solveConstraints(btContactSolverInfo& info) override;
	// Kinematic bodies' boxes, too, hold the way of the coming step, as their velocities tell: Bullet's hold only where they
	// are, and what goes more than its own size a step passes others that it never comes near.
	void updateAabbs() override;

protected:
	void integrateTransforms(btScalar timeStep) override;

private:
	struct Start
	{
		btRigidBody* body;
		btTransform pose;
		btVector3 linear, angular;
	};
	// A pair that moves otherwise than its contacts expect. By the broadphase's ids.
	struct Surprised
	{
		btBroadphaseProxy *low, *high;
	};
	// Returns the largest surprise left, in skins of its pair.
	double solveInPasses(btContactSolverInfo& info);
	void solveInParts(btContactSolverInfo& info, int parts);
	void solvePart(btContactSolverInfo& info, btScalar whole);
	void solveToImpacts(btContactSolverInfo& info);
	void beginPart(btScalar timeStep, btScalar gone);
	struct Impact
	{
		btScalar at = 1, lasts = 0;  // shares of the time; 1: there is none
	};
	Impact firstImpact(btScalar timeStep);

	void remember();
	void predictFree(btScalar timeStep);
	void predictSolved(btScalar timeStep);
	void putBack();
	double findSurprised();
	// A body's box over its way, which bends by so much between its ends, besides what it was.
	void widenBox(const btCollisionObject& object, const btTransform& then, btScalar bend = 0);
	// Those surprised, and those that are new.
	void askAgain();

	clod::Context& m_context;
	Stepping m_stepping = Stepping::kFixed;
	int m_mostPasses = 3, m_mostParts = 8, m_passes = 1, m_parts = 1, m_pairsAskedAgain = 0;
	btScalar m_lastPart = 0;  // 0: the whole step
	std::vector<Start> m_starts;
	std::vector<clod::PairState*> m_pairs;
	std::vector<Surprised> m_surprised;
	std::vector<btBroadphasePair*> m_asked;
};
