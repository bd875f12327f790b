// SPDX-License-Identifier: Zlib
// From the contact list to the signed gap and its certified error.
//
// Terms: S_A, S_B the input solids, dA, dB their surfaces; the front is the set of accepted pairs. Every x of dA and y
// of dB have a front pair (a, b), x in O(a), y in O(b), or a pruned pair above it. Layout.h defines cover, reach,
// protrude, surf.
//
// Apart (no accepted pair's hulls overlap, no component inside the other body):
//   gap >= L = min( tolerance over pruned pairs,
//                   tolerance - cover_a - cover_b over accepted pairs that are no contacts,
//                   lower_ab - cover_a - cover_b over contacts )
//     as x is within cover_a of hull a and y within cover_b of hull b, and their hulls are lower_ab apart; culling
//     boxes enclose the surface itself, so a pruned pair's surfaces are farther apart than the tolerance.
//   gap <= U = min over contacts ( upper_ab + protrude_a + protrude_b )
//     as both witness points are within protrude of points of the solids.
//   With every cover and protrude 0 (level 0) both are the exact distance of the surfaces.
//
// Overlapping: depth = max( max over x in dA inside S_B of dist(x, dB), the same with A and B exchanged ), gap =
// -depth.
//   Every x of dA is within reach_a of a real face of some node a near B; the search of Penetration.h runs over those
//   faces, and bounds the depth of what they stand for:
//     some real face of B's gathered nodes is no farther from x' than its distance d, and dB within surf_b of it, so x
//     is no deeper than d + reach_a + surf_b. Uses that a point the coarse faces call outside is outside: the
//     assumption that the coarse surface and the input surface have the same side there. Where the input surface of B
//     itself was asked, with the depth d of x' in S_B: x is no deeper than d + reach_a, as sd is 1-Lipschitz. dA is
//     within surf_a of x', so that some point of it is at least d - surf_a deep.
//   With level 0 on both sides all of these are 0, and the faces are the input surface.
//   gap <= upper_ab + protrude_a + protrude_b of any contact, as above; a common point of both hulls has upper_ab = 0.
// The depth must be below the tolerance: what is deeper has faces outside the list.
#pragma once
#include "clod/query/Penetration.h"

namespace clod
{
struct Gap
{
	double value, errorBound;
	bool deep = false;
};

// contacts not empty, none overlaps. largestCover: of accepted pairs that are no contacts.
Gap gapApart(const QueryContext& context, const std::vector<Contact>& contacts, double tolerance, double largestCover);

// contacts not empty, some overlap. inputOnly: all are of level 0.
Gap gapOverlapping(const QueryContext& context, const std::vector<Contact>& contacts, bool inputOnly,
				   const DepthBound& depth);

// The gap is in [low, high].
Gap gapBetween(double low, double high);
}  // namespace clod
