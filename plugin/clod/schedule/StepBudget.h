// SPDX-License-Identifier: Zlib
// One budget for all pairs of a step: one coarsening of all that move, chosen before the step (BudgetControl.h), and
// what is left to each query before it gives its coarsest answer instead. What the coarsest answers still to come take
// is held back: a step never exceeds its tests unless these alone do. Several threads may spend at once.
//
// Pairs that lie still keep the answers they have, be they finer or coarser, and cost nothing. What those that move
// leave refines them, the worst first: a pile comes down to the metric some pairs a step, where to ask all of them at
// once would cost many steps' budgets.
#pragma once
#include <atomic>

#include "clod/Export.h"
#include "clod/schedule/BudgetControl.h"

namespace clod
{
// What a pair takes of a step's time: the tests of its query, and its points at their worth in tests. A budget of tests
// is of the former alone.
struct Work
{
	std::uint32_t tests = 0, points = 0;
};
// What it takes to make points of so many accepted pairs of nodes and the facets found between them.
CLOD_API std::uint32_t worthOfPoints(std::size_t pairs, std::size_t facets);

class CLOD_API StepBudget
{
public:
	void begin(const Budget& budget);
	void end();
	std::uint64_t step() const { return m_step; }
	double coarsening() const { return m_coarsening; }
	bool isLimited() const { return m_budget.isLimited(); }
	bool buysAnything() const { return m_budget.tests > 0 && m_budget.microseconds > 0; }
	bool isCounted() const { return m_budget.tests < kOff; }
	bool isOf(const Budget& budget) const
	{
		return m_budget.tests == budget.tests && m_budget.microseconds == budget.microseconds;
	}
	// For the coarsest answer of a pair to come.
	void hold(const Work& work)
	{
		m_held += work.tests;
		m_heldPoints += work.points;
	}
	void release(const Work& work)
	{
		m_held -= work.tests;
		m_heldPoints -= work.points;
	}
	// Of a pair for which so much was held, and whose points will take about so much.
	Budget next(const Work& held, std::uint32_t points);
	void list(std::uint64_t tests) { m_tests += tests; }  // for its coarsest answer, or in vain
	void spend(std::uint64_t tests, bool isCut);
	void spendPoints(std::uint32_t points) { m_points += points; }
	// For one that lies still, from the first to the last of these, on one thread: what is left now but for what the
	// others will take by the last step (none are to come where all are answered); what it took tells nothing of the
	// coarsening.
	void noneToCome();
	bool isWholeSpare() const { return m_spareTests == 0; }
	Budget spare();
	void spendSpare(std::uint64_t tests);
	void endSpare();

private:
	// What is left but for so many tests and so much time.
	Budget without(double tests, double microseconds) const;
	double work() const { return double(m_tests.load() - m_spareTests) + double(m_points.load() - m_sparePoints); }
	// Microseconds that work takes, as far as it is known.
	double ofWork() const;

	BudgetControl m_control;
	Budget m_budget;
	double m_coarsening = 1;
	std::uint64_t m_step = 1;
	Clock::time_point m_start, m_spareStart, m_spareEnd, m_spentAt;
	// Of the last steps, fading; so what work takes is known by the steps that had much of it.
	double m_microseconds = 0, m_work = 0;
	double m_lastTests = 0, m_lastWork = 0, m_afterSpare = 0;  // of the last step; the latter in microseconds
	// The work of coarsest answers, by the last step whose time was spent before all were given; what a step took after
	// its queries. Microseconds.
	double m_ofHeld = 0, m_afterQueries = 0;
	double m_heldWhenSpent = 0;
	bool m_areQueriesOver = false;
	std::atomic<bool> m_isSpent{false};
	std::uint64_t m_spareTests = 0, m_sparePoints = 0, m_pointsBefore = 0;
	double m_spareMicroseconds = 0, m_ofOneSpare = 0;
	std::atomic<std::uint64_t> m_tests{0};
	std::atomic<std::uint64_t> m_points{0};  // at their worth
	std::atomic<std::uint64_t> m_held{0}, m_heldPoints{0};
	std::atomic<std::uint32_t> m_answered{0}, m_cut{0};
	std::atomic<std::uint64_t> m_ofCut{0};
};
}  // namespace clod
