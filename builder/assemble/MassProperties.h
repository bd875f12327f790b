// SPDX-License-Identifier: GPL-3.0-or-later
// Exact volume integrals of a closed triangle mesh, density 1.
#pragma once
#include <array>
#include <vector>

#include "builder/Lod.h"

namespace clod::builder
{
struct MassProperties
{
	double volume = 0;
	Vec3 center;                        // of mass, in the mesh's frame
	std::array<double, 6> inertia{};    // about the centre of mass, mesh axes: xx, yy, zz, xy, xz, yz (tensor entries:
										// the off-diagonals are -integral of x*y and so on)
	std::array<double, 4> principal{};  // unit quaternion x, y, z, w: p_mesh = center + rotate(principal, p_principal);
										// moments ascending
	std::array<double, 3> moments{};    // in that frame
};

// Integrates over the tetrahedra between each triangle and the mesh's box centre (Eberly, Polyhedral Mass Properties).
MassProperties massProperties(const Mesh& mesh);

// Principal directions of the points, the thinnest first.
Mat3 principalAxes(const std::vector<Vec3>& points);
}  // namespace clod::builder
