// SPDX-License-Identifier: Zlib
#include "demos/extremes/Swing.h"

#include <algorithm>
#include <cmath>

namespace clod::demo
{
namespace
{
// Times of zero crossings from one side.
class Crossings
{
public:
	void add(double time, double angle)
	{
		const bool crosses = m_hasLast && m_last < 0 && angle >= 0;
		if (crosses) m_times.push_back(time - (time - m_time) * angle / (angle - m_last));
		m_last = angle;
		m_time = time;
		m_hasLast = true;
	}
	double period() const
	{
		if (m_times.size() < 2) return std::nan("");
		return (m_times.back() - m_times.front()) / double(m_times.size() - 1);
	}

private:
	std::vector<double> m_times;
	double m_last = 0, m_time = 0;
	bool m_hasLast = false;
};
}  // namespace

double swingPeriod(double smallRate, double amplitude)
{
	double a = 1, g = std::cos(amplitude / 2);
	for (int i = 0; i < 6; ++i)
	{
		const double mean = (a + g) / 2;
		g = std::sqrt(a * g);
		a = mean;
	}
	return 2 * kPi / smallRate / a;
}

Swing watchSwing(Stage& stage, double expected, int periods, const std::function<double()>& angle)
{
	Crossings crossings;
	double first = 0, last = 0;
	const double start = stage.state().time, wholeTime = expected * periods;
	stage.watch(wholeTime,
				[&]
				{
					const double time = stage.state().time - start, now = angle();
					crossings.add(time, now);
					if (time < expected) first = std::max(first, std::fabs(now));
					if (time >= wholeTime - expected) last = std::max(last, std::fabs(now));
					return true;
				});
	return {crossings.period(), last / first - 1};
}
}  // namespace clod::demo
