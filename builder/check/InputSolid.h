// SPDX-License-Identifier: GPL-3.0-or-later
// The input surface (level 0) as a solid: nearest points by the checker's tree, inside or outside by CGAL (exact).
#pragma once
#include <memory>

#include "builder/check/Subject.h"

namespace clod::check
{
class InputSolid
{
public:
	explicit InputSolid(const Subject& subject);
	~InputSolid();
	const TriangleTree& surface() const { return m_surface; }
	bool holds(const Vec3& p) const;
	// 0 inside.
	double distanceTo(const Vec3& p) const { return holds(p) ? 0 : m_surface.nearest(p).distance; }

private:
	struct Inside;
	TriangleTree m_surface;
	std::unique_ptr<Inside> m_inside;
};
}  // namespace clod::check
