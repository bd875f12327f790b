// SPDX-License-Identifier: Zlib
// What Bullet's solver shall make of a contact point, beyond its place and normal. Bullet's contact row asks of the normal
// velocity, in a step dt:
//   v_n dt >= -d                  apart (d > 0),
//   v_n dt >= -d * ERP            overlapping: of velocities where d is above the split threshold, else of positions.
// Ours is v_n dt >= -(d + bend), with what a turning body's path misses of its tangent (PairSolve.h). Where that asks for
// a speed of parting it is written as a token overlap with an ERP of its own, which velocities have to meet.
//
// A point that carries closes a share b of a small gap a step, not all of it. Iterations leave a pile's slowest modes all
// but untouched: they keep 1 - s of their error, and what they leave is momentum and, by warm starting with w, impulse.
// Their errors go by the roots of x^3 + (s + 1 - w) x^2 + s x + s b, which grow unless s + 1 - w > b: piles tremble with
// b = 1, and with b = 1 - w nothing grows, whatever s. Less than that leaves what has landed askew to creep.
#pragma once
#include <BulletCollision/NarrowPhaseCollision/btManifoldPoint.h>

#include "clod/manifold/ContactPoints.h"

namespace clod
{
struct WorldFrame;

// An overlap that stands for a speed of parting, world length: nearer to none than the split threshold of configureWorld.
inline constexpr double kTokenOverlap = 1e-7;

// Sets distance, ERP and restitution of a point that Bullet has combined the materials of, and that has last step's impulse.
void setSolverTerms(const ContactPoint& point, const WorldFrame& frame, btManifoldPoint& written);
}  // namespace clod
