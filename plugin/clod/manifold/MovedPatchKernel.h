// SPDX-License-Identifier: Zlib
// Four faces against a box, and against a prism. For InstructionSets.h: no include guard.

using Lanes = double __attribute__((vector_size(32)));
using Bits = std::int64_t __attribute__((vector_size(32)));

CLOD_INLINED void load(const double (&from)[4], Lanes& r)
{
	std::memcpy(&r, from, sizeof r);
}
// Bit i: lane i of a comparison.
CLOD_INLINED std::uint32_t bitsOf(const Bits& mask)
{
#ifdef CLOD_WIDE
	return std::uint32_t(_mm256_movemask_pd((__m256d)mask));
#else
	std::uint32_t bits = 0;
	for (int i = 0; i < 4; ++i) bits |= mask[i] != 0 ? 1U << i : 0;
	return bits;
#endif
}
// As dot() of two vectors.
CLOD_INLINED void along(const Vec3& direction, const double (&point)[3][4], Lanes& r)
{
	Lanes x, y, z;
	load(point[0], x), load(point[1], y), load(point[2], z);
	r = direction.x * x + direction.y * y + direction.z * z;
}

CLOD_INLINED void leastOf(const Lanes (&of)[3], Lanes& r)
{
	r = of[0] < of[1] ? of[0] : of[1];
	r = r < of[2] ? r : of[2];
}
CLOD_INLINED void mostOf(const Lanes (&of)[3], Lanes& r)
{
	r = of[0] > of[1] ? of[0] : of[1];
	r = r > of[2] ? r : of[2];
}

// Faces whose boxes meet a box.
std::uint32_t nearFaces(const FaceLanes& group, const Vec3& low, const Vec3& high)
{
	Bits apart{};
	for (int axis = 0; axis < 3; ++axis)
	{
		Lanes corners[3], least, most;
		for (int k = 0; k < 3; ++k) load(group.corner[k][axis], corners[k]);
		leastOf(corners, least);
		mostOf(corners, most);
		apart |= (least > high[axis]) | (most < low[axis]);
	}
	return ~bitsOf(apart) & 0xF;
}

// All three corners beyond one of the prism's planes.
CLOD_INLINED void beyond(const double (&corner)[3][3][4], const FacePrism& prism, double top, Bits& r)
{
	Lanes heights[3], least, most;
	for (int k = 0; k < 3; ++k)
	{
		along(prism.normal, corner[k], heights[k]);
		heights[k] -= prism.offset;
	}
	leastOf(heights, least);
	mostOf(heights, most);
	r = (least > top) | (most < prism.bottom);
	for (std::size_t i = 0; i < 3; ++i)
	{
		for (int k = 0; k < 3; ++k) along(prism.side[i], corner[k], heights[k]);
		leastOf(heights, least);
		r |= least > prism.sideOffset[i];
	}
}

std::uint32_t meetingFaces(const FaceLanes& group, const FacePrism& prism, bool stepCounts, double arrivalTop)
{
	Bits outside;
	beyond(group.corner, prism, prism.top, outside);
	if (stepCounts)
	{
		Bits outsideThen;
		beyond(group.carried, prism, arrivalTop, outsideThen);
		outside &= outsideThen;
	}
	Lanes cosine;
	along(prism.normal, group.normal, cosine);
	return bitsOf(~outside & (cosine < kOpposingCosine));
}
