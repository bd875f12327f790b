// SPDX-License-Identifier: Zlib
// Chooses among the compiled versions of the hull distance.
#include "clod/query/HullDistance.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

#include "clod/query/InstructionSets.h"

namespace clod
{
namespace
{
namespace plain
{
#include "clod/query/HullDistanceKernel.h"
}  // namespace plain

#if CLOD_HAS_WIDE
CLOD_WIDE_BEGIN
#define CLOD_WIDE
namespace wide
{
#include "clod/query/HullDistanceKernel.h"
}  // namespace wide
#undef CLOD_WIDE
CLOD_WIDE_END
const bool kWide = hasWideInstructions();
#else
namespace wide = plain;
constexpr bool kWide = false;
#endif
}  // namespace

RelativePose::RelativePose(const Transform& aFromB, double reach)
	: rotation(aFromB.rotation), inverseRotation(transposed(aFromB.rotation)), translation(aFromB.translation)
{
	constexpr double kUnit = std::numeric_limits<double>::epsilon();
	rounding = 16 * kUnit * (3 * reach + length(translation));
}

double separationAlong(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& direction,
					   const Vec3& moveB)
{
	return (kWide ? wide::separationAlong : plain::separationAlong)(a, b, pose, direction, moveB);
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
