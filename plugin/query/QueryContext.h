// SPDX-License-Identifier: Zlib
// What one query prepares once: the two hierarchies, the relative pose with its rounding, and the scale of the pair.
#pragma once
#include "clod/query/BoxSeparation.h"
#include "clod/query/Query.h"

namespace clod
{
struct QueryContext
{
	QueryContext(const Hierarchy& hierarchyA, const Hierarchy& hierarchyB, const Transform& aFromB);

	const Hierarchy& a;
	const Hierarchy& b;
	double reachA, reachB;  // of everything in either hierarchy from its body's origin, corners of tight boxes included
	RelativePose pose;
	double size;  // reach of both bodies and their distance
};

// Hull distance from the canonical start: a function of the two nodes and the pose, whatever was cached. Stops as soon
// as lower > stopAbove.
HullDistance canonicalDistance(const QueryContext& context, std::uint32_t a, std::uint32_t b, double stopAbove);

// dist(hull a, hull b) - h_a - h_b, a lower bound of the distance of everything below (paper eq. 1). Stops as soon as
// it is > stopAbove.
double paperSeparation(const QueryContext& context, std::uint32_t a, std::uint32_t b, double stopAbove);
}  // namespace clod
