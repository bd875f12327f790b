// SPDX-License-Identifier: Zlib
#pragma once
#include "clod/query/Query.h"

namespace clod
{
// The first part of a pair's dispatch, see Query.h.
struct PairPlan
{
	QueryPlan query;
	double radius;  // of the smaller body
};
}  // namespace clod
