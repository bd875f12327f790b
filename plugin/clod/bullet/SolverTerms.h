// SPDX-License-Identifier: Zlib
// What Bullet's solver is to make of a contact point, beyond its place and normal, and in which order it meets contacts.
//
// For a distance d, Bullet's contact row requires of the normal velocity v_n, in a step dt:
//   v_n dt >= -d                  if the bodies are apart (d > 0),
//   v_n dt >= -d * ERP            if they overlap: of velocities if d is above the split threshold, else of positions.
// Ours requires v_n dt >= -(d + bend), where bend is how far a turning body's path departs from its tangent
// (PairSolve.h). If that requires a speed of separation, it is written as a token overlap with an ERP of its own, which
// velocities have to meet.
//
// A point under load closes a share b of a small gap in each step, not all of it. The solver's iterations hardly reduce
// the slowest modes of a pile: they keep 1 - s of their error, which remains as momentum and, by warm starting with the
// factor w, as impulse. These errors follow the roots of x^3 + (s + 1 - w) x^2 + s x + s b, and grow unless s + 1 - w >
// b. So piles tremble with b = 1, and nothing grows with b = 1 - w, whatever s is. With smaller b, bodies that have
// landed askew creep.
//
// Near rest a point that carries speaks for all of its normal, as loads go to and fro between them: coarse surfaces of flat
// bodies are not quite flat. Where b is that of piles, and levels err by more than skins, flats that carry also leave an
// overlap of their skins by b: what sinks as the iterations end too soon, and is thrust out again, lifts a pile and lets it
// sway for ever. Others do not: an arch sags by it, and edges are sharper than skins.
#pragma once
#include <BulletCollision/NarrowPhaseCollision/btManifoldPoint.h>

#include <cstdint>

#include "clod/manifold/ContactPoints.h"

class btDispatcher;
class btPersistentManifold;

namespace clod
{
struct WorldFrame;

// The overlap that stands for a speed of separation, in world lengths: shallower than the split threshold of
// configureWorld.
inline constexpr double kTokenOverlap = 1e-7;

// Sets distance, ERP and restitution of a point, after Bullet has combined the materials and the impulse of the last
// step has been set.
void setSolverTerms(const ContactPoint& point, const WorldFrame& frame, btManifoldPoint& written);

// The speed of separation that Bullet then requires of velocities there, but for a rebound.
double speedOf(const btManifoldPoint& point, double timeStep);

// The farthest that bodies, as solved, come beneath what a point requires of velocities, in world lengths.
double unmetWay(const btPersistentManifold& manifold, double timeStep);

// Puts a dispatcher's manifolds in order before a step: the first of each pair, then the second of each, and so on; among
// these by the bodies' indices in their world. Bullet's solver meets them so in all its iterations. As they are made, those
// of a pair follow each other, and each pair in turn tilts its bodies for all of its load, against the others: what the
// iterations leave adds up, and towers of ten bodies sway or fall. With btDispatcherInfo::m_deterministicOverlappingPairs
// Bullet itself sorts them by pair. Cost: n, and n log n where some came or went. (Bullet's SOLVER_RANDMIZE_ORDER mixes a manifold's points, too: friction
// then holds up to a tenth more than mu N.)
class SolverOrder
{
public:
	// A pair is asked. `last`: the step that it was asked in last, 0 if never; if that is this one, another begins. (Not if
	// Bullet's own dispatcher for several threads asks on these.)
	void enter(btDispatcher& dispatcher, std::uint64_t& last);
	std::uint64_t step() const { return m_step; }
	void goOnFrom(std::uint64_t step) { m_step = step; }
	static void arrange(btDispatcher& dispatcher);

private:
	std::uint64_t m_step = 1;
};

// Did the solver find an impulse there?
bool isPushing(const btPersistentManifold& manifold);
// Do its contacts give energy that somebody wants them to give: a kinematic body's, a belt's, a spring's, or that of a
// rebound faster than the impact?
bool isDriving(const btPersistentManifold& manifold);
}  // namespace clod
