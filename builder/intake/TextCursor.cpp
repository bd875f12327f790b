// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/intake/TextCursor.h"

#include <fmt/format.h>

#include <charconv>
#include <limits>

namespace clod::builder
{
namespace
{
constexpr std::string_view kBlanks = " \t\v\f";

std::string quoted(std::string_view word)
{
	constexpr std::size_t kShown = 40;
	std::string text(word.substr(0, kShown));
	for (char& c : text)
		if (c < ' ' || c > '~') c = '?';
	return "'" + text + (word.size() > kShown ? "...'" : "'");
}

std::string_view withoutPlus(std::string_view word)
{
	if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
	return word;
}
}  // namespace

bool TextCursor::nextLine()
{
	if (m_rest.empty()) return false;
	const std::size_t end = m_rest.find_first_of("\r\n");
	m_line = m_rest.substr(0, end);
	const bool crLf = end != std::string_view::npos && m_rest.substr(end, 2) == "\r\n";
	m_rest.remove_prefix(end == std::string_view::npos ? m_rest.size() : end + (crLf ? 2 : 1));
	++m_lineNumber;
	return true;
}

bool TextCursor::nextLineWithContent()
{
	while (nextLine())
	{
		dropComment();
		if (m_line.find_first_not_of(kBlanks) != std::string_view::npos) return true;
	}
	return false;
}

// Whether a backslash, here or before blanks, is all that is left of the line.
bool TextCursor::goesOnAfter(std::size_t end) const
{
	return m_lines == Lines::goOnAfterBackslash && end < m_line.size() && m_line[end] == '\\' &&
		   m_line.find_first_not_of(kBlanks, end + 1) == std::string_view::npos;
}

std::string_view TextCursor::word()
{
	std::size_t begin = m_line.find_first_not_of(kBlanks);
	while (goesOnAfter(begin))
	{
		if (!nextLine()) m_line = {};
		dropComment();
		begin = m_line.find_first_not_of(kBlanks);
	}
	if (begin == std::string_view::npos)
	{
		m_line = {};
		return {};
	}
	m_line.remove_prefix(begin);
	std::string_view found = m_line.substr(0, m_line.find_first_of(kBlanks));
	if (goesOnAfter(found.size() - 1)) found.remove_suffix(1);
	m_line.remove_prefix(found.size());
	return found;
}

std::string_view TextCursor::wordAnywhere()
{
	std::string_view found = word();
	while (found.empty() && nextLine()) found = word();
	return found;
}

double TextCursor::number(std::string_view word) const
{
	const std::string_view digits = withoutPlus(word);
	double value = 0;
	const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
	if (error == std::errc::invalid_argument || end != digits.data() + digits.size())
		refuse(fmt::format("{} is not a number", quoted(word)));
	if (error == std::errc::result_out_of_range)
	{
		// Too small is zero to any precision we keep; too large is refused later, with its vertex.
		const bool small = digits.find("e-") != std::string_view::npos || digits.find("E-") != std::string_view::npos;
		return small ? 0 : std::numeric_limits<double>::infinity();
	}
	return value;
}

long long TextCursor::integer(std::string_view word) const
{
	const std::string_view digits = withoutPlus(word);
	long long value = 0;
	const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
	if (error != std::errc() || end != digits.data() + digits.size())
		refuse(fmt::format("{} is not an integer", quoted(word)));
	return value;
}

void TextCursor::refuse(const std::string& what) const
{
	throw Refused(Reason::syntax, place() + ": " + what);
}

std::string TextCursor::place() const
{
	return fmt::format("line {}", m_lineNumber);
}
}  // namespace clod::builder
