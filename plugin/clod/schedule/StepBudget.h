// SPDX-License-Identifier: Zlib
// One budget for all pairs of a step: one coarsening for all of them, chosen before the step (BudgetControl.h), and what
// is left to each query before it gives its coarsest answer instead. So much is held back for the coarsest answers still
// to come as they cost last: a step exceeds its tests only by what these have grown. Several threads may spend at once.
#pragma once
#include <atomic>

#include "clod/Export.h"
#include "clod/query/BudgetControl.h"

namespace clod
{
class CLOD_API StepBudget
{
public:
	// reserve: tests of the coarsest answers of all pairs.
	void begin(const Budget& budget, std::uint64_t reserve);
	void end();
	std::uint64_t step() const { return m_step; }
	double coarsening() const { return m_coarsening; }
	bool isLimited() const { return m_budget.isLimited(); }
	bool isCounted() const { return m_budget.tests < kOff; }
	bool isOf(const Budget& budget) const
	{
		return m_budget.tests == budget.tests && m_budget.microseconds == budget.microseconds;
	}
	// Of a pair whose coarsest answer takes so many tests.
	Budget next(std::uint32_t coarsest);
	void spend(std::uint64_t tests, bool isCut);
	// Of one that keeps its answer.
	void keep(std::uint64_t tests, std::uint32_t coarsest);

private:
	BudgetControl m_control;
	Budget m_budget;
	double m_coarsening = 1;
	std::uint64_t m_step = 1;
	Clock::time_point m_start;
	double m_microsecondsATest = 0;  // of the last step
	std::atomic<std::uint64_t> m_tests{0}, m_keptTests{0};
	std::atomic<std::int64_t> m_reserve{0};
	std::atomic<bool> m_isCut{false};
};
}  // namespace clod
