// SPDX-License-Identifier: Zlib
// Chooses among the compiled versions of the hull distance.
#include "clod/collide/HullDistance.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

#include "clod/collide/InstructionSets.h"

namespace clod
{
namespace
{
#define CLOD_KERNEL "clod/collide/HullDistanceKernel.h"
#include "clod/collide/CompiledTwice.h"
}  // namespace

RelativePose::RelativePose(const Transform& aFromB, double radius)
	: rotation(aFromB.rotation),
	  inverseRotation(transposed(aFromB.rotation)),
	  translation(aFromB.translation),
	  rounding(16 * kDoubleUnit * (3 * radius + length(translation)))
{
}

double separationAlong(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& direction,
					   const Vec3& moveB)
{
	return (kWide ? wide::separationAlong : plain::separationAlong)(a, b, pose, direction, moveB);
}

Vec3 betweenCorners(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const NearCorners& corners,
					const Vec3& moveB)
{
	return (kWide ? wide::betweenCorners : plain::betweenCorners)(a, b, pose, corners, moveB);
}

HullDistance hullDistance(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& start,
						  double stopAbove, const Vec3& moveB, double stopBelow)
{
	return (kWide ? wide::hullDistance : plain::hullDistance)(a, b, pose, start, stopAbove, moveB, stopBelow);
}

HullDistance hullDistancePlain(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& start,
							   double stopAbove, const Vec3& moveB, double stopBelow)
{
	return plain::hullDistance(a, b, pose, start, stopAbove, moveB, stopBelow);
}
}  // namespace clod
