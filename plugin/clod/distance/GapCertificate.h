// SPDX-License-Identifier: Zlib
// From the contact list to the signed gap and its certified error.
//
// Terms: S_A, S_B the input solids, dA, dB their surfaces; the front is the set of accepted pairs. Every x of dA and y
// of dB have a front pair (a, b), x in O(a), y in O(b), or a pruned pair above it. Layout.h defines cover, reach,
// protrude, surf.
//
// Apart (no accepted pair's hulls overlap, no component inside the other body):
//   gap >= L = min( tolerance over pruned pairs,
//                   tolerance - cover_a - cover_b over accepted pairs that are no contacts, but whose hulls are within
//                       tolerance + cover_a + cover_b,
//                   lower_ab - cover_a - cover_b over contacts )
//     as x is within cover_a of hull a and y within cover_b of hull b, and their hulls are lower_ab apart; culling
//     boxes enclose the surface itself, so a pruned pair's surfaces are farther apart than the tolerance. Above base
//     levels (StopRule.h) boxes enclose the hulls of the base's nodes: less the largest covers of the two levels.
//   gap <= U = min over contacts ( upper_ab + protrude_a + protrude_b )
//     as both witness points are within protrude of points of the solids.
//   With every cover and protrude 0 (level 0) both are the exact distance of the surfaces.
//
// Overlapping: depth = max( max over x in dA inside S_B of dist(x, dB), the same with A and B exchanged ), gap =
// -depth. Where hulls overlap the nodes tell nothing of a depth: it is that of the input surfaces (Penetration.h), or
// their distance where they do not meet (SurfaceDistance.h).
#pragma once
#include "clod/distance/SurfaceDistance.h"

namespace clod
{
struct Gap
{
	double value, errorBound;
	bool deep = false;
};

// contacts not empty, none overlaps. largestCover: of accepted pairs that are no contacts.
Gap gapApart(const QueryContext& context, const std::vector<Contact>& contacts, double tolerance, double largestCover);

// The least of upper + protrude_a + protrude_b: no point of a contact's two hulls is farther than protrude from its
// solid. contacts not empty.
double highFromWitnesses(const QueryContext& context, const std::vector<Contact>& contacts);

// Of the input surfaces, which do not meet (SurfaceDistance.h).
Gap gapOfSurfaces(const SurfaceDistance& distance);

// The gap is in [low, high].
Gap gapBetween(double low, double high);
}  // namespace clod
