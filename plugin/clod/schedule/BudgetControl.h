// SPDX-License-Identifier: Zlib
// Which coarsening (Metric.h) a budget buys, from what the last steps cost. To refine in the order of s*/s0 until time is
// up ends where all pairs have s*/s0 below one factor: this factor is what is looked for, and fronts, levels and caches
// then work under a budget as without one.
//
// The finest factor is taken that is expected to fit in (CostCurve.h). What goes over is cut off by the query
// (ContactSettings::budget). The first step at another factor costs more, as fronts are made anew: where it was cut, the
// next goes on with them, and says what the factor costs.
//
// Based on: Otaduy & Lin 2003, sec. 3.3 and 5.2 ("constant frame-rate"); Hubbard 1994 (time-critical collision
// detection).
#pragma once
#include "clod/Export.h"
#include "clod/query/Budget.h"
#include "clod/schedule/CostCurve.h"

namespace clod
{
struct StepCost
{
	double tests = 0, microseconds = 0;
	double keptTests = 0;  // what pairs that had nothing to answer took when they last had: bodies that lie still may move
	bool isCut = false;  // the budget was spent before all was answered
};

class CLOD_API BudgetControl
{
public:
	// Of the coming step: 1 without a budget, infinite where there is nothing to spend.
	double coarsening(const Budget& budget);
	// What the step cost that was last asked for.
	void observe(const StepCost& cost);

private:
	int finestThatFits() const;

	Budget m_budget;
	CostCurve m_tests, m_microseconds;  // each known only of steps that it was limited in
	int m_notch = 0;                    // of the factor
	bool m_isNew = false;               // another than in the step before
	bool m_goesOn = false;              // as it was new and cut short
};
}  // namespace clod
