// SPDX-License-Identifier: Zlib
// What the whole program has on the heap, by glibc's own count; NaN elsewhere.
#pragma once
#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <limits>

namespace clod::demo
{
inline double heapBytes()
{
#if defined(__GLIBC__)
	const struct mallinfo2 heap = mallinfo2();
	return double(heap.uordblks) + double(heap.hblkhd);
#else
	return std::numeric_limits<double>::quiet_NaN();
#endif
}
}  // namespace clod::demo
