// SPDX-License-Identifier: GPL-3.0-or-later
// Which of many indices a search has met, forgotten at no cost when the next search begins.
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace clod::builder
{
class VisitMarks
{
public:
	// Nothing is marked.
	void restart(std::size_t count)
	{
		if (m_marks.size() != count || m_search == std::numeric_limits<std::uint32_t>::max())
		{
			m_marks.assign(count, 0);
			m_search = 0;
		}
		++m_search;
	}
	bool has(std::size_t i) const { return m_marks[i] == m_search; }
	// Marks i; whether it was not marked before.
	bool add(std::size_t i)
	{
		if (m_marks[i] == m_search) return false;
		m_marks[i] = m_search;
		return true;
	}

private:
	std::vector<std::uint32_t> m_marks;  // the search that last met each
	std::uint32_t m_search = 0;
};
}  // namespace clod::builder
