// SPDX-License-Identifier: GPL-3.0-or-later
// What the motion oracle judges: anything that turns two bodies, a pose and a predicted motion into contact
// constraints.
//
// Frames and signs: all in body A's frame, in the meshes' unit; normals point from B to A; distances are signed,
// negative is penetration. A motion is the velocity field of A's material relative to B's (RelativeMotion).
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "clod/collide/Vector.h"
#include "clod/collide/RelativeMotion.h"

namespace clod::oracle
{
struct TriangleMesh
{
	std::vector<Vec3> vertices;
	std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise from outside
};

// A motion is admitted where dot(normal, velocity(point)) * dt + distance + secondOrder >= 0.
struct Constraint
{
	Vec3 point;           // where the velocity is taken
	Vec3 normal;          // unit, from B to A
	double distance = 0;  // signed, of the surfaces themselves at the pose: no skin and no margin taken off
	double secondOrder = 0;  // what a solver's velocity row grants besides, for the curvature of a turning body's path
};

struct Answer
{
	std::vector<Constraint> constraints;
	std::uint32_t surfaceA = 0, surfaceB = 0;  // which of Subject's surfaces they are of
	bool isMixed = false;                      // of several levels of one body: of no closed surface
	bool knowsSurfaces = true;                 // false: nothing was near enough to say which
};

class Subject
{
public:
	virtual ~Subject() = default;
	// The bodies' closed surfaces, in their own frames; 0 is the full mesh, coarser ones follow. Never change.
	virtual const std::vector<TriangleMesh>& surfacesA() const = 0;
	virtual const std::vector<TriangleMesh>& surfacesB() const = 0;
	// Starts anew: nothing is remembered of the call before. motion.timeStep is dt.
	virtual Answer answer(const Transform& aFromB, const RelativeMotion& motion) = 0;
	// How far apart it keeps bodies: what it may admit in depth. In the meshes' unit.
	virtual double skin() const = 0;
};
}  // namespace clod::oracle
