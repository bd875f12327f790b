// SPDX-License-Identifier: Zlib
// Progress on stderr: a bar with the time left when stderr is a terminal; else a line a phase when it ends, with its
// time, and how far it is every half minute. Warnings in between have lines of their own.
#pragma once
#include <chrono>
#include <cstdio>
#include <mutex>
#include <string>

namespace clod::cli
{
// May be called from several threads. Each phase runs from 0 to 1; a new phase name starts a new line.
class Progress
{
public:
	explicit Progress(bool quiet, std::FILE* stream = stderr);
	Progress(std::FILE* stream, bool terminal) : m_stream(stream), m_terminal(terminal) {}
	Progress(const Progress&) = delete;
	Progress& operator=(const Progress&) = delete;
	~Progress() { finish(); }
	void update(const std::string& phase, double fraction);
	// Ends the current phase; later output starts at the left margin.
	void finish();

private:
	using Clock = std::chrono::steady_clock;
	void say(const std::string& text);
	void drawBar(Clock::time_point now);
	void sayHowFar(Clock::time_point now);
	void endPhase(Clock::time_point now);

	std::mutex m_mutex;
	std::FILE* m_stream;
	bool m_terminal = false;
	bool m_quiet = false;
	std::string m_phase;  // none: empty
	double m_fraction = 0;
	Clock::time_point m_start, m_lastSaid;  // of the phase
};
}  // namespace clod::cli
