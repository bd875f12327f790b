// SPDX-License-Identifier: Zlib
// Small fixed-size vectors and rigid transforms in double precision, and the float triple that files store.
// Transforms are named aFromB: pointInA = aFromB * pointInB.
#pragma once
#include <cmath>

#ifndef CLOD_ARITHMETIC
#define CLOD_ARITHMETIC clients  // ours is `exact`, from the build
#endif

namespace clod
{
struct Vec3
{
	double x = 0, y = 0, z = 0;
	double& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
	double operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
};

// Row-major 3x3 matrix.
struct Mat3
{
	Vec3 row[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
	Vec3 column(int i) const { return {row[0][i], row[1][i], row[2][i]}; }
};

// A proper rigid motion. The rotation is orthonormal to rounding; rotationFromQuaternion normalises its input.
struct Transform
{
	Mat3 rotation;
	Vec3 translation;
};

// What files store: 12 bytes, no padding.
struct Float3
{
	float x = 0, y = 0, z = 0;
};

// What computes is named by who compiles it: a program may be built for fused or fast arithmetic, and of functions of
// one name a linker keeps any.
inline namespace CLOD_ARITHMETIC
{
inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Vec3 operator*(const Vec3& a, double s) { return s * a; }
inline Vec3& operator+=(Vec3& a, const Vec3& b) { return a = a + b; }
inline Vec3& operator-=(Vec3& a, const Vec3& b) { return a = a - b; }
inline bool operator==(const Vec3& a, const Vec3& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
inline bool operator!=(const Vec3& a, const Vec3& b) { return !(a == b); }
inline bool operator==(const Mat3& a, const Mat3& b)
{
	return a.row[0] == b.row[0] && a.row[1] == b.row[1] && a.row[2] == b.row[2];
}
inline bool operator==(const Transform& a, const Transform& b)
{
	return a.rotation == b.rotation && a.translation == b.translation;
}
inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(const Vec3& a, const Vec3& b)
{
	return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double lengthSquared(const Vec3& a) { return dot(a, a); }
inline double length(const Vec3& a) { return std::sqrt(dot(a, a)); }
// The axis of the largest component; of equal ones the first.
inline int widestAxis(const Vec3& a) { return a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2; }
// The unit vector along a, or zero where a has no direction.
inline Vec3 normalized(const Vec3& a)
{
	const double l = length(a);
	return l > 0 ? (1 / l) * a : Vec3{};
}
inline bool isFinite(const Vec3& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

inline Vec3 operator*(const Mat3& m, const Vec3& v) { return {dot(m.row[0], v), dot(m.row[1], v), dot(m.row[2], v)}; }
inline Mat3 transposed(const Mat3& m) { return {{m.column(0), m.column(1), m.column(2)}}; }
inline Mat3 operator*(const Mat3& a, const Mat3& b)
{
	const Mat3 bt = transposed(b);
	return {{bt * a.row[0], bt * a.row[1], bt * a.row[2]}};
}

inline Vec3 operator*(const Transform& t, const Vec3& p) { return t.rotation * p + t.translation; }
inline Transform operator*(const Transform& a, const Transform& b)
{
	return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
}
inline Transform inverse(const Transform& t)
{
	const Mat3 rt = transposed(t.rotation);
	return {rt, -(rt * t.translation)};
}
inline Mat3 rotationFromQuaternion(double x, double y, double z, double w)
{
	const double n = x * x + y * y + z * z + w * w;
	const double s = n > 0 ? 2 / n : 0;
	return {{{1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)},
			 {s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)},
			 {s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)}}};
}

inline Vec3 toVec3(const Float3& v) { return {double(v.x), double(v.y), double(v.z)}; }
inline Vec3 toVec3(const float (&v)[3]) { return {double(v[0]), double(v[1]), double(v[2])}; }
// GCC 12 at -O2 pairs float conversions into vectors and then cancels (double)(float)x as if it were exact: the
// volatile keeps the rounding, which every stored bound relies on.
inline float roundToFloat(double x)
{
	const volatile float rounded = float(x);
	return rounded;
}
// The smallest float that is at least x, and the largest that is at most x.
inline float roundUp(double x)
{
	const float nearest = roundToFloat(x);
	return double(nearest) < x ? std::nextafter(nearest, HUGE_VALF) : nearest;
}
inline float roundDown(double x)
{
	return -roundUp(-x);
}
inline Float3 toFloat3(const Vec3& v) { return {roundToFloat(v.x), roundToFloat(v.y), roundToFloat(v.z)}; }
}  // namespace CLOD_ARITHMETIC
}  // namespace clod
