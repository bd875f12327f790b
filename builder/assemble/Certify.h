// SPDX-License-Identifier: GPL-3.0-or-later
// The certified numbers of one node against the input surface: upper bounds by convexity.
//
// Lemma: the distance to a convex set is a convex function, so over a polygon it is largest at a corner.
#pragma once
#include "builder/assemble/Draft.h"
#include "builder/assemble/TriangleTree.h"

namespace clod::builder
{
struct Tolerance
{
	double relative;  // an upper bound this much above what was attained is good enough,
	double absolute;  // and so is one this much above it
	double accepted(double lower, double upper) const
	{
		return std::max(upper, std::max((1 + relative) * lower, lower + absolute));
	}
};

// A supremum that is being bounded: attained somewhere, and not exceeded anywhere.
struct Supremum
{
	double lower = 0, upper = 0;
};

// Over n's pieces: the largest distance to its thickened hull, exact at the corners to the distance's own tolerance,
// and the largest to its real faces. input: the mesh that pieces are named by.
struct CoverAndReach
{
	double cover = 0;
	Supremum reach;
};
CoverAndReach coverAndReachOf(const NodeDraft& node, const Mesh& input, const Tolerance& tolerance);

// sup over n's real faces of the distance to the input surface.
Supremum surfOf(const NodeDraft& node, const TriangleTree& input, const Tolerance& tolerance);
}  // namespace clod::builder
