// SPDX-License-Identifier: GPL-3.0-or-later
// The surface of one level as a solid: nearest points by the checker's tree, inside or outside by CGAL (exact).
#pragma once
#include <memory>
#include <mutex>

#include "builder/check/Subject.h"

namespace clod::check
{
class LevelSolid
{
public:
	LevelSolid(const Subject& subject, const Level& level);
	~LevelSolid();
	const TriangleTree& surface() const { return m_surface; }
	// Prepared when first asked, from any thread. Dear on the surface itself, where only exact arithmetic decides.
	bool holds(const Vec3& p) const;

private:
	struct Inside;
	TriangleTree m_surface;
	void prepare() const;
	mutable std::once_flag m_prepared;
	mutable std::unique_ptr<Inside> m_inside;
};
}  // namespace clod::check
