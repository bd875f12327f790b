// SPDX-License-Identifier: Zlib
// Separating axes of two oriented boxes, rounded against the float rounding of their axes and of the sums.
#include "clod/query/BoxSeparation.h"

#include <algorithm>
#include <cstddef>
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

using Bits = int __attribute__((vector_size(16)));

template <int i>
Lanes spreadLane(Lanes x)
{
	return __builtin_shuffle(x, Bits{i, i, i, i});
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
	const Lanes low = __builtin_shuffle(row0, row1, Bits{0, 4, 1, 5}),
				high = __builtin_shuffle(row0, row1, Bits{2, 6, 2, 6});
	const Lanes first = __builtin_shuffle(low, row2, Bits{0, 1, 4, 4}),
				second = __builtin_shuffle(low, row2, Bits{2, 3, 5, 5}),
				third = __builtin_shuffle(high, row2, Bits{0, 1, 6, 6});
	return first + second + third;
}

double largestOfThree(Lanes x)
{
	const Lanes y = spreadLane<1>(x), z = spreadLane<2>(x);
	const Lanes first = x > y ? x : y;
	return double((first > z ? first : z)[0]);
}

// Distance of the origin from the segment between p and p + move.
double toSegment(const Vec3& p, const Vec3& move)
{
	const double squared = lengthSquared(move);
	const double share = squared > 0 ? std::max(0.0, std::min(1.0, -dot(p, move) / squared)) : 0;
	return length(p + share * move);
}

// The stored axes, component by component, and the half lengths.
void unpack(const CullBox& stored, PlacedBox& box)
{
	static_assert(offsetof(CullBox, half) == offsetof(CullBox, axis) + sizeof(CullBox::axis));
	Lanes packed[3];
	std::memcpy(packed, &stored.axis[0][0], sizeof packed);
	const Lanes low = packed[0], middle = packed[1], high = packed[2];
	box.axis[0] = __builtin_shuffle(low, middle, Bits{0, 3, 6, 6});
	box.axis[1] = __builtin_shuffle(low, middle, Bits{1, 4, 7, 7});
	box.axis[2] = __builtin_shuffle(__builtin_shuffle(low, middle, Bits{2, 5, 2, 2}), high, Bits{0, 1, 4, 4});
	box.half = __builtin_shuffle(high, Bits{1, 2, 3, 3});
	box.center = centerOf(stored);
	box.radius = double(stored.radius);
	box.move = Vec3{};
	box.spread = 0;
}

// |cosine| of the angle between axis j of b and the axes of a.
template <int j>
Lanes cosines(const PlacedBox& a, const PlacedBox& b)
{
	return absolute(a.axis[0] * spreadLane<j>(b.axis[0]) + a.axis[1] * spreadLane<j>(b.axis[1]) +
					a.axis[2] * spreadLane<j>(b.axis[2]));
}
}  // namespace

PlacedBox placeInA(const CullBox& stored)
{
	PlacedBox box;
	unpack(stored, box);
	return box;
}

PlacedBox placeInA(const CullBox& stored, const RelativePose& pose, const Sweep& sweep)
{
	PlacedBox box;
	unpack(stored, box);
	const Lanes x = box.axis[0], y = box.axis[1], z = box.axis[2];
	for (int c = 0; c < 3; ++c)
	{
		const Vec3& row = pose.rotation.row[c];
		box.axis[c] = x * float(row.x) + y * float(row.y) + z * float(row.z);
	}
	box.center = pose.apply(box.center);
	if (sweep.isZero()) return box;
	box.move = sweep.of(box.center);
	box.spread = length(sweep.angular) * box.radius;
	return box;
}

double boxSeparation(const PlacedBox& a, const PlacedBox& b)
{
	const Vec3 between = b.center - a.center, move = b.move - a.move;
	const double radii = a.radius + b.radius;
	const bool moves = !(move == Vec3{});
	const double distance = moves ? toSegment(between, move) : length(between);
	const double size = radii + distance + (moves ? length(move) : 0);
	const double slack = a.spread + b.spread + kRounding * size;
	if (!(size < kFar)) return distance - radii - slack;

	const Lanes of0 = cosines<0>(a, b), of1 = cosines<1>(a, b), of2 = cosines<2>(a, b);
	const Lanes reachB = of0 * spreadLane<0>(b.half) + of1 * spreadLane<1>(b.half) + of2 * spreadLane<2>(b.half);
	const Lanes reachA = sumOfRows(of0 * a.half, of1 * a.half, of2 * a.half);
	Lanes alongA = along(a.axis, between), alongB = along(b.axis, between);
	alongA = moves ? apart(alongA, along(a.axis, move)) : absolute(alongA);
	alongB = moves ? apart(alongB, along(b.axis, move)) : absolute(alongB);
	const Lanes ofA = alongA - a.half - reachB, ofB = alongB - b.half - reachA;
	const double spheres = distance - radii, faces = largestOfThree(ofA > ofB ? ofA : ofB);
	return (spheres > faces ? spheres : faces) - slack;
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
