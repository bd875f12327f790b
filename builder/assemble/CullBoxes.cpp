// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/assemble/CullBoxes.h"

#include <algorithm>
#include <cmath>

#include "builder/assemble/Geometry.h"
#include "builder/assemble/MassProperties.h"
#include "clod/hierarchy/BoundGrid.h"

namespace clod::builder
{
namespace
{
AxisBox boundsIn(const Mat3& axes, const std::vector<Vec3>& points)
{
	AxisBox box;
	for (const Vec3& p : points) box.add(axes * p);
	return box;
}

double surface(const AxisBox& b)
{
	const Vec3 e = b.extent();
	return e.x * e.y + e.y * e.z + e.z * e.x;
}

// A frame with first axis n, the second turned by `angle` from an arbitrary start.
Mat3 frameOf(const Vec3& n, double angle)
{
	const Vec3 other = std::fabs(n.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
	const Vec3 u = normalized(cross(n, other)), v = cross(n, u);
	const Vec3 second = std::cos(angle) * u + std::sin(angle) * v;
	return {{n, second, cross(n, second)}};
}

// The frame with axes i and j turned into each other.
Mat3 turned(const Mat3& axes, int i, int j, double angle)
{
	Mat3 result = axes;
	result.row[i] = std::cos(angle) * axes.row[i] + std::sin(angle) * axes.row[j];
	result.row[j] = std::cos(angle) * axes.row[j] - std::sin(angle) * axes.row[i];
	return result;
}

// By turns about its axes, as long as they make the box smaller, by ever smaller angles. Tried on some of the points
// where there are many.
Mat3 refined(const Mat3& start, const std::vector<Vec3>& points)
{
	constexpr std::size_t kTried = 48;
	std::vector<Vec3> tried;
	const std::size_t stride = (points.size() + kTried - 1) / kTried;
	for (std::size_t i = 0; i < points.size(); i += stride) tried.push_back(points[i]);
	Mat3 axes = start;
	double least = surface(boundsIn(axes, tried));
	for (double angle = 0.2; angle > 0.006; angle *= 0.5)
		for (bool improves = true; improves;)
		{
			improves = false;
			for (int k = 0; k < 6; ++k)
			{
				const Mat3 other = turned(axes, k % 3, (k + 1) % 3, k < 3 ? angle : -angle);
				const double s = surface(boundsIn(other, tried));
				if (!(s < 0.999 * least)) continue;
				least = s;
				axes = other;
				improves = true;
			}
		}
	return surface(boundsIn(axes, points)) < surface(boundsIn(start, points)) ? axes : start;
}

Mat3 bestAxes(const std::vector<Vec3>& points, const Vec3& normal)
{
	std::vector<Mat3> candidates{Mat3{}, principalAxes(points)};
	constexpr int kTurns = 3;
	const double quarter = std::acos(0.0);
	for (int i = 0; i < kTurns && normal != Vec3{}; ++i) candidates.push_back(frameOf(normal, quarter * i / kTurns));
	Mat3 best = candidates[0];
	double least = std::numeric_limits<double>::infinity();
	for (const Mat3& axes : candidates)
	{
		const double s = surface(boundsIn(axes, points));
		if (s < 0.999 * least) least = s, best = axes;
	}
	return refined(best, points);
}
}  // namespace

OrientedBox fitCullBox(const std::vector<Vec3>& points, const Vec3& normal, float assetRadius)
{
	Mat3 axes = bestAxes(points, normal);
	for (Vec3& row : axes.row) row = toVec3(toFloat3(row));
	const AxisBox bounds = boundsIn(axes, points);
	const Vec3 middle = 0.5 * (bounds.low + bounds.high);
	const Vec3 wanted = transposed(axes) * middle;
	OrientedBox box{};
	for (int i = 0; i < 3; ++i) box.center[i] = nearestAnchor(wanted[i], assetRadius);
	const Vec3 center{double(box.center[0]), double(box.center[1]), double(box.center[2])};
	double radius = 0, half[3] = {0, 0, 0}, largest = length(center);
	for (const Vec3& p : points)
	{
		const Vec3 d = p - center;
		radius = std::max(radius, length(d));
		for (int i = 0; i < 3; ++i) half[i] = std::max(half[i], std::fabs(dot(axes.row[i], d)));
	}
	constexpr double kMargin = 1e-6;  // covers axes that are orthonormal only to float rounding
	const double margin = kMargin * radius + 1e-12 * largest;
	for (int i = 0; i < 3; ++i)
	{
		for (int k = 0; k < 3; ++k) box.axis[i][k] = roundToFloat(axes.row[i][k]);
		box.half[i] = boundAtLeast(half[i] + margin);
	}
	box.radius = boundAtLeast(radius + margin);
	return box;
}
}  // namespace clod::builder
