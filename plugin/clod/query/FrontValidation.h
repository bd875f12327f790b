// SPDX-License-Identifier: Zlib
// Is the last front still the front? Its answers once more. Most fronts are what they were (bodies at rest hardly move): each entry
// keeps how much motion the decisions on it and on its children can take, and where few have used that up, these alone
// are made again. If they are the same, so is the front, and only its accepted pairs are left to be evaluated. If one
// is not, the front is made anew (Traversal.cpp).
#pragma once
#include "clod/query/PairDecisions.h"

namespace clod
{
// Whether a front has what it takes, and few enough decisions have to be made again; otherwise it is tried again, and
// slack for it kept, after some traversals only.
bool isWorthValidating(const TraversalSettings& settings, PairFront& front);

// False, perhaps with some answers given: the front has changed. Precondition: worth it.
bool validateFront(const QueryContext& context, const TraversalSettings& settings, PairFront& front, ContactSink& sink,
				   QueryStats& stats);
}  // namespace clod
