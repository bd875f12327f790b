// SPDX-License-Identifier: Zlib
// What a query, or all queries of a step, may cost.
#pragma once
#include <chrono>
#include <cstdint>
#include <string>

#include "clod/Export.h"
#include "clod/query/Metric.h"

namespace clod
{
// What budgets of time and reports are measured with.
using Clock = std::chrono::steady_clock;
inline double microsecondsBetween(Clock::time_point start, Clock::time_point end)
{
	return std::chrono::duration<double, std::micro>(end - start).count();
}
inline double microsecondsSince(Clock::time_point start)
{
	return microsecondsBetween(start, Clock::now());
}

// Tests are box tests and hull distances up to the contact list; searching the depth of an overlap is not counted. Time
// is wall time from the start, or by another clock of the caller's. kOff means no limit.
struct Budget
{
	double tests = kOff;
	double microseconds = kOff;
	Clock::time_point (*now)() = &Clock::now;
	double since(Clock::time_point start) const { return microsecondsBetween(start, now()); }
	bool isLimited() const { return tests < kOff || microseconds < kOff; }
};
// Empty, or one sentence that names the first field that cannot be used, and its value.
CLOD_API std::string budgetError(const Budget& budget);

// A budget while it is spent.
class WorkLimit
{
public:
	explicit WorkLimit(const Budget& budget) : m_budget(budget)
	{
		if (budget.microseconds < kOff) m_start = budget.now();
	}
	bool isSet() const { return m_budget.isLimited(); }
	// For what comes when it is spent.
	void holdBack(std::uint64_t tests) { m_budget.tests -= double(tests); }
	// May so many tests have been done, and is there time left?
	bool allows(std::uint64_t tests) const { return allowsTests(tests) && hasTime(); }
	bool allowsTests(std::uint64_t tests) const { return double(tests) <= m_budget.tests; }
	bool hasTime() const
	{
		return !(m_budget.microseconds < kOff) || m_budget.since(m_start) < m_budget.microseconds;
	}

private:
	Budget m_budget;
	Clock::time_point m_start;
};
}  // namespace clod
