// SPDX-License-Identifier: Zlib
#include "cli/Progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace clod::cli
{
namespace
{
constexpr int kBarWidth = 30;
constexpr std::chrono::milliseconds kRedraw{100};

double seconds(std::chrono::steady_clock::duration d)
{
	return std::chrono::duration<double>(d).count();
}

std::string timeLeft(double elapsed, double fraction)
{
	if (fraction < 0.02 || elapsed < 0.5) return "";
	const double left = elapsed * (1 - fraction) / fraction;
	if (left >= 60) return fmt::format("{:.0f} min {:02.0f} s left", std::floor(left / 60), std::fmod(left, 60));
	return fmt::format("{:.0f} s left", left);
}
}  // namespace

Progress::Progress(bool quiet, std::FILE* stream)
	: m_stream(stream), m_terminal(isatty(fileno(stream)) != 0), m_quiet(quiet)
{
}

void Progress::update(const std::string& phase, double fraction)
{
	if (m_quiet) return;
	const std::lock_guard<std::mutex> lock(m_mutex);
	const Clock::time_point now = Clock::now();
	if (phase != m_phase)
	{
		finishLine();
		m_phase = phase;
		m_start = now;
		m_lastDrawn = {};
		m_lastTenth = -1;
	}
	fraction = std::clamp(fraction, 0.0, 1.0);
	if (m_terminal)
		drawBar(fraction, now);
	else
		printLine(fraction, now);
}

void Progress::drawBar(double fraction, Clock::time_point now)
{
	if (fraction < 1 && now - m_lastDrawn < kRedraw) return;
	m_lastDrawn = now;
	const int filled = int(fraction * kBarWidth);
	const double elapsed = seconds(now - m_start);
	const std::string tail = fraction < 1 ? timeLeft(elapsed, fraction) : fmt::format("{:.1f} s", elapsed);
	fmt::print(m_stream, "\r{:<24} [{:#<{}}{:.<{}}] {:3.0f} %  {:<20}", m_phase, "", filled, "", kBarWidth - filled,
			   100 * fraction, tail);
	std::fflush(m_stream);
	m_lineOpen = true;
}

void Progress::printLine(double fraction, Clock::time_point now)
{
	const int tenth = int(10 * fraction + 1e-9);
	if (tenth <= m_lastTenth) return;
	m_lastTenth = tenth;
	const std::string left = fraction < 1 ? timeLeft(seconds(now - m_start), fraction) : "";
	fmt::print(m_stream, "{}: {} %  {:.1f} s{}{}\n", m_phase, 10 * tenth, seconds(now - m_start),
			   left.empty() ? "" : ", ", left);
	std::fflush(m_stream);
}

void Progress::finishLine()
{
	if (m_lineOpen) fmt::print(m_stream, "\n");
	m_lineOpen = false;
}

void Progress::finish()
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	finishLine();
}
}  // namespace clod::cli
