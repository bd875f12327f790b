// SPDX-License-Identifier: Zlib
#include "clod/schedule/StepBudget.h"

#include <algorithm>

namespace clod
{
void StepBudget::begin(const Budget& budget, std::uint64_t reserve)
{
	m_budget = budget;
	m_coarsening = m_control.coarsening(budget);
	m_start = Clock::now();
	m_tests = m_keptTests = 0;
	m_reserve = std::int64_t(reserve);
	m_isCut = false;
	++m_step;
}

void StepBudget::end()
{
	const double tests = double(m_tests.load()), microseconds = microsecondsSince(m_start);
	m_control.observe({tests, microseconds, double(m_keptTests.load()), m_isCut});
	if (tests > 0) m_microsecondsATest = microseconds / tests;
}

Budget StepBudget::next(std::uint32_t coarsest)
{
	const double later = double(std::max<std::int64_t>(0, m_reserve.fetch_sub(coarsest)));
	const double most = std::max(later, double(coarsest));  // with its own
	Budget left;
	if (m_budget.tests < kOff) left.tests = std::max(0.0, m_budget.tests - double(m_tests.load()) - most);
	if (m_budget.microseconds < kOff)
		left.microseconds =
			std::max(0.0, m_budget.microseconds - microsecondsSince(m_start) - most * m_microsecondsATest);
	return left;
}

void StepBudget::spend(std::uint64_t tests, bool isCut)
{
	m_tests += tests;
	if (isCut) m_isCut = true;
}

void StepBudget::keep(std::uint64_t tests, std::uint32_t coarsest)
{
	m_keptTests += tests;
	m_reserve -= coarsest;
}
}  // namespace clod
