// SPDX-License-Identifier: Zlib
// The version of the library's interface (semver.org; while the first number is 0 the second counts breaks). The build
// reads it from here. Files have a version of their own: kFileVersion in clod/hierarchy/HierarchyFormat.h.
#pragma once

#define CLOD_VERSION_MAJOR 0
#define CLOD_VERSION_MINOR 1
#define CLOD_VERSION_PATCH 0
