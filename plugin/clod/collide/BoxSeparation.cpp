// SPDX-License-Identifier: Zlib
// What the kernel needs of a pose, and the rounding of floats.
#include "clod/collide/BoxSeparation.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "clod/collide/InstructionSets.h"

namespace clod
{
namespace
{
// What is along a box's axes is known to load()'s tolerance: an axis of another length takes half of it off a
// projection on that axis, axes that are not orthonormal three times it off a corner. Of the sizes.
constexpr double kAxisRounding = 4 * kAxisTolerance;
// Projections in float: fewer than 40 roundings, of sums below sqrt(3) times the sizes, and the axes' own.
constexpr double kRounding = kAxisRounding + 40 * kRootOf3 * kFloatUnit;

#define CLOD_KERNEL "clod/collide/BoxSeparationKernel.h"
#include "clod/collide/CompiledTwice.h"

// Of lengths that floats cannot square.
std::uint32_t sphereSeparations(const BoxFrame& frame, const OrientedBox& one, bool oneIsOfA,
								const OrientedBox* const* others, std::uint32_t count, float* separations, float limit)
{
	std::uint32_t within = 0;
	for (std::uint32_t i = 0; i < count; ++i)
	{
		const OrientedBox &a = oneIsOfA ? one : *others[i], &b = oneIsOfA ? *others[i] : one;
		Vec3 center = toVec3(frame.translation);
		for (int c = 0; c < 3; ++c) center[c] += dot(toVec3(frame.rotation[c]), centerOf(b));
		const Vec3 move = toVec3(frame.linear) + cross(toVec3(frame.angular), center);
		const double radii = double(a.radius) + double(b.radius), turn = double(frame.turn) * double(b.radius);
		const double distance = distanceToSegment(center - centerOf(a), move);
		separations[i] = float(distance - radii - turn - (kRounding + kSphereRounding) * frame.size);
		within |= separations[i] <= limit ? 1U << i : 0;
	}
	return within;
}
}  // namespace

BoxFrame::BoxFrame(const RelativePose& pose, const Sweep& sweep, double sizeOfPair)
	: turn(float((1 + 4 * kFloatUnit) * length(sweep.angular))), size(sizeOfPair), moves(!sweep.isZero())
{
	for (int i = 0; i < 3; ++i)
	{
		for (int j = 0; j < 3; ++j) rotation[i][j] = float(pose.rotation.row[i][j]);
		translation[i] = float(pose.translation[i]);
		linear[i] = float(sweep.linear[i]);
		angular[i] = float(sweep.angular[i]);
	}
	// A component of a place or a way is a sum of at most four products of floats: 8 roundings, in three components.
	rounding = float(kRootOf3 * 8 * kFloatUnit * (size + 2 * length(sweep.angular) * size));
	isHuge = !(size < kLargestInFloat);
}

double BoxFrame::roundingOfTwo() const
{
	return 2 * (kRounding * size + double(rounding));
}

std::uint32_t boxSeparations(const BoxFrame& frame, const OrientedBox& one, bool oneIsOfA,
							 const OrientedBox* const* others, std::uint32_t count, float* separations, float limit)
{
	const auto separate = frame.isHuge ? sphereSeparations : kWide ? wide::boxSeparations : plain::boxSeparations;
	return separate(frame, one, oneIsOfA, others, count, separations, limit);
}

std::uint32_t boxSeparationsPlain(const BoxFrame& frame, const OrientedBox& one, bool oneIsOfA,
								  const OrientedBox* const* others, std::uint32_t count, float* separations,
								  float limit)
{
	return (frame.isHuge ? sphereSeparations : plain::boxSeparations)(frame, one, oneIsOfA, others, count, separations,
																	  limit);
}

double boxDistance(const OrientedBox& box, const Vec3& point)
{
	const Vec3 offset = point - centerOf(box);
	double squared = 0;
	for (int i = 0; i < 3; ++i)
	{
		const Vec3 axis{double(box.axis[i][0]), double(box.axis[i][1]), double(box.axis[i][2])};
		const double beyond = std::max(0.0, std::abs(dot(offset, axis)) - double(box.half[i]));
		squared += beyond * beyond;
	}
	const double distance = length(offset), radius = double(box.radius);
	const double best = std::max(std::sqrt(squared), distance - radius);
	return std::max(0.0, best - kAxisRounding * (radius + distance));
}
}  // namespace clod
