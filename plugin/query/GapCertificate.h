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
//   Level 0 on both sides: the search of Penetration.h bounds it by [lower, upper], and decides inside by the input
//   surface. With coarser nodes, searched [lower, upper] over their real faces: gap >= -(upper + m), m = max over
//   contacts of max( reach_a + surf_b, reach_b + surf_a ):
//     the deepest x has x' on a real face of a within reach_a; some real face of B's gathered nodes is within `upper`
//     of x', and dB within surf_b of that. Uses that a point the coarse faces call outside is outside: the assumption
//     that the coarse surface and the input surface have the same side there.
//   gap <= protrude_a + protrude_b of any overlapping pair: a common point of both hulls.
//   gap <= -(depth - reach_b - surf_a), when the deepest point x' found on a is in a thickened hull b and depth >
//   reach_b +
//     protrude_b, depth its distance to all gathered faces: were x' outside S_B it would be within protrude_b of S_B,
//     hence of dB, yet dB is within reach_b of the gathered faces, hence farther than depth - reach_b. So x' is inside
//     by depth - reach_b; dA is within surf_a of x', and depth is 1-Lipschitz.
// The depth must be below the tolerance: what is deeper has faces outside the contact list.
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

// contacts sorted, not empty, some overlap.
Gap gapOverlapping(const QueryContext& context, const std::vector<Contact>& contacts, double tolerance,
				   const Penetration& penetration, PenetrationScratch& scratch, QueryStats& stats);

// The gap is in [low, high].
Gap gapBetween(double low, double high);
}  // namespace clod
