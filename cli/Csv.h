// SPDX-License-Identifier: Zlib
// Fields of comma-separated files (RFC 4180).
#pragma once
#include <string>

namespace clod::cli
{
// A text that may hold commas or quotes.
inline std::string quotedField(const std::string& text)
{
	std::string field = "\"";
	for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
	return field + "\"";
}
}  // namespace clod::cli
