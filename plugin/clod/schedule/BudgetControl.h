// SPDX-License-Identifier: Zlib
// Which coarsening (Metric.h) a budget buys, from what the last steps cost. To refine in the order of s*/s0 until time
// is up ends where all pairs have s*/s0 below one factor: this factor is what is looked for, and fronts, levels and
// caches then work under a budget as without one.
//
// The finest factor is taken that is expected to fit in (CostCurve.h). What goes over is cut off by the query
// (ContactSettings::budget). The first step at another factor costs more, as fronts are made anew: where it was cut,
// the next go on with them while each cuts off fewer pairs, and say what the factor costs: had those that were cut off
// cost as much as the others.
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
	std::uint32_t cut = 0, answered = 0;  // pairs for which not enough was left; and those within the budget
	double ofCut = 0;                     // tests that the former took
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
	bool m_goesOn = true;               // as it was new and cut short, and comes to an end: the first step is new
	std::uint32_t m_cut = ~0U;          // pairs in the step before
	int m_cutSteps = 0;                 // in a row, until now, of some pairs
	int m_settled = 0;                  // steps to come in which nothing finer is tried
};
}  // namespace clod
