// SPDX-License-Identifier: Zlib
// The grid that bounds are stored on: floats of 13 significant bits, always rounded to the safe side, and for positions
// that only anchor a bound multiples of a power of two.
//
// A certified bound is good to a few per cent (builder/assemble), so its last bits say nothing. With them fixed a file
// that lost or gained a bit in any bound is refused by load(), and files compress better. Cost: a bound is at most
// 2^-12 (0.025 %) looser than what was proved.
#pragma once
#include <cmath>
#include <cstdint>
#include <cstring>

#include "clod/collide/Vector.h"

namespace clod
{
inline constexpr int kBoundBits = 13;
inline constexpr std::uint32_t kBeyondBound = (1u << (24 - kBoundBits)) - 1;  // bits of a float that no bound sets
inline constexpr float kLargestBound = 0x1.FFFp127f;

// Share of the radius that rounding moves a stored vertex by, at most: Asset::storageTolerance.
inline constexpr double kStorageShare = 8.0 / (1 << 24);

inline void store(float (&to)[3], const Vec3& v)
{
	for (int i = 0; i < 3; ++i) to[i] = roundToFloat(v[i]);
}

// Whether v lies on the grid; zero and infinity do.
inline bool isBound(float v)
{
	std::uint32_t bits = 0;
	std::memcpy(&bits, &v, sizeof bits);
	return (bits & kBeyondBound) == 0;
}
// The smallest number of the grid that is at least v; v in [0, kLargestBound].
inline float boundAtLeast(double v)
{
	float f = roundUp(v);
	std::uint32_t bits = 0;
	std::memcpy(&bits, &f, sizeof bits);
	bits = (bits + kBeyondBound) & ~kBeyondBound;
	std::memcpy(&f, &bits, sizeof f);
	return f;
}
// The largest number of the grid that is at most v; v >= 0, finite.
inline float boundAtMost(double v)
{
	float f = roundDown(v);
	std::uint32_t bits = 0;
	std::memcpy(&bits, &f, sizeof bits);
	bits &= ~kBeyondBound;
	std::memcpy(&f, &bits, sizeof f);
	return f;
}

// Centres of spheres and boxes are multiples of this: about a millionth of the radius.
inline double anchorStep(float radius)
{
	return std::ldexp(1.0, std::ilogb(radius) - 20);
}
inline bool isAnchor(float v, float radius)
{
	const double steps = double(v) / anchorStep(radius);
	return steps == std::nearbyint(steps);
}
inline float nearestAnchor(double v, float radius)
{
	const double step = anchorStep(radius);
	return roundToFloat(step * std::nearbyint(v / step));
}
}  // namespace clod
