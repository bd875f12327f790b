// SPDX-License-Identifier: GPL-3.0-or-later
// Motions of one body relative to another as points of a space whose length is the root of (twice) the kinetic energy
// that a pair of free bodies loses by stopping relative to each other: the least change of velocity in that norm is
// what frictionless impulses at the contacts do. Density 1.
#pragma once
#include <random>

#include "tests/oracle/Solid.h"

namespace clod::oracle
{
using Random = std::mt19937_64;
double uniform(Random& random, double low, double high);
double normal(Random& random);
Vec3 direction(Random& random);
Mat3 rotation(Random& random, double largestAngle);

using Vec6 = std::array<double, 6>;
double dot(const Vec6& a, const Vec6& b);
double length(const Vec6& a);
Vec6 operator+(const Vec6& a, const Vec6& b);
Vec6 operator*(double s, const Vec6& a);

class MotionSpace
{
public:
	MotionSpace(const Solid& a, const Solid& b, const Transform& aFromB);
	Vec6 coordinates(const RelativeMotion& motion) const;
	RelativeMotion motion(const Vec6& coordinates, double timeStep) const;
	// The gradient of dot(n, velocity(point)).
	Vec6 gradient(const Vec3& point, const Vec3& n) const;

private:
	double m_root[6][6] = {};  // lower triangle L; L L^T is the inverse mass; motion = L * coordinates
};

// At an angle of at most `angle` (radians) to the motion, uniform in that cone; the length times `scale`.
Vec6 withinCone(Random& random, const Vec6& axis, double angle, double scale);

// A half space of motions: dot(gradient, y) + offset >= 0, offset in the unit of gradient times y.
struct HalfSpace
{
	Vec6 gradient;
	double offset;
};
// The motion of the intersection nearest to y; or as near to one as so many sweeps come where there is none.
Vec6 leastChange(const std::vector<HalfSpace>& set, const Vec6& y);
bool admits(const std::vector<HalfSpace>& set, const Vec6& y, double slack);

// A motion and what is true of it.
struct Labelled
{
	Vec6 y;
	bool isFree;  // keeps the bodies apart
	bool isDeep;  // gets deeper than may be admitted; neither: in between
};
// How many motions the best single half space found by hindsight gets wrong: deep ones admitted, free ones changed by
// more than `share` of themselves. Found by a perceptron from several starts, so at best as good as the true one; with
// few motions it fits noise.
int bestHalfSpaceFaults(const std::vector<Labelled>& motions, double share, Random& random);
}  // namespace clod::oracle
