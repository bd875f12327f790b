// SPDX-License-Identifier: Zlib
// The nearest match for a mistyped word.
#pragma once
#include <string>
#include <vector>

namespace clod::cli
{
// The candidate with the fewest insertions, deletions, substitutions and swaps of neighbours; empty when none is within
// a third of the word's length (at least 2). Ties go to the first.
std::string nearest(const std::string& word, const std::vector<std::string>& candidates);

// "; did you mean X?" or nothing.
std::string didYouMean(const std::string& word, const std::vector<std::string>& candidates);
}  // namespace clod::cli
