// SPDX-License-Identifier: Zlib
// The vertex of a hull farthest along a direction: a linear scan over padded structure-of-arrays floats, in double,
// four lanes wide. Hulls of a dual hierarchy have some ten vertices: a scan beats any search. The same bits as a plain
// loop: same products, same order of sums, ties to the smallest index. For InstructionSets.h: no include guard.

using Values = double __attribute__((vector_size(32)));
using Indices = std::int64_t __attribute__((vector_size(32)));

CLOD_INLINED void loadFour(const float* from, Values& to)
{
#ifdef CLOD_WIDE
	to = _mm256_cvtps_pd(_mm_loadu_ps(from));  // GCC 12 converts the halves one by one
#else
	float __attribute__((vector_size(16))) four;
	std::memcpy(&four, from, sizeof four);
	to = __builtin_convertvector(four, Values);
#endif
}

CLOD_INLINED void valuesAt(const HullView& hull, std::uint32_t i, const Vec3& direction, Values& values)
{
	Values x, y, z;
	loadFour(hull.x + i, x);
	loadFour(hull.y + i, y);
	loadFour(hull.z + i, z);
	values = x * direction.x + y * direction.y + z * direction.z;
}

// Lane by lane the better of two; of equals the one with the smaller index.
CLOD_INLINED void keepBetter(Values& value, Indices& index, const Values& otherValue, const Indices& otherIndex)
{
	const Indices other = (otherValue > value) | ((otherValue == value) & (otherIndex < index));
	value = other ? otherValue : value;
	index = other ? otherIndex : index;
}

// Lane by lane the vertices from i on, where they are better.
CLOD_INLINED void keepGreater(const HullView& hull, std::uint32_t i, const Indices& index, const Vec3& direction,
							  Values& best, Indices& bestIndex)
{
	Values value;
	valuesAt(hull, i, direction, value);
	const Indices greater = value > best;
	best = greater ? value : best;
	bestIndex = greater ? index : bestIndex;
}

// hull.count > 0. Padding repeats the last vertex, hence never wins against it.
CLOD_INLINED std::uint32_t supportVertex(const HullView& hull, const Vec3& direction)
{
	static_assert(kVertexLanes == 4);
	constexpr std::uint32_t kTwo = 2 * kVertexLanes;
	Values best;
	Indices bestIndex{0, 1, 2, 3};
	valuesAt(hull, 0, direction, best);
	if (hull.count > kVertexLanes)
	{
		// Two chains, of every other group of four: a comparison waits for the one before.
		Values second;
		Indices secondIndex = bestIndex + kVertexLanes, index = bestIndex;
		valuesAt(hull, kVertexLanes, direction, second);
		std::uint32_t i = kTwo;
		for (; i + kVertexLanes < hull.count; i += kTwo)
		{
			index += kTwo;
			keepGreater(hull, i, index, direction, best, bestIndex);
			keepGreater(hull, i + kVertexLanes, index + kVertexLanes, direction, second, secondIndex);
		}
		if (i < hull.count) keepGreater(hull, i, index + kTwo, direction, best, bestIndex);
		keepBetter(best, bestIndex, second, secondIndex);
	}
	keepBetter(best, bestIndex, __builtin_shufflevector(best, best, 2, 3, 0, 1),
			   __builtin_shufflevector(bestIndex, bestIndex, 2, 3, 0, 1));
	keepBetter(best, bestIndex, __builtin_shufflevector(best, best, 1, 0, 3, 2),
			   __builtin_shufflevector(bestIndex, bestIndex, 1, 0, 3, 2));
	return std::uint32_t(bestIndex[0]);
}
