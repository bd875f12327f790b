// SPDX-License-Identifier: Zlib
// A discrete dynamics world that responds to impacts within the step in which they happen. Contacts of a step are
// found for the motion with which the bodies enter it. An impact changes that motion, and may lead bodies to where no
// contacts were looked for. So after the solve
// - rows that the solver's iterations have not met (PairState::unmet: a light body lies between heavy ones) are solved on,
//   with more and more iterations;
// - pairs whose contacts may miss something of the solved motion (PairState::surprise) are queried again for that
//   motion. What they find is added to their contacts, the bodies are put back, and the step is solved anew, starting
//   from the impulses so far: a further pass;
// - if passes are not enough (a chain that whips around), or contacts gave bodies energy (a pin that shakes in its hole;
//   unless something is there to give it: see isDriving), the step is divided into parts, each with contacts, a solve,
//   motion and passes of its own. The next step starts divided, too, until fewer parts are enough;
// - if the shortest parts still give energy, the bodies that get it are solved without rebounds.
// Impact stepping also ends a part where two bodies first meet, as the paper does: see Stepping. An impact that only
// finer levels see, which are asked for at the part's end, has its time estimated; there the levels in use touch, and
// no finer ones answer before these are apart, too (TimeOfImpact.h, PairMetric.h).
//
// Forces, damping, actions and tick callbacks happen once a step. Only pairs of our shapes are queried again; other
// pairs keep Bullet's contacts. With one pass and one part it behaves as btDiscreteDynamicsWorld.
//
// Cost: a pass takes the dispatch of the pairs it queries and a solve of the world, at most five where rows are unmet; a part takes a whole step's time.
//
// Based on: Otaduy & Lin 2003, sec. 5.3; Mirtich 1996 (conservative advancement). Departs from the paper, which always
// goes back to the time of an impact: where many bodies touch, a step has hundreds of impacts.
#pragma once
#include <BulletCollision/CollisionDispatch/btUnionFind.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <vector>

#include "clod/Export.h"
#include "clod/bullet/Context.h"

class btClodPairAlgorithm;

class CLOD_API btClodDynamicsWorld : public btDiscreteDynamicsWorld
{
public:
	// The context must be the one given to registerAlgorithm for this dispatcher, and outlive the world.
	btClodDynamicsWorld(btDispatcher* dispatcher, btBroadphaseInterface* pairCache, btConstraintSolver* solver,
						btCollisionConfiguration* configuration, clod::Context* context);

	// Where a step is divided.
	enum class Stepping
	{
		kFixed,   // evenly, where passes are not enough
		kImpacts  // also at times of impact
	};
	void setStepping(Stepping stepping) { m_stepping = stepping; }
	// How often contacts are found and solved for the same motion at most, and how many parts a step may have; each at
	// least 1. If a step has more impacts than parts, the rest of it is taken in one part without rebounds, so that no
	// sequence of impacts can stop time.
	void setMostPasses(int passes) { m_mostPasses = passes; }
	void setMostParts(int parts) { m_mostParts = parts; }
	// Numbers of the last step; passes are those of all parts together.
	int passes() const { return m_passes; }
	int parts() const { return m_parts; }
	int pairsAskedAgain() const { return m_pairsAskedAgain; }
	// In how many parts the next step starts: belongs to what a program saves with contacts (Context::saveContacts).
	int expectedParts() const { return m_expectedParts; }
	void expectParts(int parts) { m_expectedParts = parts; }

