// SPDX-License-Identifier: GPL-3.0-or-later
// Walks through a text file in memory line by line and word by word; numbers are read without locale.
#pragma once
#include <string>
#include <string_view>

#include "builder/intake/Soup.h"

namespace clod::builder
{
class TextCursor
{
public:
	enum class Lines
	{
		end,
		goOnAfterBackslash  // what follows on the next line belongs to this one
	};
	explicit TextCursor(std::string_view text, Lines lines = Lines::end) : m_rest(text), m_lines(lines) {}
	// Goes to the next line (LF, CRLF or CR ends one); false at the end of the text.
	bool nextLine();
	// Goes to the next line with a word before any '#'; false at the end of the text.
	bool nextLineWithContent();
	// The next word of this line, empty at its end. Words are separated by blanks, tabs, vertical tabs and form feeds,
	// and by a backslash where lines go on.
	std::string_view word();
	// The next word of the text, whatever its line; empty at the end of the text.
	std::string_view wordAnywhere();
	// The words as numbers; refuses with the line where there is none. Too large a number becomes infinite.
	double number(std::string_view word) const;
	long long integer(std::string_view word) const;
	std::string_view rest() const { return m_rest; }  // the text after this line
	[[noreturn]] void refuse(const std::string& what) const;
	std::string place() const;  // "line 12"

private:
	bool goesOnAfter(std::size_t end) const;
	void dropComment() { m_line = m_line.substr(0, m_line.find('#')); }

	std::string_view m_rest;
	Lines m_lines;
	std::string_view m_line;
	std::size_t m_lineNumber = 0;
};
}  // namespace clod::builder
