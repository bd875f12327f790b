// SPDX-License-Identifier: Zlib
// Separating axes of two oriented boxes, rounded against the float rounding of their axes and of the sums.
#include "clod/query/BoxSeparation.h"

#include <algorithm>
#include <cstring>

namespace clod
{
namespace
{
// The stored axes are orthonormal to float rounding; every projection is off by at most this share of the sizes.
constexpr double kAxisRounding = 6e-7;
// Projections in float: fewer than 40 roundings of 2^-24, of sums below sqrt(3) times the sizes, and the axes' own.
constexpr double kRounding = kAxisRounding + 40 * 1.7321 * 5.97e-8;
constexpr double kFar = 1e15;  // floats could not be squared beyond: the spheres decide

// Four floats; + - * and comparisons go lane by lane.
using Lanes = float __attribute__((vector_size(16)));
using Bits = int __attribute__((vector_size(16)));

Lanes load(const float (&value)[4])
{
	Lanes lanes;
	std::memcpy(&lanes, value, sizeof lanes);
	return lanes;
}
Lanes absolute(Lanes x)
{
	return Lanes(Bits(x) & 0x7FFFFFFF);
}
Lanes least(Lanes x, Lanes y)
{
	return x < y ? x : y;
}
// How far two centres are apart along the axes, whichever way round, when one comes nearer by `move` on the way.
Lanes apart(Lanes between, Lanes move)
{
	const Lanes up = between + least(move, Lanes{}), down = least(-move, Lanes{}) - between;
	return up > down ? up : down;
}

Vec3 centerOf(const CullBox& box)
{
	return {double(box.center[0]), double(box.center[1]), double(box.center[2])};
}

// The vector's components along the axes of a box.
Lanes along(const Lanes (&axis)[3], const Vec3& v)
{
	return axis[0] * float(v.x) + axis[1] * float(v.y) + axis[2] * float(v.z);
}

// Lane i: the sum of the three first lanes of row i; lane 3 is meaningless.
Lanes sumOfRows(Lanes row0, Lanes row1, Lanes row2)
{
	const Lanes low = __builtin_shuffle(row0, row1, Bits{0, 4, 1, 5}), high = __builtin_shuffle(row0, row1, Bits{2, 6, 2, 6});
	const Lanes first = __builtin_shuffle(low, row2, Bits{0, 1, 4, 4}), second = __builtin_shuffle(low, row2, Bits{2, 3, 5, 5}),
				third = __builtin_shuffle(high, row2, Bits{0, 1, 6, 6});
	return first + second + third;
}

double largestOfThree(Lanes x)
{
	return double(std::max({x[0], x[1], x[2]}));
}

// Distance of the origin from the segment between p and p + move.
double toSegment(const Vec3& p, const Vec3& move)
{
	const double squared = lengthSquared(move);
	const double share = squared > 0 ? std::max(0.0, std::min(1.0, -dot(p, move) / squared)) : 0;
	return length(p + share * move);
}

template <class Row>
void setAxes(PlacedBox& box, const Row& component, const CullBox& stored)
{
	for (int c = 0; c < 3; ++c)
	{
		const Lanes lanes = component(c);
		std::memcpy(box.axis[c], &lanes, sizeof lanes);
	}
	const float half[4] = {stored.half[0], stored.half[1], stored.half[2], 0};
	std::memcpy(box.half, half, sizeof half);
	box.radius = double(stored.radius);
}

Lanes componentOf(const CullBox& box, int c)
{
	return Lanes{box.axis[0][c], box.axis[1][c], box.axis[2][c], 0};
}
}  // namespace

PlacedBox placeInA(const CullBox& stored)
{
	PlacedBox box;
	box.center = centerOf(stored);
	box.move = Vec3{};
	box.spread = 0;
	setAxes(box, [&](int c) { return componentOf(stored, c); }, stored);
	return box;
}

PlacedBox placeInA(const CullBox& stored, const RelativePose& pose, const Sweep& sweep)
{
	PlacedBox box;
	box.center = pose.apply(centerOf(stored));
	const Lanes x = componentOf(stored, 0), y = componentOf(stored, 1), z = componentOf(stored, 2);
	const auto turned = [&](int c)
	{
		const Vec3& row = pose.rotation.row[c];
		return x * float(row.x) + y * float(row.y) + z * float(row.z);
	};
	setAxes(box, turned, stored);
	box.move = Vec3{};
	box.spread = 0;
	if (sweep.isZero()) return box;
	box.move = sweep.of(box.center);
	box.spread = length(sweep.angular) * box.radius;
	return box;
}

double boxSeparation(const PlacedBox& a, const PlacedBox& b)
{
	const Vec3 between = b.center - a.center, move = b.move - a.move;
	const double spread = a.spread + b.spread, radii = a.radius + b.radius;
	const bool moves = !(move == Vec3{});
	const double distance = moves ? toSegment(between, move) : length(between);
	const double spheres = distance - radii;
	const double size = radii + distance + (moves ? length(move) : 0);
	if (!(size < kFar)) return spheres - spread - kRounding * size;

	const Lanes axisA[3] = {load(a.axis[0]), load(a.axis[1]), load(a.axis[2])};
	const Lanes axisB[3] = {load(b.axis[0]), load(b.axis[1]), load(b.axis[2])};
	const Lanes halfA = load(a.half), halfB = load(b.half);
	// Row j: cosines between axis j of b and the axes of a.
	Lanes cosines[3];
	for (int j = 0; j < 3; ++j)
		cosines[j] = absolute(axisA[0] * axisB[0][j] + axisA[1] * axisB[1][j] + axisA[2] * axisB[2][j]);
	const Lanes reachB = cosines[0] * halfB[0] + cosines[1] * halfB[1] + cosines[2] * halfB[2];
	const Lanes reachA = sumOfRows(cosines[0] * halfA, cosines[1] * halfA, cosines[2] * halfA);
	Lanes alongA = along(axisA, between), alongB = along(axisB, between);
	alongA = moves ? apart(alongA, along(axisA, move)) : absolute(alongA);
	alongB = moves ? apart(alongB, along(axisB, move)) : absolute(alongB);
	const Lanes ofA = alongA - halfA - reachB, ofB = alongB - halfB - reachA;
	const double best = std::max({spheres, largestOfThree(ofA), largestOfThree(ofB)});
	return best - spread - kRounding * size;
}

double boxRounding(double size)
{
	return 2 * kRounding * size;
}

double boxDistance(const CullBox& box, const Vec3& point)
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
