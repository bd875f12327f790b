// SPDX-License-Identifier: Zlib
// Inner loops are compiled twice, for any machine and for one with AVX2, from one file (*Kernel.h, by
// CompiledTwice.h); machine and environment are asked once at start. They use the vector types of GCC and clang and no
// fused operations, so both give the same bits. A kernel's functions need the target from the beginning: attributes on
// their callers come too late for vector types, which GCC splits up function by function before it inlines.
#pragma once

#include <cstdlib>

#if !defined(__GNUC__)
#error "plugin/clod/collide needs GCC 12 or clang 16: its kernels use their vector extensions"
#endif

#if defined(__x86_64__)
#include <immintrin.h>
#define CLOD_HAS_WIDE 1
#if defined(__clang__)
#define CLOD_WIDE_BEGIN _Pragma("clang attribute push(__attribute__((target(\"avx2\"))), apply_to = function)")
#define CLOD_WIDE_END _Pragma("clang attribute pop")
#else
#define CLOD_WIDE_BEGIN _Pragma("GCC push_options") _Pragma("GCC target(\"avx2\")")
#define CLOD_WIDE_END _Pragma("GCC pop_options")
#endif
#else
#define CLOD_HAS_WIDE 0
#endif

#define CLOD_INLINED inline __attribute__((always_inline))

namespace clod
{
// CLOD_NO_AVX2=1 in the environment turns AVX2 off.
inline bool hasWideInstructions()
{
#if CLOD_HAS_WIDE
	const char* const off = std::getenv("CLOD_NO_AVX2");
	return __builtin_cpu_supports("avx2") != 0 && !(off && off[0] == '1');
#else
	return false;
#endif
}
}  // namespace clod
