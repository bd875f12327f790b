// SPDX-License-Identifier: Zlib
// Which coarsening (Metric.h) a budget buys, from what the last steps cost. To refine in the order of s*/s0 until time is
// up ends where all pairs have s*/s0 below one factor: this factor is what is looked for, and fronts, levels and caches
// then work under a budget as without one.
//
// The factor goes up when a step went over the budget, and slowly down while steps fit in, so that about one in
// twenty goes over where the budget binds, and a single one changes nothing. What goes over is cut off by the query
// (ContactSettings::budget).
//
// Based on: Otaduy & Lin 2003, sec. 3.3 and 5.2 ("constant frame-rate"); Hubbard 1994 (time-critical collision
// detection).
#pragma once
#include "clod/Export.h"
#include "clod/query/BackOff.h"
#include "clod/query/Budget.h"

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
	void refine(const Budget& budget);
	void change(double notches);

	Budget m_budget;
	double m_notch = 0;        // of the factor: kNotches double it
	StepCost m_peak;           // of the last steps, as they would cost now; the latest counts most
	bool m_isKnown = false;
	double m_failed = -1;      // the notch of a step that went over the budget; -1: none
	int m_overs = 0, m_fits = 0;  // steps over the budget one after the other, and steps at m_failed that were not
	BackOff m_backOff{127};    // steps until the next attempt to be finer
};
}  // namespace clod
