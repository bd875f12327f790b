// SPDX-License-Identifier: Zlib
// What a shared library of ours shows; everything else is hidden. An archive shows nothing beyond the program or
// library it is linked into, and who uses either needs no mark.
#pragma once

#ifdef CLOD_BUILDS_SHARED  // set while a shared library of ours is compiled
#define CLOD_API __attribute__((visibility("default")))
#else
#define CLOD_API
#endif
