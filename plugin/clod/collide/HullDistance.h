// SPDX-License-Identifier: Zlib
// Certified distance of two convex hulls, each a set of float vertices swept along a segment (its thickness).
//
// GJK in double. The answer depends on the two hulls, the pose and the start direction only, and carries its proof:
// upper is the distance of two points inside the hulls, lower that of two parallel support planes less their rounding.
// No constant has a unit: scaling both hulls and the translation by a power of two scales every result exactly.
//
// Frames: hull a and every result in frame A, hull b in frame B; normals point from B to A.
// Guarantee: lower <= distance <= upper (to `rounding` of RelativePose). upper - lower <= kHullDistanceAccuracy times
// the size of the pair (extents and distance), unless stopped early. Measured by tests/collide/HullDistanceTest.cpp.
//
// Based on: Gilbert, Johnson & Keerthi 1988; van den Bergen 2003 sec. 4.3 (lower bound, termination).
#pragma once
#include <cstdint>
#include <limits>

#include "clod/collide/Constants.h"
#include "clod/collide/ConvexHull.h"

namespace clod
{
// Maps frame B into frame A, prepared once a query.
struct RelativePose
{
	RelativePose() = default;
	// radius: bound of |vertex| in both frames.
	RelativePose(const Transform& aFromB, double radius);
	Vec3 apply(const Vec3& inB) const { return rotation * inB + translation; }
	Vec3 directionToB(const Vec3& inA) const { return inverseRotation * inA; }

	Mat3 rotation, inverseRotation;
	Vec3 translation;
	double rounding = 0;  // bound of the rounding of one support value, a length
};

// Of which corners of the two hulls a pair of near points is made, to be tried at another pose.
struct NearCorners
{
	static constexpr std::uint64_t kMost = 0xFFFF;  // the largest index held
	static constexpr unsigned kBits = 15;           // of head
	std::uint16_t vertices[8]{};                    // of a and b in turn
	std::uint16_t head = 0;                         // the number of corners, 0: not known; the ends of their sweeps

	int count() const { return head & 7; }
	std::uint32_t ofA(int i) const { return vertices[2 * i]; }
	std::uint32_t ofB(int i) const { return vertices[2 * i + 1]; }
	// As bits: of a, of b, of moveB.
	unsigned ends(int i) const { return unsigned(head) >> (3 + 3 * i) & 7; }
	bool haveMoved() const { return (head & (01111 << 3)) != 0; }
	void add(std::uint64_t indexA, std::uint64_t indexB, unsigned whichEnds)
	{
		const int i = count();
		vertices[2 * i] = std::uint16_t(indexA), vertices[2 * i + 1] = std::uint16_t(indexB);
		head = std::uint16_t((unsigned(head) | whichEnds << (3 + 3 * i)) + 1);
	}
};

struct HullDistance
{
	double lower = 0, upper = 0;  // both 0 when the hulls overlap
	Vec3 pointOnA, pointOnB;      // witness points, unless stopped above
	Vec3 normal;                  // unit, from B to A: the direction that lower was measured along; zero on overlap
	NearCorners corners;          // of the witness points, unless stopped above
	bool overlap = false;
	bool stoppedAbove = false;  // lower > stopAbove: the witness points are meaningless
	int iterations = 0;
};

// start: any vector from B towards A (frame A), e.g. the difference of two centres. Stops as soon as lower > stopAbove.
// moveB: hull b is swept along the segment [0, moveB] as well (frame A); pointOnB is then a point of the swept hull.
// Stops as well as soon as upper <= stopBelow: lower and normal are then those reached.
// Whether lower > 0 does not depend on stopAbove >= 0, only how far above: bounds once found are never given up.
HullDistance hullDistance(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& start,
						  double stopAbove, const Vec3& moveB = {},
						  double stopBelow = -std::numeric_limits<double>::infinity());
// The same bits from the code for any machine.
HullDistance hullDistancePlain(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& start,
							   double stopAbove, const Vec3& moveB = {},
							   double stopBelow = -std::numeric_limits<double>::infinity());

// The shortest way between the hulls of these corners, from b to a: nowhere are a and b farther apart. Precondition:
// they are known.
Vec3 betweenCorners(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const NearCorners& corners,
					const Vec3& moveB = {});

// Certified lower bound of the distance from the support planes across one direction (frame A, from B to A); may be
// negative. O(vertices).
double separationAlong(const ConvexHull& a, const ConvexHull& b, const RelativePose& pose, const Vec3& direction,
					   const Vec3& moveB = {});
}  // namespace clod
