// SPDX-License-Identifier: Zlib
// GJK with support-plane lower bound, early exit and certified termination. For InstructionSets.h: no include guard.
#include "clod/collide/SimplexKernel.h"

// Of a (-) b.
struct Corner
{
	Vec3 onA, point;    // frame A
	std::uint64_t key;  // names the vertices and the ends of the sweeps
};

// Of these vertices and ends of the sweeps.
CLOD_INLINED void cornerOf(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, std::uint32_t indexA,
						   std::uint32_t indexB, unsigned ends, const Vec3& moveB, Corner& corner)
{
	corner.onA = a.vertices.vertex(indexA) + double(ends >> 2 & 1) * a.sweep;
	const Vec3 onB = pose.apply(b.vertices.vertex(indexB) + double(ends >> 1 & 1) * b.sweep) + double(ends & 1) * moveB;
	corner.point = corner.onA - onB;
	corner.key = std::uint64_t(indexA) << 32 | std::uint64_t(indexB) << 3 | ends;
}

// The corner of a (-) b that is farthest along -direction.
CLOD_INLINED void supportAgainst(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose,
								 const Vec3& direction, const Vec3& moveB, Corner& corner)
{
	const Vec3 inB = pose.directionToB(direction);
	const std::uint32_t indexA = supportVertex(a.vertices, -direction), indexB = supportVertex(b.vertices, inB);
	const bool sweptA = dot(a.sweep, direction)<0, sweptB = dot(b.sweep, inB)> 0, moved = dot(moveB, direction) > 0;
	cornerOf(a, b, pose, indexA, indexB, unsigned(sweptA) << 2 | unsigned(sweptB) << 1 | unsigned(moved), moveB, corner);
}

// By the number of corners: lanes that are free. By the bits of the corners that stay: their lanes, packed, in halves
// as AVX2 moves them; how many.
constexpr Indices kFree[4]{{-1, -1, -1, -1}, {0, -1, -1, -1}, {0, 0, -1, -1}, {0, 0, 0, -1}};
constexpr std::int32_t kPacked[16][8]{
	{0, 1, 0, 1, 0, 1, 0, 1}, {0, 1, 0, 1, 0, 1, 0, 1}, {2, 3, 2, 3, 2, 3, 2, 3}, {0, 1, 2, 3, 2, 3, 2, 3},
	{4, 5, 4, 5, 4, 5, 4, 5}, {0, 1, 4, 5, 4, 5, 4, 5}, {2, 3, 4, 5, 4, 5, 4, 5}, {0, 1, 2, 3, 4, 5, 4, 5},
	{6, 7, 6, 7, 6, 7, 6, 7}, {0, 1, 6, 7, 6, 7, 6, 7}, {2, 3, 6, 7, 6, 7, 6, 7}, {0, 1, 2, 3, 6, 7, 6, 7},
	{4, 5, 6, 7, 6, 7, 6, 7}, {0, 1, 4, 5, 6, 7, 6, 7}, {2, 3, 4, 5, 6, 7, 6, 7}, {0, 1, 2, 3, 4, 5, 6, 7}};
constexpr int kCount[16]{0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};

template <class Vector>
CLOD_INLINED void packed(const std::int32_t (&lanes)[8], Vector& v)
{
#ifdef CLOD_WIDE
	__m256i halves;
	std::memcpy(&halves, lanes, sizeof halves);
	v = (Vector)_mm256_permutevar8x32_epi32((__m256i)v, halves);
#else
	const Vector from = v;
	for (std::size_t i = 0; i < 4; ++i) v[i] = from[lanes[2 * i] / 2];
#endif
}
CLOD_INLINED void packed(const std::int32_t (&lanes)[8], Points& points)
{
	packed(lanes, points.x), packed(lanes, points.y), packed(lanes, points.z);
}

// Up to four corners, a lane each; free lanes repeat the last one. No lane is written to memory by itself: vectors are
// read back at once.
struct Simplex
{
	Points point, onA;
	Indices key{};
	int count = 0;

