// SPDX-License-Identifier: Zlib
// How long to leave be what was tried in vain: twice as long each time, up to a limit.
#pragma once
#include <algorithm>
#include <cstdint>

namespace clod
{
class Patience
{
public:
	explicit Patience(std::uint32_t most) : m_most(most) {}
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
