// SPDX-License-Identifier: Zlib
// How long something took: by the clock, or by what this thread had of the processor, so that a busy machine does not
// count.
#pragma once
#include <time.h>

namespace clod::demo
{
enum class TimedBy
{
	clock,
	thread
};

class Stopwatch
{
public:
	explicit Stopwatch(TimedBy by) : m_clock(by == TimedBy::thread ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC), m_start(now()) {}
	double microseconds() const { return now() - m_start; }

private:
	double now() const
	{
		timespec time{};
		clock_gettime(m_clock, &time);
		return 1e6 * double(time.tv_sec) + 1e-3 * double(time.tv_nsec);
	}
	clockid_t m_clock;
	double m_start;
};
}  // namespace clod::demo
