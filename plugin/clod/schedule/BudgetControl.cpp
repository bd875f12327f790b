// SPDX-License-Identifier: Zlib
#include "clod/schedule/BudgetControl.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace clod
{
namespace
{
constexpr int kCoarsest = CostCurve::kNotches - 1;  // nothing but the coarsest answer is left
// Logarithms of costs: what the first step at another notch takes more, and what must be left for a change beside the
// spread of costs. To stay where steps were over lately the spread must be left, elsewhere nothing.
constexpr double kOfFirst = 0.2, kRoomToChange = 0.05;
constexpr double kProgress = 0.8;  // of the pairs cut in the step before: so few must be cut for this to come to an end
// Steps in which nothing finer is tried: times those in which a change cut some pairs after its first, and at most.
constexpr int kSettled = 3, kMostSettled = 10;
constexpr int kHopeless = 3;       // failures: what is cut at once again is not gone on with

// Of what was spent: had those that were cut cost as much as the others. Halfway: some were new, and cost less again.
double ofAll(const StepCost& cost)
{
	if (!(cost.tests > 0)) return 1;
	return std::sqrt((cost.tests - cost.ofCut) / cost.tests * (1 + double(cost.cut) / cost.answered));
}
}  // namespace

double BudgetControl::coarsening(const Budget& budget)
{
	if (budget.tests != m_budget.tests || budget.microseconds != m_budget.microseconds) m_settled = 0;
	m_budget = budget;
	const int before = m_notch;
	const bool isNothing = budget.tests == 0 || budget.microseconds == 0;
	if (isNothing || !budget.isLimited())
		m_notch = isNothing ? kCoarsest : 0;
	else if (!m_goesOn)
		m_notch = m_settled > 0 ? std::max(m_notch, finestThatFits()) : finestThatFits();
	m_isNew = m_notch != before;
	return m_notch < kCoarsest ? std::exp2(m_notch / CostCurve::kNotchesAnOctave) : kOff;
}

int BudgetControl::finestThatFits() const
{
	const auto fitsIn = [this](const CostCurve& curve, double limit, int notch)
	{
		if (!(limit < kOff) || !curve.isKnown()) return true;
		double room = curve.spread() + kRoomToChange;
		if (notch == m_notch) room = curve.failures(notch) > 0 ? curve.spread() : 0;
		return curve.expected(notch) + room <= std::log(limit);
	};
	const auto fits = [&](int notch)
	{ return fitsIn(m_tests, m_budget.tests, notch) && fitsIn(m_microseconds, m_budget.microseconds, notch); };
	int notch = 0;
	while (notch < kCoarsest && !fits(notch)) ++notch;
	return notch;
}

void BudgetControl::observe(const StepCost& cost)
{
	if (cost.cut > 0)
		m_cutSteps += cost.answered > 0 ? 1 : 0;
	else
		m_settled = std::max(m_settled - 1, std::min(kMostSettled, kSettled * (std::exchange(m_cutSteps, 0) - 1)));
	const bool mayFit = std::max(m_tests.failures(m_notch), m_microseconds.failures(m_notch)) < kHopeless;
	const bool comesToAnEnd = m_isNew || (m_goesOn && cost.answered > 0 && cost.cut <= kProgress * m_cut);
	m_cut = cost.cut;
	m_goesOn = cost.cut > 0 && comesToAnEnd && mayFit && m_notch < kCoarsest;
	if (m_goesOn) return;
	const double ofTests = cost.tests / m_budget.tests, ofTime = cost.microseconds / m_budget.microseconds;
	if ((cost.cut > 0 || ofTests > 1 || ofTime > 1) && m_notch < kCoarsest)
	{
		const double all = cost.answered > 0 ? ofAll(cost) : 1;
		if (ofTests >= ofTime)
			m_tests.exceed(m_notch, std::max(m_budget.tests, all * cost.tests));
		else
			m_microseconds.exceed(m_notch, std::max(m_budget.microseconds, all * cost.microseconds));
		return;
	}
	const double share = m_isNew ? std::exp(-kOfFirst) : 1;
	if (m_budget.tests < kOff) m_tests.observe(m_notch, share * cost.tests);
	if (m_budget.microseconds < kOff && cost.tests > 0) m_microseconds.observe(m_notch, share * cost.microseconds);
}
}  // namespace clod
