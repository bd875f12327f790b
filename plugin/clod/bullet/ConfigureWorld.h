// SPDX-License-Identifier: Zlib
// What a Bullet world needs for contacts of detailed concave bodies, set by one call.
#pragma once

class btDynamicsWorld;

namespace clod
{
struct WorldSettings
{
	// Passes of the solver over all contacts of a step. 10 (Bullet's default) leave piles and joints soft; stacks of a
	// hundred bodies want 50.
	int solverIterations = 30;
	// Share of an overlap that a step takes away: of joints, and of contacts (whose push is no momentum: split
	// impulse).
	double erp = 0.2, erp2 = 0.8;
	// Overlaps deeper than the negative of it, in Bullet's lengths, are pushed out by split impulse; the others by
	// velocity, which stays as energy. Below -kTokenOverlap (SolverTerms.h): contacts of turning bodies need velocities.
	double splitImpulsePenetrationThreshold = -1e-6;
};

// Sets the solver of `world`; call it before the first step. Besides the settings: two friction directions, as one
// along the slip lets a leaning body creep sideways for ever, and split impulse. Gravity, bodies and dispatch stay as
// they are.
void configureWorld(btDynamicsWorld& world, const WorldSettings& settings = {});
}  // namespace clod
