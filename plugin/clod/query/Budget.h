// SPDX-License-Identifier: Zlib
// What a query, or all queries of a step, may cost.
#pragma once
#include <string>

#include "clod/Export.h"
#include "clod/query/Metric.h"

namespace clod
{
// Tests are box tests and hull distances up to the contact list, the search of an overlap's depth besides; the same budget
// gives the same answer. Time is a guess of what is left to do: it may be overrun, and what it buys does not repeat. A
// budget is never exceeded by refining; the coarsest valid answer is given at any budget.
struct Budget
{
	double tests = kOff;
	double microseconds = kOff;
	bool isLimited() const { return tests < kOff || microseconds < kOff; }
};
// Empty, or one sentence naming the first field that cannot be used, and its value.
CLOD_API std::string budgetError(const Budget& budget);
}  // namespace clod
