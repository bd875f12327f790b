// SPDX-License-Identifier: GPL-3.0-or-later
// Second-order divided differences over the edges round a vertex, and the position that minimises them.
// Source: I. Guskov, W. Sweldens, P. Schroeder, Multiresolution Signal Processing for Meshes, SIGGRAPH 1999.
#pragma once
#include <optional>
#include <vector>

#include "builder/patches/Orientation.h"

namespace clod::builder
{
// Weights of the jump of the gradient across the edge (j, k) with the opposite vertices l1 and l2, unfolded to a plane:
// they sum to zero and vanish on linear functions.
struct HingeWeights
{
	double l1, l2, j, k;
};
// Empty where the edge or one of the two triangles is thinner than minimumLength.
std::optional<HingeWeights> hingeWeights(const Vec3& j, const Vec3& k, const Vec3& l1, const Vec3& l2,
										 double minimumLength);

// Star of a vertex: ring[i], counter-clockwise, and beyond[i], the vertex opposite to (ring[i], ring[i+1]) outside.
struct Star
{
	std::vector<Vec3> ring;
	std::vector<Vec3> beyond;
};
// Minimiser of the squared differences over the incident and the ring edges, weights taken with the vertex at centre;
// centre itself where no hinge is usable.
Vec3 filteredPosition(const Vec3& centre, const Star& star, double minimumLength);
}  // namespace clod::builder
