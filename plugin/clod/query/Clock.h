// SPDX-License-Identifier: Zlib
// What budgets of time and reports are measured with.
#pragma once
#include <chrono>

namespace clod
{
using Clock = std::chrono::steady_clock;
inline double microsecondsBetween(Clock::time_point start, Clock::time_point end)
{
	return std::chrono::duration<double, std::micro>(end - start).count();
}
inline double microsecondsSince(Clock::time_point start)
{
	return microsecondsBetween(start, Clock::now());
}
}  // namespace clod
