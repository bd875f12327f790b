// SPDX-License-Identifier: Zlib
// A hierarchy of the body stretched or mirrored along its axes: all vertices scaled and rounded, every bound worked out
// anew so that it holds for them. Patches stay convex, as a linear map keeps what is convex; certified lengths grow by
// the largest factor, thicknesses and walls by the smallest.
#pragma once
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "clod/Export.h"
#include "clod/hierarchy/Hierarchy.h"

namespace clod
{
// Factors along the body frame's axes; an odd number of negative ones mirrors the body, whose faces are then wound the
// other way. Refused: a factor of zero or not finite, and a body that floats or the rules of a file cannot hold.
// `clod-build check` proves the result as it proves a built file, what a builder takes by a recipe as a bound
// (kScaled). O(bytes), about a microsecond a triangle.
CLOD_API Result<std::shared_ptr<const Hierarchy>> scaledHierarchy(const Hierarchy& hierarchy, const Vec3& scale);

// Those in use of one hierarchy, kept with it (Hierarchy::derived): who asks for the same factors shares one.
class CLOD_API ScaledHierarchies
{
public:
	explicit ScaledHierarchies(const Hierarchy& hierarchy) : m_hierarchy(hierarchy) {}
	// May be called by several threads. What nobody holds any more is made anew.
	Result<std::shared_ptr<const Hierarchy>> by(const Vec3& scale) const;

private:
	const Hierarchy& m_hierarchy;
	mutable std::mutex m_making;
	mutable std::vector<std::pair<Vec3, std::weak_ptr<const Hierarchy>>> m_made;
};
}  // namespace clod
