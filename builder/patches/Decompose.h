// SPDX-License-Identifier: GPL-3.0-or-later
// Convex surface decomposition and the merging of neighbouring patches.
// Sources: Ehmann & Lin 2001 (growth over the dual graph); the paper, sec. 4.2 (merging after every operation).
#pragma once
#include <cstddef>

#include "builder/patches/Validity.h"

namespace clod::builder
{
// Most faces a patch may have: keeps hulls small enough for brute-force support and for fast tests.
constexpr std::size_t kFaceLimit = 64;
// Most vertices the patch of a convex component may have: hull vertices are counted in 16 bits.
constexpr std::size_t kVertexLimit = 65535;

// Grows patches from the faces in index order, breadth first, then joins what can be joined; a whole component that is
// convex becomes one patch, whatever its size.
void decompose(PatchMesh& mesh, Validity& validity, const Progress& progress);

// Joins two patches where the union is valid and small enough.
bool tryJoin(PatchMesh& mesh, Validity& validity, std::uint32_t a, std::uint32_t b);
// Joins until no neighbouring pair can be joined. Returns the number of joins.
std::size_t joinEverywhere(PatchMesh& mesh, Validity& validity);
}  // namespace clod::builder
