// SPDX-License-Identifier: GPL-3.0-or-later
// The whole body moved into the solid by one affine map: the quick way of Protrusion.h.
#pragma once
#include <vector>

#include "builder/assemble/HullPlanes.h"
#include "builder/assemble/Protrusion.h"
#include "builder/assemble/TriangleTree.h"

namespace clod::builder
{
// Whether a triangle, clipped to all half-spaces, leaves anything deeper than -slack inside them.
bool meetsInterior(const Triangle& t, const std::vector<HalfSpace>& planes, double slack);

// x -> x + amount * (shift + pull * (center - x))
struct Displacement
{
	Vec3 shift;
	double pull = 0;
	Vec3 center;
	Vec3 at(const Vec3& x) const { return shift + pull * (center - x); }
};

// One convex cell of the body with the input triangles near it.
class Cell
{
public:
	Cell(const Solid& solid, const std::vector<Vec3>& points, const ProtrusionScale& scale)
		: m_solid(solid), m_scale(scale), m_shape(hullShape(points, 0.25 * scale.rounding))
	{
		for (const Vec3& p : m_shape.corners) m_center += (1 / double(m_shape.corners.size())) * p;
		for (const Vec3& p : m_shape.corners) m_radius = std::max(m_radius, length(p - m_center));
	}
	const HullShape& shape() const { return m_shape; }
	const Vec3& center() const { return m_center; }
	double radius() const { return m_radius; }

	// The smallest amount of this displacement (times its largest length) that brings the cell into the solid, up to 15
	// %; infinity beyond `limit`.
	double needed(const Displacement& displacement, double start, double limit);

private:
	std::vector<HalfSpace> moved(const Displacement& d, double amount) const;
	void gather(double limit);

	const Solid& m_solid;
	const ProtrusionScale m_scale;
	HullShape m_shape;
	Vec3 m_center;
	double m_radius = 0;
	double m_gathered = -1;
	std::vector<Triangle> m_near;
};

// Tries the families of maps: straight in along the mean normal with a little contraction, more of it, contraction
// only.
double byDisplacement(Cell& cell, const std::vector<Vec3>& normals, double start, double limit);
}  // namespace clod::builder
