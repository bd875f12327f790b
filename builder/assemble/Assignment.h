// SPDX-License-Identifier: GPL-3.0-or-later
// Which node of each level answers for which piece of the input surface.
#pragma once
#include <cstdint>
#include <vector>

#include "builder/Lod.h"
#include "builder/assemble/Parallel.h"
#include "builder/assemble/Piece.h"
#include "builder/assemble/TriangleTree.h"

namespace clod::builder
{
struct LevelAssignment
{
	std::vector<Piece> pieces;  // sorted by face and first code; they cover every face exactly once
	std::vector<Piece> extra;   // for patches that no piece chose: the bit of surface next to them, answered for twice
};

// Level 0: every face belongs to its own patch. Label inheritance: to the patch its level-0 patch was merged into.
LevelAssignment assignByLabel(const std::vector<std::uint32_t>& patchOfFace);

struct AssignmentScale
{
	double radius;
	const ThreadLimit& threads;
};

// Nearest patch, preferring faces turned the same way; faces that straddle patches are split (at most kDepth times)
// while that shortens the distance to the owner's faces noticeably. Where it costs little, a face goes to the patch
// that most of its owner in the level below goes to: fewer nodes then have several parents.
// `input` is the tree of `mesh`.
LevelAssignment assignToNearest(const Mesh& mesh, const TriangleTree& input, const Lod& lod,
								const LevelAssignment& below, const AssignmentScale& scale);

struct Overlap
{
	std::uint32_t coarse, fine;
	double area;
};
// All pairs of patches that share a piece of surface, sorted by (coarse, fine), with the area they share.
std::vector<Overlap> overlaps(const TriangleTree& input, const LevelAssignment& fine, const LevelAssignment& coarse);
}  // namespace clod::builder
