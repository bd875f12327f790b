// SPDX-License-Identifier: Zlib
#include "clod/query/BudgetControl.h"

#include <algorithm>
#include <cmath>

namespace clod
{
namespace
{
constexpr double kNotches = 4;     // to an octave of the factor: levels of a hierarchy differ by about one
constexpr double kCoarsest = 80;   // notches; beyond it nothing but the coarsest answer is left
constexpr double kAim = 0.9;       // of the budget
constexpr double kOvers = 0.05;    // of the steps
constexpr int kTrial = 20;         // steps that must fit in until what did not is forgotten: 1 / kOvers
constexpr double kDecay = 0.95;    // of a peak, a step
constexpr double kSteepest = 1.0;  // cost goes with the factor to the power of minus this, at most
constexpr double kNever = -1;       // below all notches
}  // namespace

double BudgetControl::coarsening(const Budget& budget)
{
	if (budget.tests != m_budget.tests || budget.microseconds != m_budget.microseconds) m_failed = kNever;
	m_budget = budget;
	if (!budget.isLimited())
		change(-m_notch);
	else if (budget.tests == 0 || budget.microseconds == 0)
		change(kCoarsest);
	if (budget.isLimited() && m_isKnown && m_notch > 0) refine(budget);
	const double notch = std::floor(m_notch);
	return notch < kCoarsest ? std::exp2(notch / kNotches) : kOff;
}

void BudgetControl::observe(const StepCost& cost)
{
	const auto fade = [](double& peak, double now) { peak = std::max(kDecay * peak, now); };
	const double tests = cost.tests + cost.keptTests;
	fade(m_peak.tests, tests);
	fade(m_peak.microseconds, cost.tests > 0 ? cost.microseconds * tests / cost.tests : cost.microseconds);
	m_isKnown = true;
	const double used = std::max(cost.tests / m_budget.tests, cost.microseconds / m_budget.microseconds);
	const double before = std::floor(m_notch);
	if (!cost.isCut && !(used > 1))
	{
		m_overs = 0;
		if (before > m_failed || ++m_fits < kTrial) return;
		m_failed = kNever;
		m_backOff.succeed();
		return;
	}
	m_fits = 0;
	const double excess = kNotches * std::log2(std::max(1.0, used / kAim));
	change(std::max(excess, (1 - kOvers) * std::exp2(m_overs++)));
	if (!(std::floor(m_notch) > before)) return;
	m_peak = {};
	m_isKnown = false;
	m_failed = before;
	m_backOff.fail();
}

// As far as the last steps leave room; where a step went over the budget, again after a while only.
void BudgetControl::refine(const Budget& budget)
{
	const double used = std::max(m_peak.tests / budget.tests, m_peak.microseconds / budget.microseconds);
	const double notch = std::floor(m_notch), room = kNotches / kSteepest * std::log2(kAim / std::max(used, 1e-9));
	double next = std::max(0.0, m_notch - std::max(kOvers, room >= 1 ? room : 0));
	if (!(used < kAim)) next = std::max(next, notch);
	if (next < notch && std::floor(next) <= m_failed) next = m_backOff.isOver() ? m_failed : std::min(notch, m_failed + 1);
	change(next - m_notch);
}

// What the last steps would have cost then.
void BudgetControl::change(double notches)
{
	const double before = std::floor(m_notch);
	m_notch = std::min(std::max(0.0, m_notch + notches), kCoarsest);
	const double share = std::exp2(kSteepest * (before - std::floor(m_notch)) / kNotches);
	m_peak.tests *= share;
	m_peak.microseconds *= share;
}
}  // namespace clod
