// SPDX-License-Identifier: Zlib
// GJK with support-plane lower bound, early exit and certified termination.
#include "clod/query/HullDistance.h"

#include <algorithm>
#include <limits>

#include "clod/query/ClosestSimplex.h"
#include "clod/query/SupportScan.h"

namespace clod
{
namespace
{
constexpr int kMaxIterations = 128;
constexpr double kConverged = 1e-11;  // relative to the length of the support points

struct Corner
{
	Vec3 onA, onB;  // frame A
	std::uint32_t indexA, indexB;
	bool sweptA, sweptB, moved;
	bool same(const Corner& o) const
	{
		return indexA == o.indexA && indexB == o.indexB && sweptA == o.sweptA && sweptB == o.sweptB && moved == o.moved;
	}
};

// The corner of a (-) b that is farthest along -direction.
Corner supportAgainst(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& direction,
					  const Vec3& moveB)
{
	Corner corner;
	const Vec3 inB = pose.directionToB(direction);
	corner.indexA = supportVertex(a.vertices, -direction).index;
	corner.indexB = supportVertex(b.vertices, inB).index;
	corner.sweptA = dot(a.sweep, direction) < 0;
	corner.sweptB = dot(b.sweep, inB) > 0;
	Vec3 vertexB = b.vertices.vertex(corner.indexB);
	corner.onA = a.vertices.vertex(corner.indexA);
	if (corner.sweptA) corner.onA += a.sweep;
	if (corner.sweptB) vertexB += b.sweep;
	corner.onB = pose.apply(vertexB);
	corner.moved = dot(moveB, direction) > 0;
	if (corner.moved) corner.onB += moveB;
	return corner;
}

struct Simplex
{
	Corner corner[4];
	Vec3 point[4];  // of a (-) b
	int count = 0;

	bool contains(const Corner& candidate) const
	{
		for (int i = 0; i < count; ++i)
			if (corner[i].same(candidate)) return true;
		return false;
	}
	void add(const Corner& candidate)
	{
		corner[count] = candidate;
		point[count++] = candidate.onA - candidate.onB;
	}
	// Drops the corners without weight.
	void keepWeighted(SimplexPoint& nearest)
	{
		int kept = 0;
		for (int i = 0; i < count; ++i)
		{
			if (!(nearest.weight[i] > 0)) continue;
			corner[kept] = corner[i];
			point[kept] = point[i];
			nearest.weight[kept++] = nearest.weight[i];
		}
		count = kept;
	}
	double size() const
	{
		double squared = 0;
		for (int i = 0; i < count; ++i) squared = std::max(squared, lengthSquared(point[i]));
		return std::sqrt(squared);
	}
};

struct Witness
{
	Vec3 onA, onB;
};

Witness witnessOf(const Simplex& simplex, const SimplexPoint& nearest)
{
	Witness witness;
	for (int i = 0; i < simplex.count; ++i)
	{
		witness.onA += nearest.weight[i] * simplex.corner[i].onA;
		witness.onB += nearest.weight[i] * simplex.corner[i].onB;
	}
	return witness;
}

HullDistance overlapAt(const Witness& witness, int iterations)
{
	HullDistance result;
	result.pointOnA = witness.onA;
	result.pointOnB = witness.onB;
	result.overlap = true;
	result.iterations = iterations;
	return result;
}
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
	const Vec3 unit = normalized(direction);
	const Corner corner = supportAgainst(a, b, pose, unit, moveB);
	return dot(corner.onA - corner.onB, unit) - pose.rounding;
}

HullDistance hullDistance(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& start,
						  double stopAbove, const Vec3& moveB, double stopBelow)
{
	HullDistance result;
	result.upper = std::numeric_limits<double>::infinity();
	result.lower = -result.upper;
	Simplex simplex;
	Vec3 towardsA = lengthSquared(start) > 0 ? start : Vec3{1, 0, 0};
	for (; result.iterations < kMaxIterations; ++result.iterations)
	{
		// The support planes across the current direction bound the distance from below.
		const Vec3 unit = normalized(towardsA);
		const Corner corner = supportAgainst(a, b, pose, unit, moveB);
		const double lower = dot(corner.onA - corner.onB, unit) - pose.rounding;
		if (lower > result.lower)
		{
			result.lower = lower;
			result.normal = unit;
		}
		if (result.lower > stopAbove) break;
		if (simplex.contains(corner)) break;

		// The simplex with the new corner bounds it from above.
		simplex.add(corner);
		const double size = simplex.size();
		SimplexPoint nearest = closestToOrigin(simplex.point, simplex.count);
		simplex.keepWeighted(nearest);
		const Witness witness = witnessOf(simplex, nearest);
		const double apart = length(witness.onA - witness.onB);
		if (nearest.inside || apart <= pose.rounding) return overlapAt(witness, result.iterations);
		if (!(apart + pose.rounding < result.upper)) break;
		result.upper = apart + pose.rounding;
		result.pointOnA = witness.onA;
		result.pointOnB = witness.onB;
		if (result.upper - result.lower <= kConverged * size || result.upper <= stopBelow) break;
		towardsA = nearest.nearest;
	}
	result.lower = std::max(result.lower, 0.0);
	return result;
}
}  // namespace clod
