// SPDX-License-Identifier: Zlib
// GJK with support-plane lower bound, early exit and certified termination. For InstructionSets.h: no include guard.
#include "clod/query/SimplexKernel.h"

constexpr int kMaxIterations = 128;
constexpr double kConverged = 1e-11;  // relative to the length of the support points

// Of a (-) b.
struct Corner
{
	Vec3 onA, point;    // frame A
	std::uint64_t key;  // names the vertices and the ends of the sweeps
};

// The corner of a (-) b that is farthest along -direction.
CLOD_INLINED void supportAgainst(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose,
								 const Vec3& direction, const Vec3& moveB, Corner& corner)
{
	const Vec3 inB = pose.directionToB(direction);
	const std::uint32_t indexA = supportVertex(a.vertices, -direction), indexB = supportVertex(b.vertices, inB);
	const bool sweptA = dot(a.sweep, direction)<0, sweptB = dot(b.sweep, inB)> 0, moved = dot(moveB, direction) > 0;
	corner.onA = a.vertices.vertex(indexA);
	if (sweptA) corner.onA += a.sweep;
	Vec3 vertexB = b.vertices.vertex(indexB);
	if (sweptB) vertexB += b.sweep;
	Vec3 onB = pose.apply(vertexB);
	if (moved) onB += moveB;
	corner.point = corner.onA - onB;
	corner.key = std::uint64_t(indexA) << 32 | std::uint64_t(indexB) << 3 | std::uint64_t(sweptA) << 2 |
				 std::uint64_t(sweptB) << 1 | std::uint64_t(moved);
}

struct Simplex
{
	Points point, onA;
	Indices key{};
	int count = 0;

	CLOD_INLINED bool contains(const Corner& candidate) const
	{
		for (int i = 0; i < count; ++i)
			if (key[i] == std::int64_t(candidate.key)) return true;
		return false;
	}
	CLOD_INLINED void add(const Corner& candidate)
	{
		point.x[count] = candidate.point.x, point.y[count] = candidate.point.y, point.z[count] = candidate.point.z;
		onA.x[count] = candidate.onA.x, onA.y[count] = candidate.onA.y, onA.z[count] = candidate.onA.z;
		key[count++] = std::int64_t(candidate.key);
	}
	// Drops the corners without weight.
	CLOD_INLINED void keepWeighted(SimplexPoint& nearest)
	{
		int kept = 0;
		for (int i = 0; i < count; ++i)
		{
			if (!(nearest.weight[i] > 0)) continue;
			if (kept != i)
			{
				point.x[kept] = point.x[i], point.y[kept] = point.y[i], point.z[kept] = point.z[i];
				onA.x[kept] = onA.x[i], onA.y[kept] = onA.y[i], onA.z[kept] = onA.z[i];
				key[kept] = key[i];
				nearest.weight[kept] = nearest.weight[i];
			}
			++kept;
		}
		count = kept;
	}
	CLOD_INLINED double size() const
	{
		Values squared;
		product(point, point, squared);
		double largest = 0;
		for (int i = 0; i < count; ++i) largest = std::max(largest, squared[i]);
		return std::sqrt(largest);
	}
};

struct Witness
{
	Vec3 onA, apart;  // a point of a, and the way to it from a point of b
	double moved = 0;
};
CLOD_INLINED Witness witnessOf(const Simplex& simplex, const SimplexPoint& nearest)
{
	Witness witness;
	for (int i = 0; i < simplex.count; ++i)
	{
		witness.onA += nearest.weight[i] * pointOf(simplex.onA, i);
		witness.apart += nearest.weight[i] * pointOf(simplex.point, i);
		witness.moved += nearest.weight[i] * double(simplex.key[i] & 1);
	}
	return witness;
}

CLOD_INLINED void overlapAt(const Witness& witness, HullDistance& result)
{
	const int iterations = result.iterations;
	result = HullDistance{};
	result.pointOnA = witness.onA;
	result.pointOnB = witness.onA - witness.apart;
	result.moved = witness.moved;
	result.overlap = true;
	result.iterations = iterations;
}

double separationAlong(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& direction,
					   const Vec3& moveB)
{
	const Vec3 unit = normalized(direction);
	Corner corner;
	supportAgainst(a, b, pose, unit, moveB, corner);
	return dot(corner.point, unit) - pose.rounding;
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
		Corner corner;
		supportAgainst(a, b, pose, unit, moveB, corner);
		const double lower = dot(corner.point, unit) - pose.rounding;
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
		SimplexPoint nearest;
		closestToOrigin(simplex.point, simplex.count, nearest);
		simplex.keepWeighted(nearest);
		const Witness witness = witnessOf(simplex, nearest);
		const double apart = length(witness.apart);
		if ((nearest.inside || apart <= pose.rounding) && !(result.lower > 0))
		{
			overlapAt(witness, result);
			return result;
		}
		if (!(apart + pose.rounding < result.upper)) break;
		result.upper = apart + pose.rounding;
		result.pointOnA = witness.onA;
		result.pointOnB = witness.onA - witness.apart;
		result.moved = witness.moved;
		if (result.upper - result.lower <= kConverged * size || result.upper <= stopBelow) break;
		towardsA = nearest.nearest;
	}
	result.lower = std::max(result.lower, 0.0);
	return result;
}
