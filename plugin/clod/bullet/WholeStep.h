// SPDX-License-Identifier: Zlib
// When a step under a budget of time is answered as if there were none. Without a budget a query walks its trees with
// what it remembers and takes half the time of refinement from the coarsest answer, so a step may fit in whole although
// refinement does not get there. It is tried where refinement came within a factor of the metric, kept up while it fits,
// and tried again after a while when it no longer does. No time at all pays for nothing, and a smaller budget only for
// what was seen to fit in.
#pragma once
#include "clod/query/BackOff.h"

namespace clod
{
class WholeStep
{
public:
	// The next step, under this budget.
	bool isDue(double budget) const { return m_isDue && (m_isFirst ? m_triedUnder : m_took) <= budget; }
	// A step was refined, and misses the metric by this factor still; 0: it does not.
	void observeRefined(double excess, double budget);
	// A step was answered whole. The first one of several has nothing to remember.
	void observeWhole(double microseconds, double budget);

private:
	bool m_isDue = false, m_isFirst = false;
	double m_triedUnder = 0;  // the budget that the first whole step of several is for,
	double m_took = 0;        // and what the last one took
	BackOff m_backOff{63};    // steps until the next attempt
};
}  // namespace clod