	CLOD_INLINED bool contains(const Corner& candidate) const
	{
		return count > 0 && bitsOf(key == std::int64_t(candidate.key)) != 0;
	}
	CLOD_INLINED void add(const Corner& candidate)
	{
		const Indices lanes = kFree[count++];
		const Values none{};
		point.x = lanes ? none + candidate.point.x : point.x;
		point.y = lanes ? none + candidate.point.y : point.y;
		point.z = lanes ? none + candidate.point.z : point.z;
		onA.x = lanes ? none + candidate.onA.x : onA.x;
		onA.y = lanes ? none + candidate.onA.y : onA.y;
		onA.z = lanes ? none + candidate.onA.z : onA.z;
		key = lanes ? Indices{} + std::int64_t(candidate.key) : key;
	}
	// Drops the corners without weight.
	CLOD_INLINED void keepWeighted(SimplexPoint& nearest)
	{
		const unsigned kept = bitsOf(nearest.weight > 0.0);
		const auto& lanes = kPacked[kept];
		count = kCount[kept];
		packed(lanes, point), packed(lanes, onA), packed(lanes, key), packed(lanes, nearest.weight);
		nearest.weight = (Indices{} + std::int64_t(count) > Indices{0, 1, 2, 3}) ? nearest.weight : Values{};
	}
	CLOD_INLINED double squaredSize() const
	{
		Values squared;
		product(point, point, squared);
		return largestOf(squared);
	}
};

// A point of a, and the way to it from a point of b.
struct Witness
{
	Points onA;
	Indices key{};
	Values weight{};
	int count = 0;
	Vec3 apart;

	CLOD_INLINED void describe(HullDistance& result) const
	{
		result.pointOnA = combined(weight, onA);
		result.pointOnB = result.pointOnA - apart;
		for (int i = 0; i < count; ++i)
		{
			const std::uint64_t name = std::uint64_t(key[i]), ofA = name >> 32, ofB = (name & 0xFFFFFFFFu) >> 3;
			if (std::max(ofA, ofB) > NearCorners::kMost)
			{
				result.corners = {};
				return;
			}
			result.corners.add(ofA, ofB, unsigned(name & 7));
		}
	}
};

double separationAlong(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& direction,
					   const Vec3& moveB)
{
	const Vec3 unit = normalized(direction);
	Corner corner;
	supportAgainst(a, b, pose, unit, moveB, corner);
	return dot(corner.point, unit) - pose.rounding;
}

Vec3 betweenCorners(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const NearCorners& corners,
					const Vec3& moveB)
{
	Simplex simplex;
	for (int i = 0; i < corners.count(); ++i)
	{
		Corner corner;
		cornerOf(a, b, pose, corners.ofA(i), corners.ofB(i), corners.ends(i), moveB, corner);
		simplex.add(corner);
	}
	SimplexPoint nearest;
	closestToOrigin(simplex.point, simplex.count, nearest);
	return combined(nearest.weight, simplex.point);
}

HullDistance hullDistance(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& start,
						  double stopAbove, const Vec3& moveB, double stopBelow)
{
	HullDistance result;
	result.upper = std::numeric_limits<double>::infinity();
	result.lower = -result.upper;
	Simplex simplex;
	Witness witness;  // of upper
	Vec3 towardsA = lengthSquared(start) > 0 ? start : Vec3{1, 0, 0};
	for (; result.iterations < kMaxIterations; ++result.iterations)
	{
		// The support planes across the current direction bound the distance from below.
		Corner corner;
		supportAgainst(a, b, pose, towardsA, moveB, corner);
		const Vec3 unit = normalized(towardsA);  // the corner need not wait for it
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
		const double squaredSize = simplex.squaredSize();
		SimplexPoint nearest;
		closestToOrigin(simplex.point, simplex.count, nearest);
		simplex.keepWeighted(nearest);
		const Vec3 between = combined(nearest.weight, simplex.point);
		const double apart = length(between);
		const bool overlaps = (nearest.inside || apart <= pose.rounding) && !(result.lower > 0);
		if (!overlaps && !(apart + pose.rounding < result.upper)) break;
		witness = {simplex.onA, simplex.key, nearest.weight, simplex.count, between};
		if (overlaps)
		{
			const int iterations = result.iterations;
			result = HullDistance{};
			result.overlap = true;
			result.iterations = iterations;
			break;
		}
		result.upper = apart + pose.rounding;
		const double open = result.upper - result.lower;
		if (open * open <= kConverged * kConverged * squaredSize || result.upper <= stopBelow) break;
		towardsA = nearest.nearest;
	}
	result.lower = std::max(result.lower, 0.0);
	result.stoppedAbove = result.lower > stopAbove;
	if (!result.stoppedAbove) witness.describe(result);
	return result;
}
