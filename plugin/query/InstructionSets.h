// SPDX-License-Identifier: Zlib
// Inner loops are compiled twice, for any machine and for one with AVX2, from one file (*Kernel.h, by
// CompiledTwice.h); the machine is asked once at start. They use GCC's vector types and no fused operations, so both
// give the same bits. A kernel's functions need the target from the beginning: attributes on their callers come too
// late for vector types, which GCC splits up function by function before it inlines. Their shuffles and choices by lane
// are GCC's own: no other compiler builds them.
#pragma once

#if !defined(__GNUC__) || defined(__clang__)
#error "plugin/query needs GCC: its kernels use GCC's vector extensions (__builtin_shuffle)"
#endif

#if defined(__x86_64__)
#include <immintrin.h>
#define CLOD_HAS_WIDE 1
#define CLOD_WIDE_BEGIN _Pragma("GCC push_options") _Pragma("GCC target(\"avx2\")")
#define CLOD_WIDE_END _Pragma("GCC pop_options")
#else
#define CLOD_HAS_WIDE 0
#endif

#define CLOD_INLINED inline __attribute__((always_inline))

namespace clod
{
inline bool hasWideInstructions()
{
#if CLOD_HAS_WIDE
	return __builtin_cpu_supports("avx2") != 0;
#else
	return false;
#endif
}
}  // namespace clod
