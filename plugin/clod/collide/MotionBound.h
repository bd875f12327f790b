// SPDX-License-Identifier: Zlib
// How far any point of one body has moved relative to the other between two poses: what a cached distance may be wrong
// by.
//
// A point p of B, |p| <= r_B, is seen from A at R p + t. Between poses 1 and 2 it moves by at most
// |t2 - t1| + |R2 - R1| r_B; the norm of the difference of two rotations is 2 sin(angle / 2) = |R2 - R1|_Frobenius /
// sqrt 2. Separating axes fixed to B see the points of A move, hence the same bound the other way round; the larger one
// counts.
//
// Based on: conservative advancement (Mirtich 1996), as in Bullet's btConvexSeparatingDistanceUtil.
#pragma once
#include <algorithm>

#include "clod/collide/HullDistance.h"
#include "clod/collide/Sweep.h"

namespace clod
{
// A bound from below, or above, that a motion may have made wrong by `moved`.
inline float lowerAfter(float bound, float moved)
{
	return bound - moved - kFloatStep * std::abs(bound);
}
inline float upperAfter(float bound, float moved)
{
	return bound + moved + kFloatStep * std::abs(bound);
}

// Norm of the difference of two rotations.
inline double turnBetween(const Mat3& from, const Mat3& to)
{
	double squared = 0;
	for (int i = 0; i < 3; ++i) squared += lengthSquared(to.row[i] - from.row[i]);
	return std::sqrt(0.5 * squared);
}

// Of any point of either body, seen from the other.
struct PartsMotion
{
	double ofA, ofB;
	PartsMotion(const RelativePose& from, const RelativePose& to, double radiusA, double radiusB)
	{
		const double turn = turnBetween(from.rotation, to.rotation);
		ofB = length(to.translation - from.translation) + turn * radiusB;
		const Vec3 originFrom = from.inverseRotation * from.translation, originTo = to.inverseRotation * to.translation;
		ofA = length(originTo - originFrom) + turn * radiusA;
	}
};

inline double motionBound(const RelativePose& from, const RelativePose& to, double radiusA, double radiusB)
{
	const PartsMotion whole(from, to, radiusA, radiusB);
	// Rounding of the two poses and of the axes of the boxes (BoxSeparation.cpp).
	return (1 + kMotionRounding) * std::max(whole.ofA, whole.ofB) + from.rounding + to.rounding;
}

// How much nearer any two convex parts of the bodies can have come, each on its way of the step: a distance, unlike
// what is measured along axes fixed to either body, is the same seen from A as seen from B.
inline double approachBound(const RelativePose& from, const Sweep& before, const RelativePose& to, const Sweep& now,
							double radiusA, double radiusB)
{
	const PartsMotion whole(from, to, radiusA, radiusB);
	const double change = length(now.of(to.translation) - before.of(to.translation)) +
						  length(now.angular - before.angular) * radiusB + length(before.angular) * whole.ofB;
	return (1 + kMotionRounding) * (std::min(whole.ofA, whole.ofB) + change) + from.rounding + to.rounding;
}

// The same for the part of B within a sphere: a point c + u of it, |u| <= r, moves by (R2 - R1) c + t2 - t1 and, beyond
// that, by at most |R2 - R1| r. Only B's points count: for what is measured along directions fixed to A.
class PartMotion
{
public:
	PartMotion() = default;
	PartMotion(const RelativePose& from, const RelativePose& to)
		: m_shift(to.translation - from.translation), m_rounding(from.rounding + to.rounding)
	{
		for (int i = 0; i < 3; ++i)
		{
			m_turn.row[i] = to.rotation.row[i] - from.rotation.row[i];
			m_spread += lengthSquared(m_turn.row[i]);
		}
		m_spread = std::sqrt(0.5 * m_spread);
	}
	// Of one such part.
	class Way
	{
	public:
		Way() = default;
		// Along a unit direction of frame A, to rounding of a float; negative where the whole part moved the other way.
		double along(const Vec3& direction) const { return dot(direction, m_middle) + m_spread; }
		// At least so far along it: 1-Lipschitz bounds of the later pose are carried back with it.
		double leastAlong(const Vec3& direction) const { return dot(direction, m_middle) - m_spread; }
		// Whatever the direction.
		double farthest() const { return length(m_middle) + m_spread; }

	private:
		friend class PartMotion;
		Vec3 m_middle;
		double m_spread = 0;
	};
	Way of(const Vec3& center, double radius) const
	{
		Way way;
		const Vec3& middle = way.m_middle = m_turn * center + m_shift;
		const double rounding = kKeptAxisRounding * (std::abs(middle.x) + std::abs(middle.y) + std::abs(middle.z));
		way.m_spread = rounding + (1 + kMotionRounding) * m_spread * radius + m_rounding;
		return way;
	}

private:
	Mat3 m_turn{{{}, {}, {}}};
	Vec3 m_shift;
	double m_spread = 0, m_rounding = 0;
};

// How much the sweep of any point of B, or its share along an axis of either body, can have changed between two
// queries, m being the motion bound between them: a point p went from q0 to q1, |q1 - q0| <= m, and d1(q1) - d0(q0) =
// (d1 - d0)(t1) + (w1 - w0) x (q1 - t1) + w0 x (q1 - q0), t1 being where the origin of B is.
inline double sweepChange(const RelativePose& from, const Sweep& before, const RelativePose& to, const Sweep& now,
						  double motion, double radiusB)
{
	if (before.isZero() && now.isZero()) return 0;
	const double turn = length(now.angular - before.angular);
	const double longest = length(now.of(to.translation)) + length(now.angular) * radiusB;
	const double axes = turnBetween(from.rotation, to.rotation);  // how far those fixed to B turned
	// The spread of a box changes with the angular part as well, hence twice.
	return (1 + kMotionRounding) * (length(now.of(to.translation) - before.of(to.translation)) + 2 * turn * radiusB +
						 length(before.angular) * motion + axes * longest);
}

// The same along directions fixed to A alone: only B's points count.
inline double sweepChangeOfParts(const RelativePose& from, const Sweep& before, const RelativePose& to,
								 const Sweep& now, double radiusB)
{
	if (before.isZero() && now.isZero()) return 0;
	const double moved = length(to.translation - from.translation) + turnBetween(from.rotation, to.rotation) * radiusB;
	return (1 + kMotionRounding) * (length(now.of(to.translation) - before.of(to.translation)) +
									2 * length(now.angular - before.angular) * radiusB +
									length(before.angular) * moved);
}
}  // namespace clod