	void solveConstraints(btContactSolverInfo& info) override;
	// Makes the boxes of bodies enclose their motion in the coming step, with what forces do and the turn between. Bullet's
	// enclose where a body is and where it comes without forces (small ones fall farther in 1/60 s), of kinematic ones only
	// where they are: others would be passed unnoticed. With one pass and one part only kinematic ones are enclosed so.
	void updateAabbs() override;
	// Within a step that is divided: for its next part.
	void performDiscreteCollisionDetection() override;

protected:
	void internalSingleStepSimulation(btScalar timeStep) override;
	void integrateTransforms(btScalar timeStep) override;

private:
	struct State
	{
		btRigidBody* body;
		btTransform pose;
		btVector3 linear, angular;
	};
	struct Start : State
	{
		double energy, freeEnergy;  // kinetic; with what forces alone add in the step
	};
	// Bodies that push each other in a solve.
	struct Island
	{
		double before = 0, free = 0, after = 0;  // kinetic energy
		bool isOurs = false, isDriven = false;
		// What its contacts gave it, as a share of what it could have; none of what is driven.
		double gain() const
		{
			const double could = before > free ? before : free;
			return isOurs && !isDriven && after > could ? after / could - 1 : 0;
		}
	};
	// A pair that moves otherwise than its contacts expect, ordered by the broadphase's ids.
	struct Surprised
	{
		btBroadphaseProxy *low, *high;
	};
	// Returns the largest surprise left, in units of its pair's skin; infinity where contacts gave energy.
	double solveInPasses(btContactSolverInfo& info);
	void solveOnce(btContactSolverInfo& info);
	void solveAgain(btContactSolverInfo& info);
	void solveOn(btContactSolverInfo& info);
	int partsFor(double surprise) const;
	// By what a solve left, and not by times of impact?
	bool mayDivide() const { return m_stepping == Stepping::kFixed && m_mostParts > 1; }
	void solveInParts(btContactSolverInfo& info, int parts, bool isBegun);
	double solvePart(btContactSolverInfo& info, btScalar whole, bool isShortest);
	void solveToImpacts(btContactSolverInfo& info);
	void goOn(btScalar timeStep, btScalar gone);
	void noteKinematic();
	void moveKinematic(btScalar gone);
	void beginPart(btScalar timeStep);
	struct Kinematic
	{
		btRigidBody* body;
		btTransform pose, interpolation;  // when the step began
	};
	struct Impact
	{
		btScalar at = 1, lasts = 0;  // shares of the time; at = 1: there is no impact
	};
	Impact firstImpact(btScalar timeStep);
	struct Earliest
	{
		btScalar at = 1;
		const btCollisionObject *a = nullptr, *b = nullptr;
	};
	using TimeOf = btScalar (btClodPairAlgorithm::*)(const btCollisionObjectWrapper&, const btCollisionObjectWrapper&,
													 const btDispatcherInfo&);
	Earliest earliest(TimeOf timeOf);
	btScalar shareUntilSwitch(btScalar timeStep, btScalar gone);

	void remember(btScalar timeStep);
	void predictFree(btScalar timeStep);
	void predictSolved(btScalar timeStep);
	void putBack();
	double mostUnmet();
	// What a solve has made of the bodies and of the points' impulses.
	void keepSolution();
	void takeBackSolution();
	bool isSolved(const btCollisionObject* a, const btCollisionObject* b);
	double findSurprised();
	bool givesEnergy(btScalar timeStep);
	void solveWithoutRebounds(btContactSolverInfo& info);
	void findIslands();
	int rootOf(const btCollisionObject& object);
	Island& islandOf(const btCollisionObject& object) { return m_islands[std::size_t(rootOf(object))]; }
	// Extends a body's box over its way to `then`, which departs from a straight line by at most `bend`.
	void widenBox(const btCollisionObject& object, const btTransform& then, btScalar bend = 0);
	// Dispatches the surprised pairs and the new ones.
	void askAgain();

	clod::Context& m_context;
	Stepping m_stepping = Stepping::kFixed;
	int m_mostPasses = 3, m_mostParts = 8, m_passes = 1, m_parts = 1, m_pairsAskedAgain = 0;
	btScalar m_lastPart = 0;  // 0: the whole step
	int m_mostMore = 0;       // of solves, where rows are unmet, in this step
	// Motions that a step was divided for mostly go on, so the next one is not tried whole.
	int m_expectedParts = 1;
	btScalar m_nextPart = 0;  // whose contacts are to be found; 0: those of the time that Bullet has set
	std::vector<Start> m_starts;
	std::vector<State> m_solved;
	std::vector<btScalar> m_impulses;  // three a point
	std::vector<Kinematic> m_kinematic;  // of a divided step
	std::vector<clod::PairState*> m_pairs;
	std::vector<Surprised> m_surprised;
	std::vector<btBroadphasePair*> m_asked;
	btUnionFind m_touching;         // of collision objects
	std::vector<Island> m_islands;  // at their roots
};
