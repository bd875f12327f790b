// SPDX-License-Identifier: Zlib
// The one walk over two hierarchies, from the roots down and level of the walk by level: visits the pairs of nodes
// whose culling volumes are within the tolerance, and hands every accepted one to the contacts. Above base levels
// (StopRule.h) only primary children are followed, a tree; otherwise all, and a pair of contact nodes is opened only
// where its hulls, too, are near, as boxes of curved patches are far from tight. Children that are apart leave no trace
// but the smallest of their separations: while the motion does not use it up, none of them is looked at.
#pragma once
#include "clod/query/PairDecisions.h"

namespace clod
{
// Makes the front, and hands what answers to the sink. False, perhaps with some given: the limit was met, and the front
// is none.
bool traverse(const QueryContext& context, const TraversalSettings& settings, PairFront& front, ContactSink& sink,
			  QueryStats& stats);

// When the query ends: a front is made in memory of the thread, and kept packed, unless it is at hand; or not at all.
void settle(PairFront& front, bool isKept);

// Does the last front have all pairs of input surfaces that are within the tolerance now, as it was made for more than
// it? Precondition: it is of the same rule, and that of leaves.
bool hasAllAnswers(const QueryContext& context, double tolerance, const PairFront& front);
// Gives its answers once more, whatever has become of its decisions. False, perhaps with some given: pairs that answer
// only while apart have changed. Precondition: it has all.
bool answerFromLast(const QueryContext& context, const TraversalSettings& settings, PairFront& front, ContactSink& sink,
					QueryStats& stats);
}  // namespace clod
