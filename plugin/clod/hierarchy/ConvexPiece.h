// SPDX-License-Identifier: Zlib
// A hierarchy of one piece: an engine's convex shape, as its partners meet it. What is round is a core grown by a
// radius: a sphere is a point, a capsule a segment. Such thin cores have a surface of no area (kThinCore), whose
// triangles are there twice, back to back: queries of contacts take them as they take any, of a file they would be
// refused.
#pragma once
#include <memory>

#include "clod/Export.h"
#include "clod/collide/ConvexPolyhedron.h"
#include "clod/hierarchy/Hierarchy.h"

namespace clod
{
// Frame: the polyhedron's own. radius: what the body is grown by; it counts in Asset::radius, and nowhere else. A flat
// polyhedron is refused, and one with more vertices than a face can name; else it keeps every rule of a file
// (validate()), but for the area of a thin core. O(vertices).
CLOD_API Result<std::shared_ptr<const Hierarchy>> convexPiece(const ConvexPolyhedron& polyhedron, double radius);
}  // namespace clod
