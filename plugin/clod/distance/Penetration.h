// SPDX-License-Identifier: Zlib
// How deep two overlapping bodies are in each other: the deepest surface point of either, as an interval.
//
// Near (contact mode): searches the faces of the leaves near each other. The leaves that can hold a point inside the
// other body are those whose hull overlaps a partner's, and those that are apart from every partner but lie wholly
// inside; which of the two a leaf apart is, one point of it tells. Complete while the depth is below the tolerance
// (GatheredSurface.h). Whole: searches the whole input surfaces through the trees, for any depth.
#pragma once
#include "clod/distance/GatheredSurface.h"

namespace clod
{
struct PenetrationScratch
{
	struct Side
	{
		ContactSide contacts;
		std::vector<DepthCell> heap;
		std::vector<DepthSample> samples;     // corners of the leaves searched, one after the other
		std::vector<std::uint32_t> searched;  // their slots
	};
	Side a, b;
	struct TreeCell
	{
		double upper;
		std::uint32_t node;
		bool operator<(const TreeCell& o) const { return upper != o.upper ? upper < o.upper : node < o.node; }
	};
	std::vector<TreeCell> tree;
};

// Both ends with room for rounding: a lower end <= 0 shows no depth.
// Pairs of leaves sorted by (nodeA, nodeB), not empty: all those within accuracy.enough, the tolerance.
DepthBound nearPenetration(const QueryContext& context, const std::vector<Contact>& near, const DepthAccuracy& accuracy,
						   PenetrationScratch& scratch, QueryStats& stats);

// Of the two input surfaces, at any depth; level 0 of both trees is read.
DepthBound wholePenetration(const QueryContext& context, const DepthAccuracy& accuracy, PenetrationScratch& scratch,
							QueryStats& stats);
}  // namespace clod
