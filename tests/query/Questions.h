// SPDX-License-Identifier: GPL-3.0-or-later
// What queries are tested at: pairs of bodies, settings, gaps.
#pragma once
#include <cmath>
#include <vector>

#include "tests/query/Answers.h"
#include "tests/support/Setting.h"

namespace clod::test
{
inline std::vector<BodyPair> pairs()
{
	return {{body("torus", 900), body("torus", 900)},
			{body("number8", 600), body("sphere", 300)},
			{body("box", 12), body("torus", 900)}};
}

// Certified, of the nearest contact's two nodes. Precondition: there is one.
inline double deviationOfNearest(const Hierarchy& a, const Hierarchy& b, const GapResult& result)
{
	const Contact& nearest = *std::min_element(result.contacts.begin(), result.contacts.end(),
											   [](const Contact& l, const Contact& r) { return l.upper < r.upper; });
	return double(a.node(nearest.nodeA).deviation) + double(b.node(nearest.nodeB).deviation);
}

inline constexpr double kAnySpeed = 1e300;  // nothing may be folded into a constant

inline Settings exactSettings(double tolerance)
{
	Settings settings;
	settings.metric.exact = true;
	settings.tolerance = tolerance;
	return settings;
}

// Gap of the smaller radius: a third apart, a third within 1 %, a third overlapping.
inline double stratifiedGap(Random& random, int i)
{
	if (i % 3 == 0) return uniform(random, 0.011, 0.3);
	if (i % 3 == 1) return uniform(random, 0, 0.01);
	return -uniform(random, 0, i % 2 ? 0.01 : 0.1);
}

// Random motion of a step: up to a tenth of the radius, half of it by turning.
inline Sweep randomSweep(Random& random, double radius)
{
	const double size = std::pow(10, uniform(random, -4, -1));
	return {size * radius * randomDirection(random), size * randomDirection(random)};
}

// B's frame when a share of the sweep is done: points move on straight lines, so this is no rotation.
inline Transform sweptPose(const Transform& pose, const Sweep& sweep, double share)
{
	Transform moved = pose;
	const Mat3 columns = transposed(pose.rotation);
	Mat3 turned;
	for (int i = 0; i < 3; ++i) turned.row[i] = columns.row[i] + share * cross(sweep.angular, columns.row[i]);
	moved.rotation = transposed(turned);
	moved.translation += share * sweep.of(pose.translation);
	return moved;
}
}  // namespace clod::test
