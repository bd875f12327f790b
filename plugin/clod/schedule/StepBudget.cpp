// SPDX-License-Identifier: Zlib
#include "clod/schedule/StepBudget.h"

#include <algorithm>

namespace clod
{
void StepBudget::begin(const Budget& budget)
{
	m_budget = budget;
	m_coarsening = m_control.coarsening(budget);
	m_start = Clock::now();
	m_tests = m_keptTests = m_held = 0;
	m_cut = m_answered = 0;
	m_ofCut = 0;
	++m_step;
}

void StepBudget::end()
{
	const double tests = double(m_tests.load()), microseconds = microsecondsSince(m_start);
	m_control.observe({tests, microseconds, double(m_keptTests.load()), m_cut, m_answered, double(m_ofCut.load())});
	if (tests > 0) m_microsecondsATest = microseconds / tests;
}

// A query holds back its own tests itself, but no time.
Budget StepBudget::next(std::uint32_t held)
{
	const double withItsOwn = double(m_held.fetch_sub(held)), later = withItsOwn - held;
	Budget left;
	if (m_budget.tests < kOff) left.tests = std::max(0.0, m_budget.tests - double(m_tests.load()) - later);
	if (m_budget.microseconds < kOff)
		left.microseconds =
			std::max(0.0, m_budget.microseconds - microsecondsSince(m_start) - withItsOwn * m_microsecondsATest);
	return left;
}

void StepBudget::spend(std::uint64_t tests, bool isCut)
{
	m_tests += tests;
	if (isCut) m_ofCut += tests;
	++(isCut ? m_cut : m_answered);
}
}  // namespace clod
