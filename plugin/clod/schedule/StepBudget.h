// SPDX-License-Identifier: Zlib
// One budget for all pairs of a step: one coarsening for all of them, chosen before the step (BudgetControl.h), and what
// is left to each query before it gives its coarsest answer instead. What the coarsest answers still to come take is held
// back: a step never exceeds its tests unless these alone do. Several threads may spend at once.
#pragma once
#include <algorithm>
#include <atomic>

#include "clod/Export.h"
#include "clod/schedule/BudgetControl.h"

namespace clod
{
class CLOD_API StepBudget
{
public:
	void begin(const Budget& budget);
	void end();
	std::uint64_t step() const { return m_step; }
	double coarsening() const { return m_coarsening; }
	bool isLimited() const { return m_budget.isLimited(); }
	bool isCounted() const { return m_budget.tests < kOff; }
	bool isOf(const Budget& budget) const
	{
		return m_budget.tests == budget.tests && m_budget.microseconds == budget.microseconds;
	}
	// For the coarsest answer of a pair to come.
	void hold(std::uint32_t tests) { m_held += tests; }
	void release(std::uint32_t tests) { m_held -= tests; }
	// Of a pair for which so much was held.
	Budget next(std::uint32_t held);
	void list(std::uint64_t tests) { m_tests += tests; }  // of its coarsest answer
	void spend(std::uint64_t tests, bool isCut);
	// Of one that keeps its answer, of a factor that may be finer: with this step's it would take less.
	void keep(std::uint64_t tests, double coarsening)
	{
		m_keptTests += std::uint64_t(double(tests) * std::min(1.0, coarsening / m_coarsening));
	}

private:
	BudgetControl m_control;
	Budget m_budget;
	double m_coarsening = 1;
	std::uint64_t m_step = 1;
	Clock::time_point m_start;
	double m_microsecondsATest = 0;  // of the last step
	std::atomic<std::uint64_t> m_tests{0}, m_keptTests{0};
	std::atomic<std::uint64_t> m_held{0};
	std::atomic<std::uint32_t> m_answered{0}, m_cut{0};
	std::atomic<std::uint64_t> m_ofCut{0};
};
}  // namespace clod
