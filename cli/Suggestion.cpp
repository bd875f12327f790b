// SPDX-License-Identifier: Zlib
#include "cli/Suggestion.h"

#include <algorithm>
#include <cstddef>

namespace clod::cli
{
namespace
{
// Optimal string alignment distance (Damerau-Levenshtein without overlapping swaps).
std::size_t editDistance(const std::string& a, const std::string& b)
{
	std::vector<std::vector<std::size_t>> cost(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
	for (std::size_t i = 0; i <= a.size(); ++i) cost[i][0] = i;
	for (std::size_t j = 0; j <= b.size(); ++j) cost[0][j] = j;
	for (std::size_t i = 1; i <= a.size(); ++i)
		for (std::size_t j = 1; j <= b.size(); ++j)
		{
			const std::size_t substitution = cost[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
			cost[i][j] = std::min({cost[i - 1][j] + 1, cost[i][j - 1] + 1, substitution});
			const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
			if (swapped) cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 1);
		}
	return cost[a.size()][b.size()];
}
}  // namespace

std::string nearest(const std::string& word, const std::vector<std::string>& candidates)
{
	if (word.size() > 200) return {};
	std::string best;
	std::size_t bestDistance = std::max<std::size_t>(2, word.size() / 3) + 1;
	for (const std::string& candidate : candidates)
	{
		const std::size_t distance = editDistance(word, candidate);
		if (distance < bestDistance)
		{
			best = candidate;
			bestDistance = distance;
		}
	}
	return best;
}

std::string didYouMean(const std::string& word, const std::vector<std::string>& candidates)
{
	const std::string match = nearest(word, candidates);
	return match.empty() ? "" : "; did you mean " + match + "?";
}
}  // namespace clod::cli
