// SPDX-License-Identifier: Zlib
#include "clod/bullet/WholeStep.h"

#include <algorithm>

namespace clod
{
namespace
{
constexpr double kNearlyMet = 30;  // torus-spiral, 1 ms: 23, numbers-bowl, 10 ms: 28; both fit at rest
constexpr double kFirst = 2;
}  // namespace

void WholeStep::observeRefined(double excess, double budget)
{
	if (!(budget > 0) || !m_backOff.isOver() || !(excess <= kNearlyMet)) return;
	m_isDue = m_isFirst = true;
	m_triedUnder = budget;
}

void WholeStep::observeWhole(double microseconds, double budget)
{
	const bool fits = microseconds <= (m_isFirst ? kFirst : 1) * budget;
	if (fits && !m_isFirst) m_backOff.succeed();
	m_took = m_isFirst ? std::min(microseconds, budget) : microseconds;
	m_isFirst = false;
	if (fits) return;
	m_isDue = false;
	m_backOff.fail();
}
}  // namespace clod
