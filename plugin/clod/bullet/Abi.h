// SPDX-License-Identifier: Zlib
// Guard against mixing Bullet's float and double builds, or its versions: they link silently and then corrupt memory.
// Every unit that includes a header of this plugin refers to a symbol that exists in the matching library only; a
// mismatch is a link error that names it.
#pragma once
#include <LinearMath/btScalar.h>

#include "clod/Export.h"

#if defined(BT_USE_DOUBLE_PRECISION)
#define CLOD_BULLET_PRECISION float64
#else
#define CLOD_BULLET_PRECISION float32
#endif
#define CLOD_ABI_JOIN(version, precision) clod_abi_bullet_##version##_##precision
#define CLOD_ABI_EXPAND(version, precision) CLOD_ABI_JOIN(version, precision)
#define CLOD_ABI_SYMBOL CLOD_ABI_EXPAND(BT_BULLET_VERSION, CLOD_BULLET_PRECISION)

extern "C" CLOD_API int CLOD_ABI_SYMBOL;  // 1

namespace
{
// In every unit, whatever of it is called; kept, too, by a linker that drops unused sections.
#if __has_cpp_attribute(gnu::retain)
[[gnu::used, gnu::retain]]
#else
[[gnu::used]]
#endif
const int* const kMatchingBullet = &CLOD_ABI_SYMBOL;
}  // namespace
