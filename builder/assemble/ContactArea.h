// SPDX-License-Identifier: GPL-3.0-or-later
// How much area a body touches a plane with when it is pressed to the depth delta at one place: the slab flood fill.
#pragma once
#include "builder/assemble/TriangleTree.h"

namespace clod::builder
{
class ContactArea
{
public:
	// delta: contact tolerance; areas count within `cap` of the start.
	ContactArea(const Mesh& mesh, double delta, double cap);
	// Sum over the faces connected to `start` within the slab |(x - origin) . normal| <= delta of their area projected
	// along normal; at least (2 delta)^2.
	double at(std::uint32_t start, const Vec3& origin, const Vec3& normal) const;

private:
	const Mesh& m_mesh;
	double m_delta, m_cap;
	std::vector<std::array<std::uint32_t, 3>> m_neighbours;
	std::vector<Vec3> m_normals;
};
}  // namespace clod::builder
