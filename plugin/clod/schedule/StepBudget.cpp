// SPDX-License-Identifier: Zlib
#include "clod/schedule/StepBudget.h"

#include <algorithm>

namespace clod
{
namespace
{
constexpr double kClockRoom = 0.2;  // of a budget, that is not spent on what could wait: times scatter
// Of a budget, for coarsest answers: those that alone take more would never become finer.
constexpr double kMostHeld = 0.5;
constexpr double kOfLast = 0.2, kForgotten = 0.05;  // of what refining takes: by one more, and a step
// In tests, that took 0.09 to 0.3 us: what all points of a pair take, and one more pair of nodes, or facet (1.3 to
// 2.8 us).
constexpr std::size_t kOfPoints = 50, kOfOne = 10;
constexpr double kMostSlower = 2;  // times: what a step took longer than its work tells nothing of the coarsening
}  // namespace

std::uint32_t worthOfPoints(std::size_t pairs, std::size_t facets)
{
	return std::uint32_t(kOfPoints + kOfOne * (pairs + facets));
}

void StepBudget::begin(const Budget& budget)
{
	m_budget = budget;
	m_coarsening = m_control.coarsening(budget);
	m_start = m_spareEnd = m_budget.now();
	m_isSpent = m_areQueriesOver = false;
	m_tests = m_held = m_spareTests = 0;
	m_points = m_heldPoints = m_sparePoints = 0;
	m_spareMicroseconds = 0;
	m_ofOneSpare *= 1 - kForgotten;
	m_cut = m_answered = 0;
	m_ofCut = 0;
	++m_step;
}

void StepBudget::end()
{
	const double tests = double(m_tests.load() - m_spareTests), done = work();
	double microseconds = m_budget.since(m_start) - m_spareMicroseconds;
	if (m_work > 0) microseconds = std::min(microseconds, kMostSlower * ofWork() * done);
	m_control.observe({tests, microseconds, m_cut, m_answered, double(m_ofCut.load())});
	m_microseconds += microseconds - kOfLast * m_microseconds;
	m_work += done - kOfLast * m_work;
	m_lastTests = tests;
	m_lastWork = done;
	m_afterSpare = m_budget.since(m_spareEnd);
	if (m_areQueriesOver) m_afterQueries = m_afterSpare;
}

Budget StepBudget::without(double tests, double microseconds) const
{
	Budget left{kOff, kOff, m_budget.now};
	if (m_budget.tests < kOff) left.tests = std::max(0.0, m_budget.tests - double(m_tests.load()) - tests);
	if (m_budget.microseconds < kOff)
		left.microseconds = std::max(0.0, m_budget.microseconds - m_budget.since(m_start) - microseconds);
	return left;
}

// A query holds back its own tests itself, but no time. Of time that of all coarsest answers to come is held back, with
// their points, and of what the dispatch does after them.
Budget StepBudget::next(const Work& held, std::uint32_t points)
{
	const double tests = double(m_held.fetch_sub(held.tests)), ofPoints = double(m_heldPoints.fetch_sub(held.points));
	const double withItsOwn = tests + ofPoints, toCome = withItsOwn * std::max(ofWork(), m_ofHeld) + m_afterQueries;
	const double ofIts = (double(points) - double(held.points)) * ofWork();
	const Budget left =
		without(tests - held.tests, std::min(toCome + std::max(0.0, ofIts), kMostHeld * m_budget.microseconds));
	if (left.microseconds == 0 && !m_isSpent.exchange(true))
	{
		m_spentAt = m_budget.now();
		m_heldWhenSpent = withItsOwn;
	}
	return left;
}

double StepBudget::ofWork() const
{
	if (m_work > 0) return m_microseconds / m_work;
	const double done = work();
	return done > 0 ? m_budget.since(m_start) / done : 0;
}

void StepBudget::noneToCome()
{
	m_lastTests = m_lastWork = 0;
	m_spareEnd = m_budget.now();
	m_areQueriesOver = true;
	if (m_isSpent && m_heldWhenSpent > 0)
		m_ofHeld = microsecondsBetween(m_spentAt, m_spareEnd) / m_heldWhenSpent;
}

// Of time what is sure to be left: points are found besides, and the dispatch goes on.
Budget StepBudget::spare()
{
	m_spareStart = m_budget.now();
	m_pointsBefore = m_points;
	const double toCome = std::max(0.0, m_lastTests - double(m_tests.load() - m_spareTests));
	const double others = double(m_held.load()) + toCome;
	const double workToCome = double(m_held.load() + m_heldPoints.load()) + std::max(0.0, m_lastWork - work());
	Budget left = without(others, workToCome * ofWork());
	if (m_budget.microseconds < kOff)
		left.microseconds =
			std::max(0.0, left.microseconds - m_afterSpare - m_ofOneSpare - kClockRoom * m_budget.microseconds);
	return left;
}

void StepBudget::endSpare()
{
	m_spareEnd = m_budget.now();
	m_sparePoints += m_points - m_pointsBefore;
	const double microseconds = microsecondsBetween(m_spareStart, m_spareEnd);
	m_spareMicroseconds += microseconds;
	m_ofOneSpare += kOfLast * (microseconds - m_ofOneSpare);
}

void StepBudget::spendSpare(std::uint64_t tests)
{
	m_tests += tests;
	m_spareTests += tests;
}

void StepBudget::spend(std::uint64_t tests, bool isCut)
{
	m_tests += tests;
	if (isCut) m_ofCut += tests;
	++(isCut ? m_cut : m_answered);
}
}  // namespace clod
