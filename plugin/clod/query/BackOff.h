// SPDX-License-Identifier: Zlib
// Exponential back-off: what was tried in vain is left be twice as long each time, up to a limit.
#pragma once
#include <algorithm>
#include <cstdint>

namespace clod
{
class BackOff
{
public:
	explicit BackOff(std::uint32_t most) : m_most(most) {}
	// Asked once a turn: may it be tried?
	bool isOver()
	{
		if (m_waits == 0) return true;
		--m_waits;
		return false;
	}
	void succeed() { m_turns = m_waits = 0; }
	void fail() { m_waits = m_turns = std::min(2 * m_turns + 1, m_most); }

private:
	std::uint32_t m_most, m_turns = 0, m_waits = 0;
};
}  // namespace clod
