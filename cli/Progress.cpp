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
constexpr std::chrono::seconds kSignOfLife{30};  // of a phase that lasts, where nothing is drawn

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
	const bool isNew = phase != m_phase;
	if (isNew)
	{
		endPhase(now);
		m_phase = phase;
		m_start = m_lastSaid = now;
	}
	m_fraction = std::clamp(fraction, 0.0, 1.0);
	if (m_terminal && (isNew || m_fraction == 1 || now - m_lastSaid >= kRedraw)) drawBar(now);
	if (!m_terminal && now - m_lastSaid >= kSignOfLife) sayHowFar(now);
}

void Progress::say(const std::string& text)
{
	fmt::print(m_stream, "{}", text);
	std::fflush(m_stream);
}

void Progress::drawBar(Clock::time_point now)
{
	m_lastSaid = now;
	const int filled = int(m_fraction * kBarWidth);
	const double elapsed = seconds(now - m_start);
	const std::string tail = m_fraction < 1 ? timeLeft(elapsed, m_fraction) : fmt::format("{:.1f} s", elapsed);
	say(fmt::format("\r{:<24} [{:#<{}}{:.<{}}] {:3.0f} %  {:<20}", m_phase, "", filled, "", kBarWidth - filled,
					100 * m_fraction, tail));
}

void Progress::sayHowFar(Clock::time_point now)
{
	m_lastSaid = now;
	const std::string left = timeLeft(seconds(now - m_start), m_fraction);
	say(fmt::format("{}: {:.0f} %{}{}\n", m_phase, 100 * m_fraction, left.empty() ? "" : ", ", left));
}

void Progress::endPhase(Clock::time_point now)
{
	if (m_phase.empty()) return;
	say(m_terminal ? "\n" : fmt::format("{}: {:.1f} s\n", m_phase, seconds(now - m_start)));
	m_phase.clear();
}

void Progress::finish()
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	endPhase(Clock::now());
}
}  // namespace clod::cli
