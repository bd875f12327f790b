// SPDX-License-Identifier: Zlib
// Support scan, plain and four lanes wide (AVX2, chosen at run time).
#include "clod/query/SupportScan.h"

#if defined(__x86_64__) && defined(__GNUC__)
#define CLOD_WIDE_SCAN 1
#include <immintrin.h>
#endif

namespace clod
{
Support supportVertexPlain(const HullView& hull, const Vec3& direction)
{
	Support best{double(hull.x[0]) * direction.x + double(hull.y[0]) * direction.y + double(hull.z[0]) * direction.z,
				 0};
	for (std::uint32_t i = 1; i < hull.count; ++i)
	{
		const double value =
			double(hull.x[i]) * direction.x + double(hull.y[i]) * direction.y + double(hull.z[i]) * direction.z;
		if (value > best.value) best = {value, i};
	}
	return best;
}

#ifdef CLOD_WIDE_SCAN
namespace
{
__attribute__((target("avx2"))) inline __m256d valuesAt(const HullView& hull, std::uint32_t i, const __m256d* direction)
{
	const __m256d x = _mm256_mul_pd(_mm256_cvtps_pd(_mm_loadu_ps(hull.x + i)), direction[0]);
	const __m256d y = _mm256_mul_pd(_mm256_cvtps_pd(_mm_loadu_ps(hull.y + i)), direction[1]);
	const __m256d z = _mm256_mul_pd(_mm256_cvtps_pd(_mm_loadu_ps(hull.z + i)), direction[2]);
	return _mm256_add_pd(_mm256_add_pd(x, y), z);
}

// Padding repeats the last vertex, hence never wins against it: a tie goes to the smaller index.
__attribute__((target("avx2"))) Support supportVertexWide(const HullView& hull, const Vec3& direction)
{
	const __m256d along[3] = {_mm256_set1_pd(direction.x), _mm256_set1_pd(direction.y), _mm256_set1_pd(direction.z)};
	__m256d best = valuesAt(hull, 0, along);
	__m256d bestBase = _mm256_setzero_pd();
	for (std::uint32_t i = kVertexLanes; i < hull.padded; i += kVertexLanes)
	{
		const __m256d value = valuesAt(hull, i, along);
		const __m256d greater = _mm256_cmp_pd(value, best, _CMP_GT_OQ);
		best = _mm256_blendv_pd(best, value, greater);
		bestBase = _mm256_blendv_pd(bestBase, _mm256_set1_pd(double(i)), greater);
	}
	alignas(32) double value[4], base[4];
	_mm256_store_pd(value, best);
	_mm256_store_pd(base, bestBase);
	Support result{value[0], std::uint32_t(base[0])};
	for (std::uint32_t lane = 1; lane < 4; ++lane)
	{
		const std::uint32_t index = std::uint32_t(base[lane]) + lane;
		if (value[lane] > result.value || (value[lane] == result.value && index < result.index))
			result = {value[lane], index};
	}
	return result;
}

const bool kWide = __builtin_cpu_supports("avx2") != 0;
}  // namespace

Support supportVertex(const HullView& hull, const Vec3& direction)
{
	return kWide ? supportVertexWide(hull, direction) : supportVertexPlain(hull, direction);
}
#else
Support supportVertex(const HullView& hull, const Vec3& direction)
{
	return supportVertexPlain(hull, direction);
}
#endif
}  // namespace clod
